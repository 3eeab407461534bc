// The step of one group as data: passes over its tiles, in order. The plan prints these lists, and
// kernels/make_pass.hpp makes exactly what they name. Passes of rods by themselves are here; those of a physics are in
// kernels/physics_passes.hpp, and the physics adds them to programs.                                   theory.md (20)
#pragma once

#include "loads/damping.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/kick.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"

#include <any>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skein {

/// Places in a step, in order. Those up to `expose` come before rods feel each other.
enum class PassPlace {
    drift,
    ring,
    before_ends,
    ends,
    frames,
    expose,
    internal,
    internal_done,
    loads,
    loads_done,
    connections,
    boundaries,
    before_neighbours,
    neighbours,
    neighbours_done,
    last_loads,
    ring_sum,
    sum_done,
    medium,
    medium_done,
    kick,
    slide,
    filter,
    second_kick,
    last_slide,
    hold,
    bearings,
    balance
};

/// A pass of a program. `kind` is the structure that it is made from.
struct PassSpec {
    PassPlace place;
    std::string_view name;
    double ns = 0;           ///< expected time per element-step and core where all lanes carry a rod, for predictions
    bool lies_along = false; ///< it can run over rods cut into strands (tiles/strands.hpp)
    bool lies_whole = false; ///< it can run over strands that are whole rods
    std::string family;      ///< what else groups must share to share tiles along
    bool has_tables = false; ///< of its group: rods with sizes of their own have each their own
    std::any kind;

    template <class Kind> const Kind* get() const { return std::any_cast<Kind>(&kind); }
};

/// A pass by its structure, which has a name, and may have members or functions `ns`, `lies_along`,
/// `lies_whole`, `family` and `has_tables`.
template <class Kind> PassSpec pass_of(PassPlace place, Kind kind) {
    PassSpec spec{.place = place, .name = {}, .family = {}, .kind = {}};
    if constexpr (requires { kind.name(); }) spec.name = kind.name();
    else spec.name = kind.name;
    if constexpr (requires { kind.ns(); }) spec.ns = kind.ns();
    else if constexpr (requires { kind.ns; }) spec.ns = kind.ns;
    if constexpr (requires { kind.lies_along(); }) spec.lies_along = kind.lies_along();
    if constexpr (requires { kind.lies_whole(); }) spec.lies_whole = kind.lies_whole();
    if constexpr (requires { kind.family; }) spec.family = kind.family;
    if constexpr (requires { kind.has_tables(); }) spec.has_tables = kind.has_tables();
    spec.kind = std::move(kind);
    return spec;
}

namespace pass {

// Medians of bench/micro at 8 lanes on a 2.5 GHz Cascade Lake core, ns per element-step.

/// Positions and frames at constant rates.
struct Drift {
    Gyration top;
    std::string_view name() const { return nth(drift_names, top); }
    double ns() const { return top == Gyration::circular ? 3.2 : 9; }
    bool lies_along() const { return top != Gyration::plain && top != Gyration::elliptic_each; }
};
/// The same of rods with elements on bearings.
struct DriftOnBearings {
    Gyration top;
    static constexpr std::string_view name = "drift (bearings)";
    double ns() const { return Drift{top}.ns(); }
};
/// A ring's last node takes the place of its first.
struct CloseRing {
    static constexpr std::string_view name = "close ring";
};
struct MoveEnds {
    static constexpr std::string_view name = "move ends";
};
struct Orthonormalise {
    static constexpr std::string_view name = "orthonormalise";
    static bool lies_along() { return true; }
};
/// Places, rates and radii go where other rods look.
struct Expose {
    static constexpr std::string_view name = "expose";
    static bool lies_whole() { return true; }
};
/// Exposes all parts of a body's surface.
struct ExposeSurface {
    static constexpr std::string_view name = "expose surface";
};
/// Sets internal loads.
struct Elastic {
    Law law;
    static constexpr double ns = 5.6;
    std::string_view name() const;
    bool lies_along() const { return law != Law::elastica; }
};
/// In the place of that of bodies: nothing is strained.
struct Unstrained {
    static constexpr std::string_view name = "unstrained";
};
/// Adds the loads that other rods have left on its slots.
struct TakeLoads {
    static constexpr std::string_view name = "neighbour loads";
    static bool lies_whole() { return true; }
};
/// Adds those on a body's surface, as force and moment.
struct TakeSurfaceLoads {
    static constexpr std::string_view name = "neighbour loads (surface)";
};
/// The load on a ring's last node goes to its first.
struct FoldRing {
    static constexpr std::string_view name = "fold ring";
};
/// Rates, over a `share` of the step.
struct Kick {
    KickKind kind;
    double share;
    std::string_view name() const { return nth(kick_names, kind); }
    double ns() const { return share * (kind == KickKind::undamped || kind == KickKind::constant_rates ? 1 : 1.6); }
    bool lies_along() const { return kind != KickKind::elastica; }
};
/// Laplacian filter of the rates.
struct Filter {
    static constexpr std::string_view name = "laplacian filter";
    long order;
    double rate; ///< 1/s
    FilterTime time = FilterTime::in_kick;
    /// By the ratio of runs with and without a filter of order 1, 2 and 4.
    double ns() const { return 9 + 1.5 * static_cast<double>(order); }
};
struct Hold {
    static constexpr std::string_view name = "hold";
    static bool lies_whole() { return true; }
};
/// Impulses of bearings: by inertia where a kick damps nothing, or by what a damped kick over a `share` of the step
/// makes of them.
struct Bearings {
    KickKind kind = KickKind::undamped;
    double share = 1;
    static constexpr std::string_view name = "bearings";
};
/// Held directions of ends that slide in others.
struct Slide {
    static constexpr std::string_view name = "slide";
    bool clamped_last; ///< strands keep the frame of such a clamp where an element would be, whose pull the held node
                       ///< does not feel
    bool lies_along() const { return !clamped_last; }
};

} // namespace pass

/// Passes of a step, in order.
class GroupProgram {
public:
    /// Adds a pass after those of its place and of earlier ones.
    void add(PassSpec pass);
    template <class Kind> void add(PassPlace place, Kind kind) { add(pass_of(place, std::move(kind))); }
    /// Puts a pass where another stands.
    template <class Kind> void replace(PassPlace place, Kind kind) {
        for (PassSpec& pass : passes_)
            if (pass.place == place) pass = pass_of(place, kind);
    }

    /// Leaves out what stands in a place.
    void remove(PassPlace place) {
        std::erase_if(passes_, [place](const PassSpec& pass) { return pass.place == place; });
    }

    std::size_t size() const { return passes_.size(); }
    /// Number of passes before rods feel each other.
    std::size_t before() const;
    const PassSpec& operator[](std::size_t i) const { return passes_[i]; }
    auto begin() const { return passes_.begin(); }
    auto end() const { return passes_.end(); }
    std::vector<std::string_view> names() const;
    bool has(PassPlace place) const;
    /// The first of a kind; null where there is none.
    template <class Kind> const Kind* find() const {
        for (const PassSpec& pass : passes_)
            if (const Kind* kind = pass.get<Kind>()) return kind;
        return nullptr;
    }
    bool lies_along() const;

private:
    std::vector<PassSpec> passes_;
};

struct GroupPlan;
/// Passes of a group by itself, whose kick and damping are known. `acts_between`: some physics acts between rods.
GroupProgram program_of(const RodGroup& group, const GroupPlan& plan, bool acts_between);

} // namespace skein
