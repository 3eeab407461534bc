// Where the rods of a group start, and how each is turned. A lattice is a formula and costs no memory. What a scene or
// a file lists is kept of some rods alone: of a block while rods are given to ranks, then of this rank's own.
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

/// Frame with rows d1 (from the normal, made orthogonal), d2, d3 (from the tangent). Without a normal d1 is along x, or
/// along y for tangents along x.
Quaterniond frame_of(const Vec3d& tangent, const std::optional<Vec3d>& normal);

/// What a file says of its rods.
struct RodColumns {
    bool tangent = false, normal = false, length = false, radius = false;
    bool nodes = false, directors = false, radii = false; ///< along the rod
    bool turned() const { return tangent || nodes; }
    bool heterogeneous() const { return length || radius || nodes || radii; }
};

/// Consecutive rods as a file describes them: an entry per rod (or element, node), none at all where the file is
/// silent. Of traced rods the origins are the first nodes.
struct RodRows {
    std::vector<Vec3d> origins;
    std::vector<Vec3d> tangents, normals;
    std::vector<double> lengths, radii; ///< m
    std::vector<Vec3d> nodes;           ///< [rods, elements + 1], m
    std::vector<Vec3d> element_normals; ///< [rods, elements]: d1
    std::vector<double> element_radii;  ///< [rods, elements], m
};

/// A file of rods: io/rod_file.hpp reads it, and groups know this face of it.
class RodSource {
public:
    virtual ~RodSource() = default;
    virtual std::int64_t count() const = 0;
    virtual RodColumns columns() const = 0;
    virtual std::int64_t elements() const { return 0; } ///< of a rod, where the file speaks of them; else 0
    /// Rods [begin, end). Throws InputError naming file, column and row where a number is none, or a direction is
    /// missing.
    virtual RodRows read(std::int64_t begin, std::int64_t end) const = 0;
};

class Places {
public:
    /// One rod at the origin.
    Places() = default;
    /// Of kinds "single", "line", "lattice", "mask" and "list". `directory` is where a bitmap is looked for.
    /// `source`: of the table, for messages.
    Places(const Placement& placement, const std::string& source, const std::string& directory);
    /// `turns` may be empty.
    Places(std::vector<Vec3d> origins, std::vector<Quaterniond> turns);
    /// Of a file; nothing is known of its rods but their number until a block is read.
    Places(std::shared_ptr<const RodSource> source, const Vec3d& origin, std::int64_t elements);

    std::int64_t count() const { return count_; }
    /// Lab position at s = 0 of rod i, one of those that are held.
    Vec3d origin(std::int64_t i) const;
    /// Whether rods have directions of their own: turn(i) from the lab's axes to those of the start shape.
    bool turned() const { return turned_; }
    /// Whether rods have lengths, radii or shapes of their own.
    bool heterogeneous() const { return columns_.heterogeneous(); }
    const RodColumns& columns() const { return columns_; }
    /// Rest length and radius of rod i, m; `given`, the scene's, where the file is silent.
    double length(std::int64_t i, double given) const;
    double radius(std::int64_t i, double given) const;
    /// Rest lengths of its elements, m, curvatures of its inner vertices, 1/m, and radii of its elements, m, as its
    /// file has them.
    std::span<const double> element_lengths(std::int64_t i) const;
    std::vector<Vec3d> curvatures(std::int64_t i) const;
    std::span<const double> element_radii(std::int64_t i) const;
    /// Numbers of the rods that are held, in order.
    std::vector<std::int64_t> held() const;
    /// Becomes that of rod i of `all` alone, which has no size of its own then.
    void become(const Places& all, std::int64_t i);
    const Quaterniond& turn(std::int64_t i) const { return turns_[row(i)]; }
    /// Smallest x, y, z of the origins of all rods that are held.
    Vec3d corner() const;

    /// Rods come from a file, of which nothing has been read yet.
    bool waits() const { return source_ && !read_; }
    bool from_file() const { return source_ != nullptr; }
    /// What there is of a rod is kept rod by rod.
    bool listed() const { return listed_; }
    bool holds_all() const { return !listed_ || static_cast<std::int64_t>(origins_.size()) == count_; }
    /// Reads rods [begin, end) of the file, and forgets others.
    void read(std::int64_t begin, std::int64_t end);
    /// Sum modulo 2^64 of hashes of the rods that are held: what tells one file from another.
    std::uint64_t digest() const;
    /// Forgets all rods but these, which may stand in any order.
    void keep(std::span<const std::int64_t> indices);
    /// The same where the rods to be kept are held by other ranks: `records` are theirs, in the order of `indices`.
    void keep(std::span<const std::int64_t> indices, std::span<const std::byte> records);
    /// What another rank needs to know of the rods that are held, in order.
    std::vector<std::byte> records() const;
    std::size_t record_bytes() const { return sizeof(Vec3d) + sizeof(Quaterniond) + width_ * sizeof(double); }
    std::size_t bytes() const;

private:
    std::size_t row(std::int64_t i) const; ///< of what is held of rod i

    std::int64_t count_ = 1;
    Vec3d first_{0, 0, 0}; ///< of a lattice or bitmap: the place of its first point; of a file: added to its origins
    std::int64_t counts_[2] = {1, 1};   ///< of a lattice, along x and y
    double spacing_[3] = {0, 0, 0};     ///< m
    double stagger_ = 0;                ///< of a lattice: of every other row along x, m
    std::vector<std::uint32_t> pixels_; ///< of a bitmap, row by row from the lowest y: those that carry a rod
    bool listed_ = false, turned_ = false, read_ = false;
    std::vector<Vec3d> origins_;     ///< of the rods that are held
    std::vector<Quaterniond> turns_; ///< the same; empty unless turned_
    std::int64_t begin_ = 0;         ///< the first rod that is held, where they are consecutive
    std::vector<std::int64_t> held_; ///< the rods that are held, rising; empty: consecutive ones
    std::shared_ptr<const RodSource> source_;
    RodColumns columns_;
    std::size_t elements_ = 0, width_ = 0; ///< numbers in a row of sizes_
    /// Of the rods that are held: length, radius, then of traced rods the elements' lengths and the curvatures between
    /// them, then the elements' radii; what the file is silent of is left out.
    std::vector<double> sizes_;
};

} // namespace skein
