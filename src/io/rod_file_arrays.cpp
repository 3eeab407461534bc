// Files of rods with arrays, which have a row per rod, or points along rods.
#include "io/array_file.hpp"
#include "io/point_file.hpp"
#include "io/rod_file_kind.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace skein {

namespace {

constexpr std::uint64_t most_rods = std::uint64_t{1}
                                    << 40; // sums of numbers of rods, by which ranks share them, need 64 bits

[[noreturn]] void refuse_shape(const ArrayFile& file, const std::string& name, const ArrayFile::Shape& shape,
                               const std::string& wanted) {
    file.refuse(
        fmt::format("{} '{}' has the shape [{}]; it must be {}", file.word(), name, fmt::join(shape, ", "), wanted));
}

/// Refuses names that are neither known nor to be ignored, and names to be ignored that the file does not have.
void check_names(const ArrayFile& file, const std::vector<std::string>& known, const Placement& placement) {
    for (const std::string& name : placement.ignore)
        if (!file.has(name))
            file.refuse(fmt::format("has no {} '{}', which placement.ignore names", file.word(), shown(name)));
    for (const std::string& name : file.names()) {
        const auto is_name = [&](const std::string& other) { return other == name; };
        if (std::any_of(placement.ignore.begin(), placement.ignore.end(), is_name)) continue;
        if (std::none_of(known.begin(), known.end(), is_name))
            file.refuse(
                fmt::format("unknown {} '{}'; a rod file has {}", file.word(), shown(name), fmt::join(known, ", ")));
    }
}

/// A row per rod.
class ArrayRodFile final : public RodFile {
public:
    ArrayRodFile(std::unique_ptr<ArrayFile> file, const RodFileOptions& options)
        : RodFile(file->path(), options.placement.unit), file_(std::move(file)) {
        std::vector<std::string> known;
        for (const RodQuantity& q : quantities) known.emplace_back(q.name);
        for (std::size_t q = 0; q < std::size(quantities); ++q)
            if (file_->has(known[q])) check_array(q);
        check_names(*file_, known, options.placement);
        check_quantities();
    }

private:
    void check_array(std::size_t q) {
        const std::string name(quantities[q].name);
        const ArrayFile::Shape shape = file_->shape(name);
        const RodQuantity& quantity = quantities[q];
        std::vector<std::string_view> wanted = {"rods"};
        if (quantity.per != Per::rod) wanted.push_back(quantity.per == Per::node ? "elements + 1" : "elements");
        if (quantity.components > 1) wanted.insert(wanted.end(), quantity.components == 9 ? 2 : 1, "3");
        bool fits = shape.size() == wanted.size();
        for (std::size_t d = 1; fits && d < shape.size(); ++d) fits = wanted[d] == "3" ? shape[d] == 3 : shape[d] > 1;
        if (!fits) refuse_shape(*file_, name, shape, fmt::format("[{}]", fmt::join(wanted, ", ")));
        if (shape[0] > most_rods)
            refuse(fmt::format("{} '{}' has {} rows: more than 2^40 rods", file_->word(), name, shape[0]));
        const auto rods = static_cast<std::int64_t>(shape[0]);
        if (!first_.empty() && rods != count_)
            refuse(fmt::format("{} '{}' has {} rows, but '{}' has {}: a row per rod", file_->word(), name, rods, first_,
                               count_));
        if (quantity.per != Per::rod) {
            const std::size_t elements = shape[1] - (quantity.per == Per::node);
            if (elements_ > 0 && elements != elements_)
                refuse(fmt::format("{} '{}' has rods of {} elements, but others have {}", file_->word(), name, elements,
                                   elements_));
            elements_ = elements;
        }
        if (first_.empty()) first_ = name;
        count_ = rods;
        has_[q] = true;
    }

    void read_numbers(std::int64_t begin, std::int64_t end, Numbers& numbers) const override {
        for (std::size_t q = 0; q < all; ++q)
            if (has_[q]) file_->read(std::string(quantities[q].name), begin, end - begin, numbers[q].data());
    }
    std::string place(std::size_t quantity, std::int64_t rod) const override {
        return fmt::format("{}: {} '{}', row {}", path_, file_->word(), quantities[quantity].name, rod);
    }

    std::unique_ptr<ArrayFile> file_;
    std::string first_; ///< first quantity in the file, which defines the number of rods
};

/// Points along rods: [rods, points, 3], or [points, 3] of all rods one after another with the offsets at which they
/// begin.
class ArrayPointFile final : public PointFile {
public:
    ArrayPointFile(std::unique_ptr<ArrayFile> file, const RodFileOptions& options)
        : PointFile(file->path(), options.elements, options.placement.unit), file_(std::move(file)) {
        check_names(*file_, {"points", "offsets", "radii", "normal", "normals", "voxel"}, options.placement);
        ragged_ = file_->has("offsets");
        const ArrayFile::Shape shape = file_->shape("points");
        const std::string wanted =
            ragged_ ? "[points, 3], beside 'offsets'" : "[rods, points, 3], or [points, 3] beside 'offsets'";
        if (shape.size() != (ragged_ ? 2U : 3U) || shape.back() != 3) refuse_shape(*file_, "points", shape, wanted);
        if (shape[0] > most_rods) refuse(fmt::format("{} 'points' has {} rows", file_->word(), shape[0]));
        if (!ragged_) each_ = static_cast<std::int64_t>(shape[1]);
        count_ = static_cast<std::int64_t>(shape[0]);
        if (ragged_) check_offsets(static_cast<std::int64_t>(shape[0]));
        if (count_ == 0) refuse("it contains no rods");
        if (file_->has("voxel")) find_voxel(options.placement.unit);
        radii_ = has_along("radii", shape, 0);
        normals_ = has_along("normals", shape, 3);
        start_normals_ = file_->has("normal");
        if (normals_ && start_normals_) refuse("'normal' conflicts with 'normals': one of the two is enough");
        if (!start_normals_) return;
        const ArrayFile::Shape found = file_->shape("normal");
        if (found != ArrayFile::Shape{static_cast<std::uint64_t>(count_), 3})
            refuse_shape(*file_, "normal", found, fmt::format("[{}, 3], a row per rod", count_));
    }

private:
    /// Lengths of a unit of points along x, y and z.
    void find_voxel(double unit) {
        const ArrayFile::Shape shape = file_->shape("voxel");
        if (shape != ArrayFile::Shape{3}) refuse_shape(*file_, "voxel", shape, "[3]: a length along x, y and z, m");
        double length[3];
        file_->read("voxel", 0, 3, length);
        for (const double one : length)
            if (!(one > 0 && std::isfinite(one)))
                refuse(fmt::format("{} 'voxel' has {:g}; lengths, m, are above 0", file_->word(), one));
        stretch_ = Vec3d{length[0] / unit, length[1] / unit, length[2] / unit};
    }

    /// True for an array that has a row of `components` (0: one number) for each point.
    bool has_along(const std::string& name, ArrayFile::Shape wanted, std::uint64_t components) const {
        if (!file_->has(name)) return false;
        if (components == 0) wanted.pop_back();
        const ArrayFile::Shape found = file_->shape(name);
        if (found != wanted)
            refuse_shape(*file_, name, found, fmt::format("[{}], as 'points'", fmt::join(wanted, ", ")));
        return true;
    }

    void check_offsets(std::int64_t points) {
        const ArrayFile::Shape shape = file_->shape("offsets");
        if (shape.size() != 1 || shape[0] < 2 || shape[0] > most_rods)
            refuse_shape(*file_, "offsets", shape, "[rods + 1]: where each rod begins, and the number of points");
        count_ = static_cast<std::int64_t>(shape[0]) - 1;
        const double first = offsets(0, 1)[0], last = offsets(count_, 1)[0];
        if (first != 0) refuse(fmt::format("{} 'offsets', row 0: is {:g}; it must be 0", file_->word(), first));
        if (last != static_cast<double>(points))
            refuse(fmt::format("{} 'offsets', row {}: is {:.17g}; it must be {}, the number of points", file_->word(),
                               count_, last, points));
    }

    std::vector<double> offsets(std::int64_t begin, std::int64_t count) const {
        std::vector<double> found(to_index(count));
        file_->read("offsets", begin, count, found.data());
        return found;
    }

    /// First points of rods [begin, end], the last one included.
    std::vector<std::int64_t> first_points(std::int64_t begin, std::int64_t end) const {
        std::vector<std::int64_t> first;
        first.reserve(to_index(end - begin) + 1);
        if (!ragged_) {
            for (std::int64_t rod = begin; rod <= end; ++rod) first.push_back(each_ * rod);
            return first;
        }
        const std::vector<double> all = offsets(begin, end - begin + 1);
        const std::uint64_t points = file_->shape("points")[0];
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto row = begin + static_cast<std::int64_t>(i);
            if (!(all[i] >= 0 && all[i] <= static_cast<double>(points)) || all[i] != std::floor(all[i]))
                refuse(fmt::format("{} 'offsets', row {}: {:g} is not the number of a point, 0 to {}", file_->word(),
                                   row, all[i], points));
            if (i > 0 && all[i] < all[i - 1])
                refuse(fmt::format("{} 'offsets', row {}: {:.17g} is below the row before, {:.17g}", file_->word(), row,
                                   all[i], all[i - 1]));
            first.push_back(static_cast<std::int64_t>(all[i]));
        }
        return first;
    }

    void read_points(std::int64_t begin, std::int64_t end, const Threads*, const TakeRods& take) const override {
        const std::vector<std::int64_t> first = first_points(begin, end);
        RodPoints rods;
        for (std::size_t i = 0; i + 1 < first.size();) {
            std::size_t past = i + 1;
            while (past + 1 < first.size() && first[past + 1] - first[i] <= most_points) ++past;
            const std::int64_t rod = begin + static_cast<std::int64_t>(i);
            read_rods(rod, std::span(first).subspan(i, past - i + 1), rods);
            take(rod, rods);
            i = past;
        }
    }

    void read_rods(std::int64_t rod, std::span<const std::int64_t> first, RodPoints& into) const {
        make_room(into, first);
        const std::int64_t points = first.back() - first.front(), rods = static_cast<std::int64_t>(first.size()) - 1;
        const auto read = [&](const std::string& name, double* numbers) {
            if (points == 0) return;
            if (ragged_) file_->read(name, first.front(), points, numbers);
            else file_->read(name, rod, rods, numbers);
        };
        const auto numbers_of = [](std::vector<Vec3d>& vectors) { return reinterpret_cast<double*>(vectors.data()); };
        static_assert(sizeof(Vec3d) == 3 * sizeof(double));
        read("points", numbers_of(into.points));
        if (stretch_)
            for (Vec3d& point : into.points) point = scale(*stretch_, point);
        if (radii_) read("radii", into.radii.data());
        if (normals_) read("normals", numbers_of(into.normals));
        if (start_normals_) file_->read("normal", rod, rods, numbers_of(into.start_normals));
    }

    std::string place(std::int64_t rod, std::int64_t point) const override {
        if (!ragged_)
            return fmt::format("{}: {} 'points', row {}, point {}", path_, file_->word(), rod,
                               std::max<std::int64_t>(point, 0));
        const auto first = static_cast<std::int64_t>(offsets(rod, 1)[0]);
        return fmt::format("{}: {} 'points', row {}, rod {}", path_, file_->word(),
                           first + std::max<std::int64_t>(point, 0), rod);
    }
    std::string name(std::int64_t rod) const override { return fmt::format("rod {}", rod); }

    std::unique_ptr<ArrayFile> file_;
    bool ragged_ = false;
    std::int64_t each_ = 0;        ///< points of each rod, where they are alike
    std::optional<Vec3d> stretch_; ///< voxel over the unit of the scene
};

} // namespace

std::shared_ptr<const RodSource> open_array_rods(std::unique_ptr<ArrayFile> file, const RodFileOptions& options) {
    if (!options.placement.id.empty())
        file->refuse(fmt::format("has no columns: placement.id = \"{}\" is for text", shown(options.placement.id)));
    if (file->has("points")) return std::make_shared<ArrayPointFile>(std::move(file), options);
    return std::make_shared<ArrayRodFile>(std::move(file), options);
}

} // namespace skein
