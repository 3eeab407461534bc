// A group of rods made ready: the constants of its one rod, worked out once, and the start state of each of its rods.
#pragma once

#include "core/quaternion.hpp"
#include "rod/packing.hpp"
#include "rod/rod_spec.hpp"
#include "rod/slot.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Constants of element k, body components: numbers, or packs where they differ from lane to lane (rod/strands.hpp). Those of a
/// group are shared by all its rods, so they live in cache and cost no bandwidth.
template <class P> struct ElementConstantsOf {
    P rest_length;       ///< l_k, m
    P inv_rest_length;   ///< 1/m
    P volume;            ///< m^3; of a rigid body with its round ends
    P radius;            ///< m, sqrt(A/pi): what a picture shows
    Vec3<P> stiffness;   ///< alpha_1 G A, alpha_2 G A, E A; N
    Vec3<P> rest_strain; ///< sigma0
    P rest_stretch;      ///< e0 = 1 + sigma0_3
    Vec3<P> inertia;     ///< J_k = rho l_k (j I1, j I2, I3), kg m^2; j of rotary_inertia_scale; of a rigid body rod/rigid.hpp
    Vec3<P> inv_inertia; ///< 1/J_k
    P inertia_ratio;     ///< J3/J1
    Vec3<P> bending;     ///< E I1, E I2, G I_t of the element; N m^2
};
using ElementConstants = ElementConstantsOf<double>;

/// Constants of Voronoi cell k, between elements k and k+1.
template <class P> struct VoronoiConstantsOf {
    P inv_length;           ///< 1/D_k, D = (l_k + l_{k+1})/2
    P share_before;         ///< l_k/(2 D): weight of element k in the cell's dilatation
    P share_after;          ///< l_{k+1}/(2 D)
    Vec3<P> stiffness;      ///< B_k, length-weighted mean of the two elements; N m^2
    Vec3<P> rest_curvature; ///< kappa0, 1/m
};
using VoronoiConstants = VoronoiConstantsOf<double>;

class RodGroup {
public:
    /// Works out constants and placements. Throws InputError (with the source line of the table) where numbers contradict
    /// each other. `directory` is where a mask file is looked for; `first_gid` is the number of rods in earlier groups. Rods that
    /// are packed keep clear of `occupied`, and join it.
    RodGroup(const RodSpec& spec, int id, std::int64_t first_gid, const std::string& directory,
             std::vector<Capsule>* occupied = nullptr);

    const RodSpec& spec() const { return spec_; }
    const std::string& name() const { return spec_.name; }
    int id() const { return id_; }
    std::int64_t first_gid() const { return first_gid_; }
    std::int64_t count() const { return static_cast<std::int64_t>(origins_.size()); }
    int elements() const { return static_cast<int>(element.size()); }
    /// Slots of a rod's record: one per node; the last one carries no element.
    int slots() const { return elements() + 1; }
    /// A ring: node n is node 0 (its slot a copy, without mass), cell n-1 joins element n-1 to element 0.
    bool closed() const { return spec_.shape.closed; }
    Law law() const { return spec_.material.law; }
    /// What an end holds: its node, and with clamped_frozen its element too.
    bool holds_node(int i) const {
        return (i == 0 && spec_.start != EndKind::free) || (i == elements() && spec_.end != EndKind::free);
    }
    bool holds_element(int k) const {
        return (k == 0 && spec_.start == EndKind::clamped_frozen) || (k == elements() - 1 && spec_.end == EndKind::clamped_frozen);
    }

    /// Lab position of rod i at s = 0.
    const Vec3d& origin(std::int64_t i) const { return origins_[static_cast<std::size_t>(i)]; }
    /// Lab frame of the start shape at s = 0, which all rods share but packed ones. Walls have it: packed rods have none.
    const Quaterniond& frame() const { return frame_; }
    /// Frame of the wall at the end, s = length, of an undeformed rod: the start shape's end frame.
    const Quaterniond& end_frame() const { return end_frame_; }

    /// State of rod i at t = 0.
    void start_state(std::int64_t i, std::span<Slot<1>> out) const;
    /// Directors of the start shape, one per element; those of every rod at t = 0 unless it is packed.
    std::span<const Quaterniond> start_directors() const { return start_directors_; }
    /// Of element k of rod i at t = 0.
    Quaterniond start_director(std::int64_t i, std::size_t k) const {
        return turns_.empty() ? start_directors_[k] : start_directors_[k] * turns_[static_cast<std::size_t>(i)];
    }
    /// Unit vector of rod i's magnetisation, lab components at t = 0.
    Vec3d magnetisation(std::int64_t i) const;
    /// Centre of rod i at t = 0, the point that partitioning uses.
    Vec3d centre(std::int64_t i) const { return origin(i) + turned(i, centre_offset_); }
    /// Elements of rod i at t = 0 as capsules that hold all of their sections.
    void append_capsules(std::int64_t i, std::vector<Capsule>& capsules) const;
    /// Of packed rods: share of the region's volume, and its upper end, m.
    double packed_fill() const { return packed_fill_; }
    double packed_top() const { return packed_top_; }

    std::vector<ElementConstants> element;    ///< [n]
    std::vector<VoronoiConstants> voronoi;    ///< [n - 1], a ring's [n]
    std::vector<double> rotary_inertia_scale; ///< [n], j >= 1; empty where all are 1
    std::vector<double> node_mass;            ///< [n + 1], kg; 0 where a node takes no kick
    std::vector<double> node_length;          ///< [n + 1], m: half of the elements on both sides
    Vec3d start_wall_rest_curvature{0, 0, 0}; ///< kappa0 of the half cells at clamped ends
    Vec3d end_wall_rest_curvature{0, 0, 0};

private:
    /// A lab vector of the start shape as rod i has it.
    Vec3d turned(std::int64_t i, const Vec3d& offset) const {
        return turns_.empty() ? offset : transpose_times(turns_[static_cast<std::size_t>(i)], offset);
    }
    void pack_rods(std::vector<Capsule>* occupied);
    /// What a rod turns about at t = 0, relative to its origin: an end that is pinned, or its centre of mass. m
    Vec3d pivot() const;

    RodSpec spec_;
    int id_;
    std::int64_t first_gid_;
    Quaterniond frame_, end_frame_;
    std::vector<Vec3d> origins_;
    std::vector<Quaterniond> turns_; ///< packed rods: from the lab's axes to the start shape's; else empty, as all are alike
    double packed_fill_ = 0, packed_top_ = 0;
    std::vector<Vec3d> start_offsets_; ///< node positions at t = 0, relative to the origin
    std::vector<Quaterniond> start_directors_;
    Vec3d centre_offset_;
    Vec3d corner_;
};

} // namespace skein
