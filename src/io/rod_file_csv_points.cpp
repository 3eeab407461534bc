// Files of rods as text, with a row per point and a column that names its rod.
#include "io/csv_header.hpp"
#include "io/csv_table.hpp"
#include "io/point_file.hpp"
#include "io/rod_file_kind.hpp"
#include "parallel/pieces.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <unordered_map>

namespace skein {

namespace {

class CsvPointFile final : public PointFile {
public:
    CsvPointFile(const CsvHeader& header, const RodFileOptions& options)
        : PointFile(header.path, options.elements, options.placement.unit), header_(header) {
        find_columns(options.placement.unit);
        find_rows();
        sort_rows();
    }

private:
    /// Consecutive rows of one rod.
    struct Run {
        std::int64_t rod, offset, line, rows;
    };
    enum Quantity : std::size_t { x, y, z, radius, nx, ny, nz, all };
    static constexpr std::array<std::string_view, all> names = {"x", "y", "z", "radius", "nx", "ny", "nz"};
    static constexpr std::size_t most_runs = 1 << 24; // half a gigabyte of them

    /// `given`: unit of columns without one, m.
    void find_columns(double given) {
        scale_.fill(1);
        column_.fill(CsvHeader::none);
        for (std::size_t c = 0; c < header_.plain.size(); ++c) {
            std::string_view name = header_.plain[c];
            if (name.empty() || c == header_.id) continue;
            if (name.starts_with("position_")) name.remove_prefix(9);
            const bool diameter = name == "diameter";
            const auto found = std::find(names.begin(), names.end(), diameter ? "radius" : name);
            if (found == names.end())
                header_.refuse(fmt::format("unknown column '{}'; a row per point has '{}' and x, y, z, radius or "
                                           "diameter, nx, ny, nz; placement.ignore skips others",
                                           shown(header_.names[c]), shown(header_.names[header_.id])));
            std::size_t& column = nth(column_, found - names.begin());
            if (column != CsvHeader::none)
                header_.refuse(fmt::format("two columns for {}: '{}' and '{}'", *found, shown(header_.names[column]),
                                           shown(header_.names[c])));
            column = c;
            const std::size_t q = to_index(found - names.begin());
            if (q >= nx) header_.refuse_unit(c);
            scale_[q] = (diameter ? 0.5 : 1) * header_.over(c, given);
        }
        if (header_.id != CsvHeader::none) header_.refuse_unit(header_.id);
        for (const Quantity q : {x, y})
            if (column_[q] == CsvHeader::none) header_.refuse(fmt::format("column '{}' is missing", names[q]));
        const auto normals = std::count(column_.begin() + nx, column_.end(), CsvHeader::none);
        if (normals != 0 && normals != 3) header_.refuse("the normal has not all of three columns: nx, ny, nz");
        radii_ = column_[radius] != CsvHeader::none;
        normals_ = normals == 0;
    }

    /// Finds where the rows of each rod lie. Rods have numbers in the order of their first rows.
    void find_rows() {
        std::unordered_map<std::string, std::int64_t> number_of;
        TextLines lines(path_, header_.past, header_.line + 1);
        std::string_view line;
        std::string present;
        bool any = false;
        while (lines.next(line)) {
            if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
            const auto id = cell_of(line, header_.separator, header_.id);
            if (!id || id->empty())
                throw InputError(fmt::format("{}: '{}', which names the rod, is {}", lines.place(),
                                             shown(header_.names[header_.id]), id ? "empty" : "missing"));
            if (any && *id == present) {
                ++runs_.back().rows;
                continue;
            }
            present = *id;
            any = true;
            if (runs_.size() == most_runs)
                throw InputError(fmt::format("{}: rows change from rod to rod more than {} times: sort them by '{}'",
                                             lines.place(), most_runs, shown(header_.names[header_.id])));
            const auto [at, added] = number_of.try_emplace(present, count_);
            if (added) ++count_;
            runs_.push_back({at->second, lines.offset(), lines.line(), 1});
        }
        if (count_ == 0) refuse("it contains no rods");
    }

    void sort_rows() {
        if (static_cast<std::int64_t>(runs_.size()) != count_)
            std::stable_sort(runs_.begin(), runs_.end(), [](const Run& a, const Run& b) { return a.rod < b.rod; });
        first_run_.reserve(to_index(count_) + 1);
        for (std::size_t r = 0; r < runs_.size(); ++r)
            if (r == 0 || runs_[r].rod != runs_[r - 1].rod) first_run_.push_back(r);
        first_run_.push_back(runs_.size());
    }

    void read_points(std::int64_t begin, std::int64_t end, const Threads* threads,
                     const TakeRods& take) const override {
        RodPoints points;
        std::vector<std::unique_ptr<TextLines>> lines(threads_in(threads));
        for (auto& of_thread : lines) of_thread = std::make_unique<TextLines>(path_);
        std::vector<std::int64_t> first_point;
        for (std::int64_t first = begin; first < end;) {
            first_point.assign(1, 0);
            std::int64_t past = first;
            while (past < end && (past == first || first_point.back() < most_points))
                first_point.push_back(first_point.back() + rows_of(past++));
            make_room(points, first_point);
            read_rods(threads, lines, first, past, points);
            take(first, points);
            first = past;
        }
    }

    std::int64_t rows_of(std::int64_t rod) const {
        std::int64_t rows = 0;
        for (std::size_t r = nth(first_run_, rod); r < nth(first_run_, rod + 1); ++r) rows += runs_[r].rows;
        return rows;
    }

    /// Reads rows in the order of the file, which is that of the rods unless rows of several rods alternate.
    void read_rods(const Threads* threads, std::span<std::unique_ptr<TextLines>> lines, std::int64_t first,
                   std::int64_t past, RodPoints& points) const {
        constexpr std::size_t piece = 1 << 10;
        struct Place {
            Run run;
            std::size_t at; ///< point of its first row
        };
        std::vector<Place> runs;
        for (std::int64_t rod = first; rod < past; ++rod) {
            std::size_t at = nth(points.first, rod - first);
            for (std::size_t r = nth(first_run_, rod); r < nth(first_run_, rod + 1); ++r) {
                runs.push_back({runs_[r], at});
                at += to_index(runs_[r].rows);
            }
        }
        std::sort(runs.begin(), runs.end(), [](const Place& a, const Place& b) { return a.run.offset < b.run.offset; });
        in_pieces(threads, runs.size(), piece,
                  [&](std::size_t begin, std::size_t end, std::size_t thread, std::size_t) {
                      for (std::size_t r = begin; r < end; ++r)
                          read_run(*lines[thread], runs[r].run, points, runs[r].at);
                  });
    }

    void read_run(TextLines& lines, const Run& run, RodPoints& points, std::size_t at) const {
        lines.seek(run.offset, run.line);
        std::string_view line;
        std::vector<std::string_view> cells;
        for (std::int64_t row = 0; row < run.rows; ++row, ++at) {
            do {
                if (!lines.next(line)) refuse("it has been cut short while it was read");
            } while (line.find_first_not_of(" \t") == std::string_view::npos);
            if (!split(line, header_.separator, cells))
                throw InputError(fmt::format("{}: a quote is not closed, or has text behind it", lines.place()));
            if (cells.size() != header_.names.size())
                throw InputError(fmt::format("{}: expected {} values by the line of names, found {}", lines.place(),
                                             header_.names.size(), cells.size()));
            std::array<double, all> value{};
            for (std::size_t q = 0; q < all; ++q) {
                if (column_[q] == CsvHeader::none) continue;
                const std::optional<double> number = csv_number(cells[column_[q]]);
                if (!number)
                    throw InputError(fmt::format("{}: {}: {}", lines.place(), shown(header_.names[column_[q]]),
                                                 not_a_number(cells[column_[q]])));
                value[q] = scale_[q] * *number;
            }
            points.points[at] = {value[x], value[y], value[z]};
            if (radii_) points.radii[at] = value[radius];
            if (normals_) points.normals[at] = {value[nx], value[ny], value[nz]};
        }
    }

    /// Line of a point. Only messages ask for it.
    std::string place(std::int64_t rod, std::int64_t point) const override {
        std::size_t r = nth(first_run_, rod);
        for (point = std::max<std::int64_t>(point, 0); r + 1 < nth(first_run_, rod + 1) && point >= runs_[r].rows; ++r)
            point -= runs_[r].rows;
        TextLines lines(path_, runs_[r].offset, runs_[r].line);
        std::string_view line;
        while (point >= 0 && lines.next(line))
            if (line.find_first_not_of(" \t") != std::string_view::npos) --point;
        return fmt::format("{}, {}", lines.place(), name(rod));
    }
    std::string name(std::int64_t rod) const override {
        const Run& run = runs_[nth(first_run_, rod)];
        TextLines lines(path_, run.offset, run.line);
        std::string_view line;
        lines.next(line);
        return fmt::format("{} '{}'", shown(header_.names[header_.id]),
                           shown(cell_of(line, header_.separator, header_.id).value_or("")));
    }

    CsvHeader header_;
    std::array<std::size_t, all> column_{};
    std::array<double, all> scale_{};    ///< number in the unit of the scene over the number in the column
    std::vector<Run> runs_;              ///< by rod, and of a rod in the order of the file
    std::vector<std::size_t> first_run_; ///< of each rod, and their number
};

} // namespace

std::shared_ptr<const RodSource> open_csv_points(const CsvHeader& header, const RodFileOptions& options) {
    return std::make_shared<CsvPointFile>(header, options);
}

} // namespace skein
