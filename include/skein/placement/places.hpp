// Places and directions of the rods of a group at the start. A lattice is a formula and costs no memory. Lists from a
// scene or a file are kept for some rods alone. These are a block while rods are distributed over ranks, then the rods
// of this rank.
#pragma once

#include "skein/core/quaternion.hpp"
#include "skein/placement/placement_spec.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

class Threads;

/// Frame with rows d1 (from the normal, made orthogonal), d2, d3 (from the tangent). Without a normal d1 is along x, or
/// along y for tangents along x.
Quaterniond frame_of(const Vec3d& tangent, const std::optional<Vec3d>& normal);

/// Columns that a file of rods has.
struct RodColumns {
    bool tangent = false, normal = false, length = false, radius = false;
    bool nodes = false, directors = false, radii = false; ///< by node or element
    bool turned() const { return tangent || nodes; }
    bool heterogeneous() const { return length || radius || nodes || radii; }
};

/// Largest distance between resampled rods and the lines through the points that a file has for them.
struct Deviation {
    double distance = -1;              ///< m; below 0: no rod is resampled
    std::string rod;                   ///< rod with this distance, as messages name it
    std::int64_t fewest = 0, most = 0; ///< points of a rod
    bool resampled() const { return distance >= 0; }
    void include(const Deviation& other); ///< of other rods; of equal distances the first stays
};

/// Consecutive rods as a file describes them: an entry per rod (or element, node), or none where the file has no such
/// column. Origins of traced rods are their first nodes.
struct RodRows {
    std::vector<Vec3d> origins;
    std::vector<Vec3d> tangents, normals;
    std::vector<double> lengths, radii; ///< m
    std::vector<Vec3d> nodes;           ///< [rods, elements + 1], m
    std::vector<Vec3d> element_normals; ///< [rods, elements]: d1
    std::vector<double> element_radii;  ///< [rods, elements], m
    Deviation deviation;
};

/// Interface of a file of rods; io/rod_file.hpp implements it.
class RodSource {
public:
    virtual ~RodSource() = default;
    virtual std::int64_t count() const = 0;
    virtual RodColumns columns() const = 0;
    /// elements of a rod, where the file determines them; otherwise 0
    virtual std::int64_t elements() const { return 0; }
    /// Reads rods [begin, end). Throws InputError naming file, column and row where an entry is not a number, or a
    /// direction is missing. `threads`: those that may share the work; null: none.
    virtual RodRows read(std::int64_t begin, std::int64_t end, const Threads* threads) const = 0;
};

class Places {
public:
    /// One rod at the origin.
    Places() = default;
    /// Places of the kinds "single", "line", "lattice", "mask" and "list". Bitmaps are searched in `directory`;
    /// messages begin with `source`.
    Places(const Placement& placement, const std::string& source, const std::string& directory);
    /// Places from lists; `turns` may be empty.
    Places(std::vector<Vec3d> origins, std::vector<Quaterniond> turns);
    /// Places from a file. Until a block is read only the number of rods is known.
    Places(std::shared_ptr<const RodSource> source, const Vec3d& origin, std::int64_t elements, bool closed);

    std::int64_t count() const { return count_; }
    /// Lab position at s = 0 of rod i, which must be held, m.
    Vec3d origin(std::int64_t i) const;
    /// True where rods have directions of their own: turn(i) leads from lab axes to those of the start shape.
    bool turned() const { return turned_; }
    /// True where rods have lengths, radii or shapes of their own.
    bool heterogeneous() const { return columns_.heterogeneous(); }
    const RodColumns& columns() const { return columns_; }
    /// Rest length and radius of rod i, m; `given`, from the scene, where the file has no column.
    double length(std::int64_t i, double given) const;
    double radius(std::int64_t i, double given) const;
    /// Rest lengths of the elements of rod i, m, curvatures of its inner vertices, 1/m, and radii of its elements, m,
    /// as in the file.
    std::span<const double> element_lengths(std::int64_t i) const;
    void put_curvatures(std::int64_t i, std::vector<Vec3d>& curvatures) const;
    std::span<const double> element_radii(std::int64_t i) const;
    /// Numbers of the rods that are held, in order.
    std::vector<std::int64_t> held() const;
    /// Takes the sizes of rods that stand in all copies one after the other.
    void take_sizes(const Places& of_copy, std::int64_t copies);
    /// Becomes the place of rod i of `all` alone, without a size of its own.
    void become(const Places& all, std::int64_t i);
    const Quaterniond& turn(std::int64_t i) const { return turns_[row(i)]; }
    /// Smallest x, y, z of the origins of all held rods, m.
    Vec3d corner() const;

    /// True for a file of which nothing has been read yet.
    bool waits() const { return source_ && !read_; }
    bool from_file() const { return source_ != nullptr; }
    /// True where data are kept rod by rod.
    bool listed() const { return listed_; }
    bool holds_all() const { return !listed_ || static_cast<std::int64_t>(origins_.size()) == count_; }
    /// Reads rods [begin, end) of the file, and drops all others. `threads` share the work; null: none.
    void read(std::int64_t begin, std::int64_t end, const Threads* threads = nullptr);
    /// Sum modulo 2^64 of hashes of the held rods, which identifies a file.
    std::uint64_t digest(const Threads* threads = nullptr) const;
    /// Deviation of the rods that were read here, or of all ranks once they have agreed.
    const Deviation& deviation() const { return deviation_; }
    void set_deviation(Deviation of_all) { deviation_ = std::move(of_all); }
    /// Drops all rods but these, which may stand in any order.
    void keep(std::span<const std::int64_t> indices);
    /// Keeps rods that other ranks hold: `records` are theirs, in the order of `indices`.
    void keep(std::span<const std::int64_t> indices, std::span<const std::byte> records);
    /// Data of the held rods for another rank, in order.
    std::vector<std::byte> records() const;
    std::size_t record_bytes() const { return sizeof(Vec3d) + sizeof(Quaterniond) + width_ * sizeof(double); }
    std::size_t bytes() const;

private:
    struct Tracer;
    void take(const RodRows& rows, std::int64_t first, std::size_t row, std::size_t i, Tracer& tracer);
    std::size_t row(std::int64_t i) const; ///< row of rod i among the held ones

    std::int64_t count_ = 1;
    Vec3d first_{0, 0, 0};              ///< lattice or bitmap: first point; file: offset of its origins, m
    std::int64_t counts_[2] = {1, 1};   ///< lattice: counts along x and y
    double spacing_[3] = {0, 0, 0};     ///< m
    double stagger_ = 0;                ///< lattice: shift of every other row along x, m
    std::vector<std::uint32_t> pixels_; ///< bitmap: pixels that carry a rod, row by row from the lowest y
    bool listed_ = false, turned_ = false, read_ = false;
    std::vector<Vec3d> origins_;     ///< held rods
    std::vector<Quaterniond> turns_; ///< held rods; empty unless turned_
    std::int64_t begin_ = 0;         ///< first held rod, where they are consecutive
    std::vector<std::int64_t> held_; ///< held rods, rising; empty where they are consecutive
    std::shared_ptr<const RodSource> source_;
    RodColumns columns_;
    std::size_t cells() const { return closed_ ? elements_ : elements_ - 1; }
    std::size_t elements_ = 0;
    bool closed_ = false;   ///< rods are rings
    std::size_t width_ = 0; ///< numbers in a row of sizes_
    /// Sizes of the held rods: length, radius, then of traced rods the elements' lengths and the curvatures between
    /// them, then the elements' radii. Columns that the file does not have are left out.
    std::vector<double> sizes_;
    Deviation deviation_;
};

} // namespace skein
