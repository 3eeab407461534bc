// A group of rods made ready: constants, computed once for all rods, and the start state of each rod.
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
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

namespace skein {

struct Capsule;
struct BodyShape;

/// Constants of element k, body components: numbers, or packs where they differ from lane to lane (tiles/strands.hpp).
/// All rods of a group share them, so that they stay in cache and cost no bandwidth.
template <class P> struct ElementConstantsOf {
    P rest_length;       ///< l_k, m
    P inv_rest_length;   ///< 1/m
    P volume;            ///< m^3
    P radius;            ///< m, sqrt(A/pi), the radius of pictures
    Vec3<P> stiffness;   ///< alpha_1 G A, alpha_2 G A, E A; N
    Vec3<P> rest_strain; ///< sigma0
    P rest_stretch;      ///< e0 = 1 + sigma0_3
    Vec3<P> inertia;     ///< J_k = rho l_k (j I1, j I2, I3), kg m^2, with j of rotary_inertia_scale; a body has its own
    Vec3<P> inv_inertia; ///< 1/J_k
    P inertia_ratio;     ///< J3/J1
    Vec3<P> bending;     ///< E I1, E I2, G I_t of the element, over e0^3 with neo_hookean; N m^2
};
using ElementConstants = ElementConstantsOf<double>;

/// Constants of Voronoi cell k, between elements k and k+1, or of a half cell, between a wall and the first or last
/// element.
template <class P> struct VoronoiConstantsOf {
    P inv_length;           ///< 1/D_k, D = (l_k + l_{k+1})/2; 2/l of a half cell
    P share_before;         ///< l_k/(2 D): weight of element k in the cell's dilatation
    P share_after;          ///< l_{k+1}/(2 D)
    Vec3<P> stiffness;      ///< B_k of the section at the node, times D_k/D_w where the cell is weighted; N m^2
    Vec3<P> rest_curvature; ///< kappa0, 1/m
};
using VoronoiConstants = VoronoiConstantsOf<double>;

/// Modes of an element that limit the time step, theory.md (26)-(29).
inline constexpr std::array<std::string_view, 4> limiting_modes = {"axial", "shear-rotation about d1",
                                                                   "shear-rotation about d2", "twist"};
/// Smallest time-step limit of each mode over all rods of a heterogeneous group, s.
using LeastLimits = std::array<double, limiting_modes.size()>;

/// Place at which a stage has caught an end of a rod: that of its node without its motion, m, and frame of its wall.
struct CaughtEnd {
    Vec3d place{0, 0, 0};
    Quaterniond frame;
};
/// Both ends of the rods of this rank, by number. The passes that lead ends keep them up to date.
using CaughtEnds = std::unordered_map<std::int64_t, std::array<CaughtEnd, 2>>;

class RodGroup {
    struct Kinds; ///< rods of sizes that have been asked for

public:
    /// Computes constants and places. `first_gid` is the number of rods in earlier groups. Mask files are searched in
    /// `directory`. Packed rods keep clear of `occupied`, and are added to it. `source` is the file of a placement by
    /// file, of which only rods that have been read (Places::read) are known. Throws InputError, with the source line
    /// of the table, where numbers contradict each other.
    RodGroup(const RodSpec& spec, int id, std::int64_t first_gid, const std::string& directory,
             std::vector<Capsule>* occupied = nullptr, std::shared_ptr<const RodSource> source = nullptr);

    /// True where rods have lengths, radii or shapes of their own. Constants of the group are then those of the scene
    /// and of no rod. single(i) has the constants and the number of rod i.
    bool heterogeneous() const { return places_.heterogeneous(); }
    RodGroup single(std::int64_t i) const { return RodGroup(*this, i); }
    /// Number of the rod that single() has made the group of; absent otherwise.
    std::optional<std::int64_t> single_rod() const { return single_rod_; }
    /// Constants of rod i, which must be held: the group itself where all rods have them, or single(i), which is kept.
    /// Any thread may ask.
    const RodGroup& kind(std::int64_t i) const;
    /// Reads the formulas of the group's table again for rods with sizes of their own, from their lengths. `read`
    /// throws InputError where they have faults there. Call it before any rod is asked for.
    void use_formulas(std::function<void(RodSpec&)> read);
    /// Puts length, radius and shape of rod i into `own`, a copy of spec().
    void put_own_sizes(std::int64_t i, RodSpec& own) const;
    /// Turns a group that is single(j) into single(i) of the same `group`, in the memory that it has. Without its start
    /// shape where constants alone are needed.
    enum class Part { whole, constants };
    void become(const RodGroup& group, std::int64_t i, Part part = Part::whole);
    /// single(i) for a short time, in memory that later ones take over. Any thread may ask.
    struct GiveBack {
        Kinds* kinds;
        void operator()(RodGroup* rod) const;
    };
    using Borrowed = std::unique_ptr<RodGroup, GiveBack>;
    Borrowed borrow(std::int64_t i) const;

    /// Makes the rods so far part of an assembly: each of its copies has them. Call it once, before any state is read.
    void join(std::shared_ptr<const AssemblyCopies> copies);
    /// Assembly of the group; null where rods are not joined to others.
    const AssemblyCopies* assembly() const { return copies_.get(); }
    /// Number of rods in a copy. Copy c has the rods from c rods_per_copy() on.
    std::int64_t rods_per_copy() const { return copies_ ? count() / copies_->count() : count(); }
    std::int64_t copy_of(std::int64_t i) const { return i / rods_per_copy(); }
    /// Rotation from lab axes to those of rod i's copy; lab axes themselves outside assemblies.
    Quaterniond copy_axes(std::int64_t i) const {
        return copies_ && !copies_->turns.empty() ? nth(copies_->turns, copy_of(i)) : no_turn;
    }
    /// Lab components of a vector in the axes of rod i's copy.
    Vec3d to_lab(std::int64_t i, const Vec3d& v) const {
        return copies_ && !copies_->turns.empty() ? transpose_times(copy_axes(i), v) : v;
    }
    /// Writes the state at t = 0 of rod i of a copy, [slots], in the axes of the assembly.
    void start_state_in_assembly(std::int64_t i, std::span<Slot<1>> out) const;

    const RodSpec& spec() const { return spec_; }
    const std::string& name() const { return spec_.name; }
    int id() const { return id_; }
    std::int64_t first_gid() const { return first_gid_; }
    std::int64_t count() const { return places_.count(); }
    int elements() const { return static_cast<int>(element.size()); }
    /// Number of slots of a rod's record: one per node; the last one carries no element. A body has one in all, with
    /// its centre of mass and its frame.
    int slots() const { return static_cast<int>(node_mass.size()); }
    /// Number of distinct nodes: slot n of a ring is a copy of node 0.
    int nodes() const { return slots() - (closed() ? 1 : 0); }
    /// Number of cells between elements.
    int cells() const { return static_cast<int>(voronoi.size()); }
    /// Element on either side of node i, 0 to n, going round a ring; -1 where there is none.
    int element_before(int i) const { return i > 0 ? i - 1 : closed() ? elements() - 1 : -1; }
    int element_after(int i) const { return i < elements() ? i : closed() ? 0 : -1; }
    /// Cell or half cell around node i.
    const VoronoiConstants& cell_at(int i) const {
        if (const int before = element_before(i); before >= 0 && before < cells()) return nth(voronoi, before);
        return i == 0 ? start_wall : end_wall;
    }
    /// True for rods, whose elements lie between nodes and are strained; false for bodies.
    bool strained() const { return !body_; }
    /// Shape of a body; null for rods.
    const BodyShape* body() const { return body_.get(); }
    /// Number of exposed slots of a rod or body. A rod exposes its own, a body two for each part of its surface. The
    /// radius of an exposed slot is that of its element at rest, m, of a box that of the ball around it; it is below 0
    /// where there is none.
    int exposed_slots() const;
    double exposed_radius(int slot) const;
    /// True for a ring: node n is node 0 (its slot a copy, without mass), and cell n-1 joins element n-1 to element 0.
    bool closed() const { return spec_.shape.closed; }
    Law law() const { return spec_.material.law; }
    /// True where an end holds node i, or element i, in all directions. A node that slides is not held; an element is
    /// held by clamped_frozen.
    bool holds_node(int i) const {
        return (i == 0 && spec_.start != EndKind::free && spec_.start_free.empty()) ||
               (i == elements() && spec_.end != EndKind::free && spec_.end_free.empty());
    }
    /// True where an end holds the node in some directions and leaves it free in others.
    bool slides(int i) const {
        return (i == 0 && !spec_.start_free.empty()) || (i == elements() && !spec_.end_free.empty());
    }
    /// Free lab directions of a node that slides: 1, and 0 in others.
    Vec3d free_directions(int i) const { return lab_directions(i == 0 ? spec_.start_free : spec_.end_free); }
    bool holds_element(int k) const {
        return (k == 0 && spec_.start == EndKind::clamped_frozen) ||
               (k == elements() - 1 && spec_.end == EndKind::clamped_frozen);
    }

    /// Lab position of rod i at s = 0, m.
    Vec3d origin(std::int64_t i) const { return places_.origin(i); }
    /// True where rods have directions of their own.
    bool turned() const { return places_.turned(); }
    /// True where walls of ends differ from rod to rod.
    bool walls_differ() const { return turned() || spec_.ends_caught(); }
    CaughtEnds& caught_ends() const { return *caught_; }
    /// Lab frame of the start shape at s = 0, which is that of the wall, where it has not been caught elsewhere. Turned
    /// rods have each their own.
    const Quaterniond& frame() const { return frame_; }
    Quaterniond frame(std::int64_t i) const {
        if (const auto* caught = caught_end(i, 0)) return caught->frame;
        return turned() ? frame_ * places_.turn(i) : frame_;
    }
    /// Frame of the wall at s = length of an undeformed rod: the end frame of the start shape.
    const Quaterniond& end_frame() const { return start_.end_frame; }
    Quaterniond end_frame(std::int64_t i) const {
        if (const auto* caught = caught_end(i, 1)) return caught->frame;
        return turned() ? start_.end_frame * places_.turn(i) : start_.end_frame;
    }

    /// Places of the rods. For a file they are those that this rank has read; partition/partition.hpp distributes them.
    const Places& places() const { return places_; }
    Places& places() { return places_; }
    /// Sets data that depend on all rods of a file, once all ranks have read their parts. `corner` is the smallest x,
    /// y, z of the origins, from which a magnetisation counts; `digest` is the sum of the parts' digests.
    void set_read(const Vec3d& corner, std::uint64_t digest, const LeastLimits& limits);
    /// Takes the places of the rods of `like`, a group that differs in material and ends alone.
    void take_rods_of(const RodGroup& like);
    /// Throws InputError naming the file, the number of rows, the memory that they need and the free memory, where it
    /// is too little.
    void require_memory(std::int64_t rows) const;
    /// Reads all rods of a file that has not been read, without other ranks.
    void read_all();
    const LeastLimits& least_limits() const { return least_limits_; }
    std::uint64_t file_digest() const { return file_digest_; }

    /// Writes the state of rod i at t = 0, [slots].
    void start_state(std::int64_t i, std::span<Slot<1>> out) const;
    /// Directors of the start shape, one per element: those of every rod at t = 0 unless it is turned.
    std::span<const Quaterniond> start_directors() const { return start_.directors; }
    /// Director of element k of rod i at t = 0.
    Quaterniond start_director(std::int64_t i, std::size_t k) const {
        return turned() ? start_.directors[k] * places_.turn(i) : start_.directors[k];
    }
    /// Unit vector of the magnetisation of rod i, lab components at t = 0.
    Vec3d magnetisation(std::int64_t i) const;
    double magnetisation_strength(std::int64_t i) const; ///< A/m
    double largest_magnetisation() const;                ///< over all rods, A/m
    /// Centre of rod i at t = 0, which partitioning uses, m.
    Vec3d centre(std::int64_t i) const {
        const double scale = heterogeneous() ? places_.length(i, spec_.shape.length) / spec_.shape.length : 1;
        return origin(i) + as_turned(i, scale * start_.centre);
    }
    /// Appends the elements of rod i at t = 0 as capsules that hold all of their sections.
    void append_capsules(std::int64_t i, std::vector<Capsule>& capsules) const;
    /// Packed rods: share of the region's volume, and z of its upper end, m.
    double packed_fill() const { return packed_fill_; }
    double packed_top() const { return packed_top_; }

    std::vector<ElementConstants> element;    ///< [n]
    std::vector<VoronoiConstants> voronoi;    ///< [n - 1], a ring's [n]
    std::vector<double> rotary_inertia_scale; ///< [n], j >= 1; empty where all are 1
    std::vector<double> node_mass;            ///< [slots], kg; 0 where kicks leave a node out
    std::vector<double> node_length;          ///< [slots], m: half of the elements on both sides, weighted as the mass
    std::vector<double> cell_weight;          ///< [slots], D_w/D of the cell around a node; empty where all are 1
    /// Density, kg/m^3, for which 4/(nodal_density V) bounds 1/m + 1/m' of the parts that an element of volume V adds
    /// to the masses of its nodes.
    double nodal_density = 0;
    /// Half cells of clamped ends; their dilatation is that of the element there.
    VoronoiConstants start_wall{}, end_wall{};

private:
    /// Null where it is where the scene places it.
    const CaughtEnd* caught_end(std::int64_t i, std::size_t end) const {
        if (!spec_.ends_caught()) return nullptr;
        const auto at = caught_->find(i);
        return at == caught_->end() ? nullptr : &at->second[end];
    }
    /// A lab vector of the start shape, turned as rod i is.
    Vec3d as_turned(std::int64_t i, const Vec3d& offset) const {
        return turned() ? transpose_times(places_.turn(i), offset) : offset;
    }
    RodGroup(const RodGroup& group, std::int64_t i);
    Vec3d magnetisation_at(const Vec3d& place) const;
    void start_state(const Vec3d& start, const Quaterniond& turn, bool turned, std::span<Slot<1>> out) const;
    void compute_constants(Part part = Part::whole);
    void compute_body();
    void forget_kinds();
    void weigh_cells();
    void pack_rods(std::vector<Capsule>* occupied);
    /// Centre of rotation of a rod at t = 0, relative to its origin, m: an end that is pinned, or the centre of mass.
    Vec3d pivot() const;

    std::shared_ptr<const BodyShape> body_;
    RodSpec spec_;
    int id_;
    std::int64_t first_gid_;
    Quaterniond frame_;
    Places places_;
    std::shared_ptr<const AssemblyCopies> copies_; ///< null where the group is in no assembly
    Places within_;                                ///< places in the axes of an assembly
    Vec3d within_corner_{0, 0, 0};                 ///< smallest x, y, z of the origins of a copy
    double packed_fill_ = 0, packed_top_ = 0;
    StartShape start_;
    Vec3d corner_{0, 0, 0};
    std::uint64_t file_digest_ = 0;
    std::shared_ptr<CaughtEnds> caught_ = std::make_shared<CaughtEnds>();
    LeastLimits least_limits_{};
    std::shared_ptr<Kinds> kinds_;
    std::shared_ptr<const std::function<void(RodSpec&)>> formulas_;
    std::optional<std::int64_t> single_rod_;
    bool circle_ = false; ///< a ring of no other shape
};

/// Mean rest radius of the elements that meet at node k, m.
inline double node_radius(const RodGroup& group, std::int64_t k) {
    const std::int64_t last = group.elements() - 1;
    return 0.5 *
           (nth(group.element, std::max<std::int64_t>(k - 1, 0)).radius + nth(group.element, std::min(k, last)).radius);
}

/// Weight D_w/D of the cell or half cell around node i.
inline double cell_weight(const RodGroup& group, std::size_t i) {
    return group.cell_weight.empty() ? 1 : group.cell_weight[i];
}

/// Calls f with the group that has the constants of rod i.
template <class F> decltype(auto) with_rod(const RodGroup& group, std::int64_t i, F&& f) {
    if (!group.heterogeneous()) return f(group);
    const RodGroup::Borrowed own = group.borrow(i);
    return f(std::as_const(*own));
}

/// Calls f(group of its constants, number of rods that have them) once, or for each rod that has sizes of its own.
template <class F> void for_each_kind(const RodGroup& group, F&& f) {
    if (!group.heterogeneous()) return f(group, static_cast<double>(group.count()));
    std::optional<RodGroup> own;
    for (const std::int64_t i : group.places().held()) {
        if (own) own->become(group, i);
        else own.emplace(group.single(i));
        f(std::as_const(*own), 1.0);
    }
}

} // namespace skein
