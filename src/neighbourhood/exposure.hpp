// Exposure: places and rates of bodies, by slot, for interactions to read; and the loads that interactions give back. A
// rank has its own bodies in it and *windows* of others': the elements of ghosts that may touch its own. All stand in
// order of their slots' numbers in the scene, so sums over them have the same order on any number of ranks.
#pragma once

#include "core/transposed.hpp"
#include "neighbourhood/scene_slots.hpp"
#include "neighbourhood/slot_tangent.hpp"
#include "parallel/threads.hpp"
#include "rod/slot_freedom.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/mapping.hpp"
#include "tiles/rods.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace skein {

struct BodyShape;

/// Place of a slot, which is all that a search and the test of a candidate need. Element k of a body lies between its
/// slots k and k + 1; the last slot of a window has no element.
struct ExposedNode {
    Vec3d position; ///< lab, m
    double radius;  ///< radius of the element at rest, m; below 0 where the slot has none
};
static_assert(sizeof(ExposedNode) == 32);
/// Rates of a slot, for contacts alone.
struct ExposedMotion {
    Vec3d velocity; ///< velocity of the node, lab, m/s
    double unused = 0;
    Vec3d spin; ///< spin of the element, lab, rad/s
    double unused_too = 0;
};
static_assert(sizeof(ExposedMotion) == 64);

/// Consecutive slots of one body: all of an own one, some of a ghost.
struct Window {
    std::int64_t gid;
    std::int64_t first_in_scene; ///< slot, see SceneSlots
    std::uint32_t first_slot;    ///< here
    std::uint32_t slots;
    int group;
    bool own;
};

/// Ends at which an element is joined to another of its body.
enum Vertex : std::uint8_t { at_start = 1, at_end = 2 };

/// Written by one pass and by messages, read by all interactions.
class Exposure {
public:
    AlignedVector<ExposedNode> node;     ///< by slot
    AlignedVector<ExposedMotion> motion; ///< by slot
    std::vector<std::int32_t> window_of; ///< window of each slot
    std::vector<std::uint8_t> vertices;  ///< vertices of each slot's element, as bits of Vertex
    /// By slot: share of the way of the fastest node that this one may go until partners are searched again.
    std::vector<float> pace;
    static constexpr double least_pace = 0.25; ///< of slow nodes, which may be pushed
    std::vector<Window> window;                ///< in rising order of slots
    std::vector<std::uint8_t> own;             ///< by window; none where all are
    std::vector<std::int32_t>
        kin; ///< by window: the first of its copy of an assembly here; none where there are no assemblies

    /// Own bodies, in any order; radii are set, places and rates are not.
    Exposure(std::span<const RodGroup> groups, std::span<const LocalRod> bodies);
    /// These windows, in rising order of their slots in the scene; nothing is set. `rates`: there is to be `motion`.
    Exposure(const SceneSlots& scene, std::vector<Window> windows, bool rates = true);

    std::size_t slots() const { return node.size(); }
    bool has_element(std::size_t slot) const { return node[slot].radius >= 0; }
    /// Pace of the faster end of an element, so of all its points.
    double pace_of(std::size_t slot) const { return std::max(pace[slot], pace[slot + 1]); }
    /// Speed of the fastest own node, m/s.
    double largest_speed(const Threads& threads) const;
    /// Sets the paces of own nodes from their speeds, over the largest of all ranks; of slow ones no less than a
    /// quarter, as they may be pushed. All are alike where nothing moves.
    void set_paces(const Threads& threads, double largest_speed);
    const Window& at(std::size_t slot) const { return nth(window, window_of[slot]); }
    std::uint32_t end_of(std::size_t number) const { return window[number].first_slot + window[number].slots; }
    bool owns(std::size_t number) const { return own.empty() || own[number] != 0; }
    /// A number that slots share which never touch: of their body, or of its copy of an assembly.
    std::int32_t kin_of(std::size_t slot) const {
        const std::int32_t number = window_of[slot];
        return kin.empty() ? number : nth(kin, number);
    }
    bool owns_slot(std::size_t slot) const { return owns(to_index(window_of[slot])); }
    const SceneSlots& scene() const { return scene_; }
    std::int64_t in_scene(std::size_t slot) const {
        const Window& w = at(slot);
        return w.first_in_scene + static_cast<std::int64_t>(slot) - w.first_slot;
    }
    /// Element of its body that a slot has.
    std::int64_t element(std::size_t slot) const { return in_scene(slot) - scene_.first_slot(at(slot).gid); }
    /// The slot of the element before (step -1) or behind (1) that of a slot, at a vertex; whoever has a pair has its
    /// neighbours.
    std::uint32_t neighbour(std::size_t slot, int step) const;
    /// f(slot) for an element and those that are joined to it.
    template <class F> void with_neighbours(std::uint32_t slot, F&& f) const {
        f(slot);
        if (vertices[slot] & at_start) f(neighbour(slot, -1));
        if (vertices[slot] & at_end) f(neighbour(slot, 1));
    }
    /// The slot here of one of the scene's, if it is here.
    std::optional<std::uint32_t> find(std::int64_t in_scene) const;
    /// Window of local()[place_in_group of the group's] in the order of rods.
    const Window& of_own(int group, std::size_t place_in_group) const {
        return window[own_window_[nth(first_of_group_, group) + place_in_group]];
    }
    std::size_t number_of_own(int group, std::size_t place_in_group) const {
        return own_window_[nth(first_of_group_, group) + place_in_group];
    }
    /// The window of bodies[i].
    std::size_t number_of_own(std::size_t i) const { return own_window_[i]; }
    /// Exposes `bodies[i]` from its state, to the bit as ExposePass, or ExposeSurfacePass of a body, would.
    void show(std::size_t i, std::span<const Slot<1>> state, const BodyShape* body = nullptr);
    /// Other windows, with the same own bodies among them: the own ones' slots keep what they show.
    void become(Exposure&& other);

    static constexpr std::size_t sent_numbers_per_slot = 9; ///< numbers of a ghost's slot: place, velocity, spin
    static constexpr double bytes_per_slot =
        sizeof(ExposedNode) + sizeof(ExposedMotion) + sizeof(std::int32_t) + sizeof(std::uint8_t) + sizeof(float);

private:
    double speed(std::size_t slot) const;
    template <class F> void for_own_slots(const Threads& threads, F&& f) const;
    void lay_out(bool rates);
    void find_own();

    SceneSlots scene_;
    std::vector<LocalRod> bodies_;            ///< own, as rods have them
    std::vector<std::size_t> first_of_group_; ///< in bodies_
    std::vector<std::uint32_t> own_window_;   ///< window of bodies_[i]
};

/// Load that interactions exert on a slot.
struct alignas(64) ExertedLoad {
    Vec3d force; ///< at the node, lab, N
    double unused = 0;
    Vec3d couple; ///< on the element, lab, N m
    double unused_too = 0;
};
static_assert(sizeof(ExertedLoad) == 64);

/// Sums of all interactions, by slot of the exposure.
struct SlotLoads {
    SlotLoads() = default;
    SlotLoads(const SlotLoads&) = delete; ///< `touched` may be a view of its own marks
    SlotLoads& operator=(const SlotLoads&) = delete;

    AlignedVector<ExertedLoad> load;       ///< only of bodies that are touched
    AlignedVector<SlotTangent> tangent;    ///< the same, where `has_tangents`
    bool has_tangents = false;             ///< steps want the slopes of contacts
    std::span<const std::uint8_t> touched; ///< by window; not 0 where there is a load

    /// No body is touched yet: called before anything adds loads by at().
    void begin(const Exposure& bodies);
    /// Load of an own body's slot, to add to. What keeps marks of its own has set `touched` by then.
    ExertedLoad& at(const Exposure& bodies, std::size_t slot);

    static constexpr double bytes_per_slot = sizeof(ExertedLoad);

private:
    std::vector<std::uint8_t> marks_; ///< `touched`, where begin() or at() has been called
};

/// Exposed slots of a tile's rods, lane by lane.
template <int W> class ExposedLanes {
public:
    ExposedLanes(Exposure& exposure, const RodTile<W>& rod) {
        for (int l = 0; l < W; ++l) {
            if (is_empty(rod, l)) {
                nowhere_.resize(to_index(rod.last) + 1);
                unseen_.resize(nowhere_.size());
                node_[l] = nowhere_.data();
                motion_[l] = unseen_.data();
                continue;
            }
            const std::size_t first = exposure.of_own(rod.group->id(), place_in_group(rod, l)).first_slot;
            node_[l] = &exposure.node[first];
            motion_[l] = &exposure.motion[first];
        }
    }
    SKEIN_INLINE void store(std::size_t k, const Vec3<Pack<W>>& position, const Pack<W>& radius,
                            const Vec3<Pack<W>>& velocity, const Vec3<Pack<W>>& spin) const {
        store_transposed<W>(position, radius, [&](int l) { return &node_[l][k].position.x; });
        store_transposed<W>(velocity, Pack<W>(0.0), [&](int l) { return &motion_[l][k].velocity.x; });
        store_transposed<W>(spin, Pack<W>(0.0), [&](int l) { return &motion_[l][k].spin.x; });
    }

    /// Place of a lane's rod among those of its group on this rank. Spare lanes repeat the last rod; of strands they
    /// are empty.
    static bool is_empty(const RodTile<W>& rod, int l) { return rod.strands && l >= rod.lanes; }
    static std::size_t place_in_group(const RodTile<W>& rod, int l) {
        return rod.first + to_index(std::min(l, rod.lanes - 1));
    }

private:
    ExposedNode* node_[W];
    ExposedMotion* motion_[W];
    AlignedVector<ExposedNode> nowhere_; ///< of empty lanes
    AlignedVector<ExposedMotion> unseen_;
};

/// Last pass before interactions: nodes and spins in the lab. Radii stay those of rest: were they to follow the
/// stretch, contact would do work on it that no force takes.
template <int W, class Map = Across<W>> class ExposePass final : public TilePass<W> {
public:
    /// `led`: freedom of slots, where ends are led to where they are at the time of the loads.
    explicit ExposePass(std::shared_ptr<Exposure> exposure, std::vector<SlotFreedom> led = {})
        : exposure_(std::move(exposure)), led_(std::move(led)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        if (!step.meets()) return;
        if (step.ahead == 0) return show(rod, [](const Slot<W>& s, std::size_t) { return s.position; });
        show(rod, [&](const Slot<W>& s, std::size_t k) {
            Vec3d ahead{step.ahead, step.ahead, step.ahead};
            if (!led_.empty()) {
                const double gone = step.time - step.begin;
                const auto& free = led_[k].free;
                ahead -= gone * Vec3d{1 - free[0], 1 - free[1], 1 - free[2]};
            }
            return s.position + scale(broadcast<W>(ahead), s.velocity);
        });
    }

private:
    template <class Place> void show(const RodTile<W>& rod, Place&& place) const {
        using P = Pack<W>;
        const ExposedLanes<W> lanes(*exposure_, rod);
        for (int k = 0; k <= rod.n; ++k) {
            const Slot<W>& s = rod.slot[k];
            P radius(-1.0);
            Vec3<P> turning{};
            if (k < rod.n) {
                radius = P(Map::element(rod, k).radius);
                turning = transpose_times(s.director, s.spin);
            }
            lanes.store(to_index(k), place(s, to_index(k)), radius, s.velocity, turning);
        }
    }

    std::shared_ptr<Exposure> exposure_;
    std::vector<SlotFreedom> led_; ///< by slot; empty where no end is led
};

/// Loads of a tile's rods, slot by slot; nothing where a rod is not touched.
template <int W> class LoadsOfLanes {
public:
    LoadsOfLanes(const Exposure& exposure, const SlotLoads& loads, const RodTile<W>& rod) {
        static constexpr ExertedLoad none{};
        for (int l = 0; l < W; ++l) {
            taken_[l] = &none;
            step_[l] = 0;
            if (ExposedLanes<W>::is_empty(rod, l)) continue;
            const std::size_t number = exposure.number_of_own(rod.group->id(), ExposedLanes<W>::place_in_group(rod, l));
            const bool touched = loads.touched[number];
            if (touched) taken_[l] = &loads.load[exposure.window[number].first_slot];
            step_[l] = touched;
            any_ |= touched;
        }
    }
    bool any() const { return any_; }
    SKEIN_INLINE Vec3<Pack<W>> force(std::size_t k) const {
        return load_transposed<W>([&](int l) { return &at(l, k).force.x; }).vector;
    }
    SKEIN_INLINE Vec3<Pack<W>> couple(std::size_t k) const {
        return load_transposed<W>([&](int l) { return &at(l, k).couple.x; }).vector;
    }

private:
    SKEIN_INLINE const ExertedLoad& at(int l, std::size_t k) const { return taken_[l][step_[l] * k]; }
    const ExertedLoad* taken_[W];
    std::size_t step_[W];
    bool any_ = false;
};

/// Before the kick: forces and couples that interactions have found.
template <int W> class TakeLoadsPass final : public TilePass<W> {
public:
    TakeLoadsPass(std::shared_ptr<const Exposure> exposure, std::shared_ptr<const SlotLoads> loads)
        : exposure_(std::move(exposure)), loads_(std::move(loads)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        const LoadsOfLanes<W> taken(*exposure_, *loads_, rod);
        if (!taken.any()) return;
        for (int k = 0; k <= rod.n; ++k) {
            const auto slot = to_index(k);
            load[k].force += taken.force(slot);
            if (k < rod.n) load[k].couple += rod.slot[k].director * taken.couple(slot);
        }
    }

private:
    std::shared_ptr<const Exposure> exposure_;
    std::shared_ptr<const SlotLoads> loads_;
};

} // namespace skein
