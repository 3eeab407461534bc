// A group of rods made ready: the constants of its one rod, worked out once, and the start state of each of its rods.
#pragma once

#include "skein/core/index.hpp"
#include "skein/core/quaternion.hpp"
#include "skein/placement/assembly.hpp"
#include "skein/placement/places.hpp"
#include "skein/rod/rod_spec.hpp"
#include "skein/rod/slot.hpp"
#include "skein/rod/start_shape.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

struct Capsule;
struct BodyShape;

/// Constants of element k, body components: numbers, or packs where they differ from lane to lane (rod/strands.hpp).
/// Those of a group are shared by all its rods, so they live in cache and cost no bandwidth.
template <class P> struct ElementConstantsOf {
    P rest_length;       ///< l_k, m
    P inv_rest_length;   ///< 1/m
    P volume;            ///< m^3
    P radius;            ///< m, sqrt(A/pi): what a picture shows
    Vec3<P> stiffness;   ///< alpha_1 G A, alpha_2 G A, E A; N
    Vec3<P> rest_strain; ///< sigma0
    P rest_stretch;      ///< e0 = 1 + sigma0_3
    Vec3<P> inertia;     ///< J_k = rho l_k (j I1, j I2, I3), kg m^2; j of rotary_inertia_scale; of a body its own
    Vec3<P> inv_inertia; ///< 1/J_k
    P inertia_ratio;     ///< J3/J1
    Vec3<P> bending;     ///< E I1, E I2, G I_t of the element, with neo_hookean over e0^3; N m^2
};
using ElementConstants = ElementConstantsOf<double>;

/// Constants of Voronoi cell k, between elements k and k+1, or of a half cell, between a wall and the first or last
/// element.
template <class P> struct VoronoiConstantsOf {
    P inv_length;           ///< 1/D_k, D = (l_k + l_{k+1})/2; 2/l of a half cell
    P share_before;         ///< l_k/(2 D): weight of element k in the cell's dilatation
    P share_after;          ///< l_{k+1}/(2 D)
    Vec3<P> stiffness;      ///< B_k, of the section at the node, by D_k/D_w where it is weighted; N m^2
    Vec3<P> rest_curvature; ///< kappa0, 1/m
};
using VoronoiConstants = VoronoiConstantsOf<double>;

/// Modes of an element that limit the time step, theory.md (26)-(29).
inline constexpr std::array<std::string_view, 4> limiting_modes = {"axial", "shear-rotation about d1",
                                                                   "shear-rotation about d2", "twist"};
/// Of rods with sizes of their own: the smallest time-step limit of each mode over all rods, s.
using LeastLimits = std::array<double, limiting_modes.size()>;

class RodGroup {
public:
    /// Works out constants and placements. Throws InputError (with the source line of the table) where numbers
    /// contradict each other. `directory` is where a mask file is looked for; `first_gid` is the number of rods in
    /// earlier groups. Rods that are packed keep clear of `occupied`, and join it. `source`: the file of a placement of
    /// that kind, of which only rods that have been read (read_rods) can be asked for.
    RodGroup(const RodSpec& spec, int id, std::int64_t first_gid, const std::string& directory,
             std::vector<Capsule>* occupied = nullptr, std::shared_ptr<const RodSource> source = nullptr);

    /// Whether rods have lengths, radii or shapes of their own. Constants of the group are then those that the scene
    /// gives and of no rod; single(i) has those of rod i, and its number. Such rods lie along.
    bool heterogeneous() const { return places_.heterogeneous(); }
    RodGroup single(std::int64_t i) const { return RodGroup(*this, i); }
    /// Of a group that is single(j): becomes single(i) of the same `group`, in the memory that it has.
    void become(const RodGroup& group, std::int64_t i);

    /// Becomes part of an assembly: the rods so far stand in each of its copies. Once, before anything is read.
    void join(std::shared_ptr<const AssemblyCopies> copies);
    /// Null where rods are not joined to others.
    const AssemblyCopies* assembly() const { return copies_.get(); }
    /// Rods in a copy, those of copy c being c rods_per_copy() and on.
    std::int64_t rods_per_copy() const { return copies_ ? count() / copies_->count() : count(); }
    std::int64_t copy_of(std::int64_t i) const { return i / rods_per_copy(); }
    /// State at t = 0 of rod i of a copy, in the axes of the assembly.
    void start_state_in_assembly(std::int64_t i, std::span<Slot<1>> out) const;

    const RodSpec& spec() const { return spec_; }
    const std::string& name() const { return spec_.name; }
    int id() const { return id_; }
    std::int64_t first_gid() const { return first_gid_; }
    std::int64_t count() const { return places_.count(); }
    int elements() const { return static_cast<int>(element.size()); }
    /// Slots of a rod's record: one per node; the last one carries no element.
    /// A body has one in all, of its centre of mass and its frame.
    int slots() const { return static_cast<int>(node_mass.size()); }
    /// Number of distinct nodes: slot n of a ring is a copy of node 0.
    int nodes() const { return slots() - (closed() ? 1 : 0); }
    /// Number of cells between elements.
    int cells() const { return static_cast<int>(voronoi.size()); }
    /// Element on either side of node i, 0 to n. A ring goes round; elsewhere -1 stands for none.
    int element_before(int i) const { return i > 0 ? i - 1 : closed() ? elements() - 1 : -1; }
    int element_after(int i) const { return i < elements() ? i : closed() ? 0 : -1; }
    /// Cell or half cell around node i.
    const VoronoiConstants& cell_at(int i) const {
        if (const int before = element_before(i); before >= 0 && before < cells()) return nth(voronoi, before);
        return i == 0 ? start_wall : end_wall;
    }
    /// Whether elements lie between nodes and are strained; those of bodies do not.
    bool strained() const { return !body_; }
    /// Of a body; null of rods.
    const BodyShape* body() const { return body_.get(); }
    /// Slots that a rod shows to others, which lie between nodes that follow each other; a body two for each part of
    /// its surface. And the radius of the element that one has at rest, m, of a box that of the ball around it; below
    /// 0: it has none.
    int exposed_slots() const;
    double exposed_radius(int slot) const;
    /// A ring: node n is node 0 (its slot a copy, without mass), cell n-1 joins element n-1 to element 0.
    bool closed() const { return spec_.shape.closed; }
    Law law() const { return spec_.material.law; }
    /// What an end holds in all directions: its node, unless that slides, and with clamped_frozen its element too.
    bool holds_node(int i) const {
        return (i == 0 && spec_.start != EndKind::free && spec_.start_free.empty()) ||
               (i == elements() && spec_.end != EndKind::free && spec_.end_free.empty());
    }
    /// Whether an end holds the node in some directions and leaves it free in others.
    bool slides(int i) const {
        return (i == 0 && !spec_.start_free.empty()) || (i == elements() && !spec_.end_free.empty());
    }
    /// Of a node that slides: 1 in the lab directions in which it is free.
    Vec3d free_directions(int i) const { return lab_directions(i == 0 ? spec_.start_free : spec_.end_free); }
    bool holds_element(int k) const {
        return (k == 0 && spec_.start == EndKind::clamped_frozen) ||
               (k == elements() - 1 && spec_.end == EndKind::clamped_frozen);
    }

    /// Lab position of rod i at s = 0.
    Vec3d origin(std::int64_t i) const { return places_.origin(i); }
    /// Whether rods have directions of their own.
    bool turned() const { return places_.turned(); }
    /// Lab frame of the start shape at s = 0: the wall's. Of all rods, unless they are turned.
    const Quaterniond& frame() const { return frame_; }
    Quaterniond frame(std::int64_t i) const { return turned() ? frame_ * places_.turn(i) : frame_; }
    /// Frame of the wall at the end, s = length, of an undeformed rod: the start shape's end frame.
    const Quaterniond& end_frame() const { return start_.end_frame; }
    Quaterniond end_frame(std::int64_t i) const {
        return turned() ? start_.end_frame * places_.turn(i) : start_.end_frame;
    }

    /// Of a placement by file: what this rank knows of its rods. See partition/partition.hpp, which calls these.
    const Places& places() const { return places_; }
    Places& places() { return places_; }
    /// What depends on all rods of a file, and so is known when all ranks have read their parts: the smallest x, y, z
    /// of the origins, which a magnetisation is measured from, and the sum of the parts' digests.
    void set_read(const Vec3d& corner, std::uint64_t digest, const LeastLimits& limits) {
        corner_ = corner;
        file_digest_ = digest;
        least_limits_ = limits;
    }
    /// Reads all rods of a file that has not been read, where no other rank takes a part.
    void read_all();
    const LeastLimits& least_limits() const { return least_limits_; }
    std::uint64_t file_digest() const { return file_digest_; }

    /// State of rod i at t = 0.
    void start_state(std::int64_t i, std::span<Slot<1>> out) const;
    /// Directors of the start shape, one per element; those of every rod at t = 0 unless it is turned.
    std::span<const Quaterniond> start_directors() const { return start_.directors; }
    /// Of element k of rod i at t = 0.
    Quaterniond start_director(std::int64_t i, std::size_t k) const {
        return turned() ? start_.directors[k] * places_.turn(i) : start_.directors[k];
    }
    /// Unit vector of rod i's magnetisation, lab components at t = 0.
    Vec3d magnetisation(std::int64_t i) const;
    double magnetisation_strength(std::int64_t i) const; ///< A/m
    double largest_magnetisation() const;                ///< of all rods, A/m
    /// Centre of rod i at t = 0, the point that partitioning uses.
    Vec3d centre(std::int64_t i) const {
        const double scale = heterogeneous() ? places_.length(i, spec_.shape.length) / spec_.shape.length : 1;
        return origin(i) + as_turned(i, scale * start_.centre);
    }
    /// Elements of rod i at t = 0 as capsules that hold all of their sections.
    void append_capsules(std::int64_t i, std::vector<Capsule>& capsules) const;
    /// Of packed rods: share of the region's volume, and its upper end, m.
    double packed_fill() const { return packed_fill_; }
    double packed_top() const { return packed_top_; }

    std::vector<ElementConstants> element;    ///< [n]
    std::vector<VoronoiConstants> voronoi;    ///< [n - 1], a ring's [n]
    std::vector<double> rotary_inertia_scale; ///< [n], j >= 1; empty where all are 1
    std::vector<double> node_mass;            ///< [slots], kg; 0 where a node takes no kick
    std::vector<double> node_length; ///< [slots], m: half of the elements on both sides; weighs as the mass does
    std::vector<double> cell_weight; ///< [slots], D_w/D of the cell around a node; empty where all are 1
    double nodal_density =
        0; ///< 4/(this V) bounds 1/m + 1/m' of what an element of volume V brings to its nodes, kg/m^3
    VoronoiConstants start_wall{},
        end_wall{}; ///< half cells of clamped ends; their dilatation is that of the element there

private:
    /// A lab vector of the start shape as rod i has it.
    Vec3d as_turned(std::int64_t i, const Vec3d& offset) const {
        return turned() ? transpose_times(places_.turn(i), offset) : offset;
    }
    RodGroup(const RodGroup& group, std::int64_t i);
    Vec3d magnetisation_at(const Vec3d& place) const;
    void start_state(const Vec3d& start, const Quaterniond& turn, bool turned, std::span<Slot<1>> out) const;
    void work_out_constants();
    void work_out_body();
    void weigh_cells();
    void pack_rods(std::vector<Capsule>* occupied);
    /// What a rod turns about at t = 0, relative to its origin: an end that is pinned, or its centre of mass. m
    Vec3d pivot() const;

    std::shared_ptr<const BodyShape> body_;
    RodSpec spec_;
    int id_;
    std::int64_t first_gid_;
    Quaterniond frame_;
    Places places_;
    std::shared_ptr<const AssemblyCopies> copies_; ///< null: of no assembly
    Places within_;                                ///< of an assembly: places in its axes
    double packed_fill_ = 0, packed_top_ = 0;
    StartShape start_;
    Vec3d corner_{0, 0, 0};
    std::uint64_t file_digest_ = 0;
    LeastLimits least_limits_{};
};

/// At rest at node k: mean of the elements that meet there, m.
inline double node_radius(const RodGroup& group, std::int64_t k) {
    const std::int64_t last = group.elements() - 1;
    return 0.5 *
           (nth(group.element, std::max<std::int64_t>(k - 1, 0)).radius + nth(group.element, std::min(k, last)).radius);
}

/// Of the cell or half cell around node i.
inline double cell_weight(const RodGroup& group, std::size_t i) {
    return group.cell_weight.empty() ? 1 : group.cell_weight[i];
}

/// Calls f with the group whose constants rod i has.
template <class F> decltype(auto) with_rod(const RodGroup& group, std::int64_t i, F&& f) {
    if (!group.heterogeneous()) return f(group);
    const RodGroup own = group.single(i);
    return f(own);
}

} // namespace skein
