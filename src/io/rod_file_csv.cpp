// Files of rods as text, with a row per rod, whose first line names the columns.
#include "io/csv_table.hpp"
#include "io/rod_file_kind.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace skein {

namespace {

class CsvRodFile final : public RodFile {
public:
    CsvRodFile(const CsvHeader& header, const RodFileOptions& options)
        : RodFile(header.path, options.placement.unit), header_(header) {
        find_columns(options.placement.unit);
        TextLines lines(path_, header.past, header.line + 1);
        std::string_view line;
        while (lines.next(line)) {
            if (is_empty(line)) continue;
            if (count_ % block == 0) blocks_.push_back({lines.offset(), lines.line()});
            ++count_;
        }
        check_quantities();
    }

private:
    static constexpr std::int64_t block = 1 << 12;

    static bool is_empty(std::string_view line) { return line.find_first_not_of(" \t") == std::string_view::npos; }

    /// `given`: unit of columns without one, m.
    void find_columns(double given) {
        scale_.assign(header_.names.size(), 1);
        column_.assign(header_.names.size(), skipped);
        for (std::size_t c = 0; c < column_.size(); ++c) {
            const std::string& name = header_.plain[c];
            if (name.empty()) continue;
            for (std::size_t q = 0; q < std::size(quantities); ++q)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    if (quantities[q].columns[axis] == name) column_[c] = {q, axis};
            if (column_[c] == skipped)
                header_.refuse(fmt::format(
                    "unknown column '{}'; a row per rod has x, y, z and, if rods differ in them, tx, ty, tz, nx, ny, "
                    "nz, length, radius; a row per point has a column that names its rod, such as 'filament' or 'id'",
                    shown(header_.names[c])));
            const std::size_t q = column_[c].first;
            if (q == tangent || q == normal) header_.refuse_unit(c);
            scale_[c] = header_.over(c, given);
        }
        for (std::size_t q = 0; q < std::size(quantities); ++q) {
            const auto axes =
                std::count_if(column_.begin(), column_.end(), [q](const auto& c) { return c.first == q; });
            if (axes != 0 && axes != static_cast<std::ptrdiff_t>(quantities[q].components))
                header_.refuse(fmt::format("{} has only {} of three columns: {}", quantities[q].name, axes,
                                           fmt::join(quantities[q].columns, ", ")));
            has_[q] = axes != 0;
        }
    }

    void read_numbers(std::int64_t begin, std::int64_t end, Numbers& numbers) const override {
        const auto [offset, number] = nth(blocks_, begin / block);
        TextLines lines(path_, offset, number);
        std::string_view line;
        std::vector<std::string_view> cells;
        for (std::int64_t rod = begin / block * block; rod < end; ++rod) {
            do {
                if (!lines.next(line)) refuse(fmt::format("row {}: the file has been cut short", rod));
            } while (is_empty(line));
            if (rod < begin) continue;
            if (!split(line, header_.separator, cells))
                throw InputError(fmt::format("{}: a quote is not closed, or has text behind it", lines.place()));
            if (cells.size() != column_.size())
                refuse(origin, rod,
                       fmt::format("expected {} values by the first line, found {}", column_.size(), cells.size()));
            for (std::size_t c = 0; c < cells.size(); ++c) {
                if (column_[c] == skipped) continue;
                const auto [q, axis] = column_[c];
                const std::optional<double> value = csv_number(cells[c]);
                if (!value)
                    refuse(q, rod, fmt::format("'{}': {}", quantities[q].columns[axis], not_a_number(cells[c])));
                numbers[q][to_index(rod - begin) * width(q) + axis] = scale_[c] * *value;
            }
        }
    }
    std::string place(std::size_t quantity, std::int64_t rod) const override {
        return fmt::format("{}: row {} below the names: {}", path_, rod + 1, quantities[quantity].name);
    }

    static constexpr std::pair<std::size_t, std::size_t> skipped{all, 0};

    CsvHeader header_;
    std::vector<std::pair<std::size_t, std::size_t>> column_;   ///< quantity and axis
    std::vector<double> scale_;                                 ///< by column: number in the scene's unit over its own
    std::vector<std::pair<std::int64_t, std::int64_t>> blocks_; ///< offset and line at which each block begins
};

} // namespace

std::shared_ptr<const RodSource> open_text_rods(const std::string& path, const RodFileOptions& options) {
    const CsvHeader header = read_header(path, options.placement);
    if (header.id != CsvHeader::none) return open_csv_points(header, options);
    return std::make_shared<CsvRodFile>(header, options);
}

} // namespace skein
