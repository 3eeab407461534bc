// SWC files of neurons and vessels: a tree of points. Each section without branches is a rod.
#include "io/csv_table.hpp"
#include "io/point_file.hpp"
#include "io/rod_file_kind.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

namespace skein {

namespace {

class SwcFile final : public PointFile {
public:
    SwcFile(const std::string& path, const RodFileOptions& options)
        : PointFile(path, options.elements, options.placement.unit) {
        if (!options.placement.id.empty() || !options.placement.ignore.empty())
            refuse("has columns of its own: placement.id and placement.ignore are for tables");
        read_rows();
        find_parents();
        refuse_cycles();
        find_sections();
        radii_ = true;
    }

private:
    static constexpr std::uint32_t none = static_cast<std::uint32_t>(-1);
    struct Point {
        Vec3d place;
        double radius;
        std::int64_t id, parent_id, line;
        std::uint32_t parent = none, children = 0, child = none; ///< `child`: the last one
    };

    static std::vector<std::string_view> words_of(std::string_view line) {
        std::vector<std::string_view> words;
        for (std::size_t at = 0; (at = line.find_first_not_of(" \t,", at)) != std::string_view::npos;) {
            const std::size_t end = std::min(line.find_first_of(" \t,", at), line.size());
            words.push_back(line.substr(at, end - at));
            at = end;
        }
        return words;
    }

    void read_rows() {
        constexpr std::array<std::string_view, 7> names = {"id", "type", "x", "y", "z", "radius", "parent"};
        TextLines lines(path_);
        std::string_view line;
        while (lines.next(line)) {
            const std::vector<std::string_view> words = words_of(line);
            if (words.empty() || words[0].starts_with('#')) continue;
            if (words.size() != names.size())
                throw InputError(fmt::format("{}: expected 7 numbers, id type x y z radius parent, found {}",
                                             lines.place(), words.size()));
            std::array<double, 7> value{};
            for (std::size_t c = 0; c < names.size(); ++c) {
                const std::optional<double> number = csv_number(words[c]);
                if (!number)
                    throw InputError(fmt::format("{}: {}: {}", lines.place(), names[c], not_a_number(words[c])));
                value[c] = *number;
            }
            for (const std::size_t c : {0, 6})
                if (value[c] != std::floor(value[c]) || !(std::abs(value[c]) < 1e15))
                    throw InputError(
                        fmt::format("{}: {}: '{}' is not a whole number", lines.place(), names[c], shown(words[c])));
            if (points_.size() + 1 == none) refuse("has more than 2^32 points");
            points_.push_back({{value[2], value[3], value[4]},
                               value[5],
                               static_cast<std::int64_t>(value[0]),
                               static_cast<std::int64_t>(value[6]),
                               lines.line()});
        }
        if (points_.empty()) refuse("it contains no points");
    }

    [[noreturn]] void refuse_point(const Point& point, const std::string& what) const {
        throw InputError(fmt::format("{}:{}: point {}: {}", path_, point.line, point.id, what));
    }

    void find_parents() {
        std::unordered_map<std::int64_t, std::uint32_t> at;
        at.reserve(points_.size());
        for (std::uint32_t i = 0; i < points_.size(); ++i) {
            const auto [first, added] = at.try_emplace(points_[i].id, i);
            if (!added) refuse_point(points_[i], fmt::format("has the id of line {}", points_[first->second].line));
        }
        for (std::uint32_t i = 0; i < points_.size(); ++i) {
            Point& point = points_[i];
            if (point.parent_id < 0) continue;
            const auto parent = at.find(point.parent_id);
            if (parent == at.end()) refuse_point(point, fmt::format("its parent {} is missing", point.parent_id));
            point.parent = parent->second;
            ++points_[point.parent].children;
            points_[point.parent].child = i;
        }
    }

    /// Walks towards the root from each point until a point that was reached before.
    void refuse_cycles() const {
        std::vector<std::uint32_t> walk(points_.size(), none);
        for (std::uint32_t i = 0; i < points_.size(); ++i)
            for (std::uint32_t p = i; p != none && walk[p] != i; p = points_[p].parent) {
                if (walk[p] != none) break;
                walk[p] = i;
                if (const std::uint32_t above = points_[p].parent; above != none && walk[above] == i)
                    refuse_point(points_[above], "its parents lead back to itself");
            }
    }

    bool ends_section(const Point& point) const { return point.parent == none || point.children != 1; }

    /// Each child of a root or of a branch point begins a section, in the order of the file.
    void find_sections() {
        for (std::uint32_t i = 0; i < points_.size(); ++i) {
            const Point& point = points_[i];
            if (point.parent == none && point.children == 0) refuse_point(point, "it is alone: a rod has two points");
            if (point.parent != none && ends_section(points_[point.parent])) first_.push_back(i);
        }
        count_ = static_cast<std::int64_t>(first_.size());
    }

    void read_points(std::int64_t begin, std::int64_t end, const Threads*, const TakeRods& take) const override {
        RodPoints rods;
        for (std::int64_t first = begin; first < end;) {
            rods.first.assign(1, 0);
            rods.points.clear();
            rods.radii.clear();
            std::int64_t rod = first;
            for (; rod < end && static_cast<std::int64_t>(rods.points.size()) < most_points; ++rod)
                add_section(nth(first_, rod), rods);
            take(std::exchange(first, rod), rods);
        }
    }

    /// Adds the section whose second point is `i`.
    void add_section(std::uint32_t i, RodPoints& rods) const {
        const auto add = [&](const Point& point) {
            rods.points.push_back(point.place);
            rods.radii.push_back(point.radius);
        };
        add(points_[points_[i].parent]);
        add(points_[i]);
        while (points_[i].children == 1) {
            i = points_[i].child;
            add(points_[i]);
        }
        rods.first.push_back(rods.points.size());
    }

    std::string place(std::int64_t rod, std::int64_t point) const override {
        std::uint32_t i = nth(first_, rod);
        if (point <= 0) i = points_[i].parent;
        for (; point > 1 && points_[i].children == 1; --point) i = points_[i].child;
        return fmt::format("{}:{}: point {}", path_, points_[i].line, points_[i].id);
    }
    std::string name(std::int64_t rod) const override {
        return fmt::format("the section from point {} on", points_[nth(first_, rod)].id);
    }

    std::vector<Point> points_;
    std::vector<std::uint32_t> first_; ///< of each section: the point behind its root or branch point
};

} // namespace

std::shared_ptr<const RodSource> open_swc_rods(const std::string& path, const RodFileOptions& options) {
    return std::make_shared<SwcFile>(path, options);
}

} // namespace skein
