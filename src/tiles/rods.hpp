// All rods that this rank owns, as tiles of W lanes: the interface for simulation, io and diagnostics.
#pragma once

#include "core/hash.hpp"
#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"
#include "skein/time/clock.hpp"
#include "tiles/pass_effect.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// A rod owned by this rank.
struct LocalRod {
    std::int64_t gid;   ///< number of the rod in the scene, which never changes
    int group;          ///< number of its RodGroup
    std::int64_t index; ///< number of the rod in its group
};

/// Place of a rod: a tile, by its number within those of its program, and a lane of it. Programs are of groups, by
/// number; behind them come those of rods with constants of their own.
struct RodPlace {
    std::size_t program, tile;
    int lane;
};

/// Energy budget of a rod since its audit began, J: work of loads, work of walls, energy dissipated, work of the fluid.
/// See mechanics/audit.hpp.
struct RodBudget {
    double loads = 0, walls = 0, dissipated = 0;
    double held_before = 0; ///< kinetic energy of held nodes and elements, between the halves of a step
    double fluid = 0;
    double numerical = 0; ///< taken by implicit steps
};

/// Content of a copy of a rod's state.
enum class Copy {
    canonical,    ///< state as stored, and its hash
    positions,    ///< nodes synchronised with the rates
    synchronised, ///< elements synchronised too
    frames,       ///< synchronised, with directors as matrices
    strained      ///< frames, and strains at nodes
};
constexpr bool has_frames(Copy copy) { return copy == Copy::frames || copy == Copy::strained; }

/// Strains of a rod at a node; see mechanics/rod_profile.hpp.
template <class P> struct NodeProfileOf {
    P strain;    ///< axial strain e - e0; mean of the elements that meet here
    P curvature; ///< curvature of the axis, 1/m; 0 at ends that are not clamped
    P energy;    ///< elastic energy, J per metre of rest length
};
using NodeProfile = NodeProfileOf<double>;

/// State of a rod, assembled from its lanes; valid while the reader runs.
struct RodCopy {
    std::span<const Slot<1>> state;       ///< [n + 1]
    std::span<const Mat3d> frames;        ///< [n], rows d1 d2 d3, where has_frames(copy)
    std::span<const NodeProfile> profile; ///< [n + 1], in Copy::strained
    std::uint64_t hash = 0;               ///< hash_rod, in Copy::canonical

    /// d1 at a node, from a copy with frames: mean of the elements that meet there.
    Vec3d normal(std::size_t node) const {
        return 0.5 * (frames[node > 0 ? node - 1 : 0].d1 + frames[std::min(node, frames.size() - 1)].d1);
    }
};
using RodReader = std::function<void(int thread, std::size_t i, const RodCopy& copy)>;

/// Contribution of one rod to sums over the scene, and to extremes.
struct RodFigures {
    enum Sum {
        translation, ///< kinetic energy, J
        rotation,
        stretch, ///< elastic energy, J; half cells at walls included in bending
        shear,
        bend,
        twist,
        momentum_x, ///< kg m/s, lab
        momentum_y,
        momentum_z,
        mass_x, ///< mass times position, kg m
        mass_y,
        mass_z,
        mass,
        sums
    };
    enum Extreme {
        speed,  ///< speed of a node, m/s
        strain, ///< axial strain
        turn,   ///< rotation between neighbouring elements, rad
        skew,   ///< deviation of directors from unit length
        extremes
    };
    double sum[sums];
    double extreme[extremes];
};

class Rods {
public:
    virtual ~Rods() = default;

    /// Advances every rod by the given steps, tile by tile. With `check`, returns false if a rod is invalid (see
    /// inspect).
    virtual bool advance(std::span<const Step> steps, bool check) = 0;
    /// First and second half of a step of rods that interact: before and after their coupling. With `check`, the second
    /// returns false if a rod is invalid.
    virtual void drift(const Step& step) = 0;
    virtual bool kick(const Step& step, bool check) = 0;
    /// kick(step), then drift(next), in one sweep over the tiles. The steps must have different slots.
    virtual void kick_and_drift(const Step& step, const Step& next) = 0;
    /// Prepares the passes of new rods, whose states are imported between the halves of this step, for the second half.
    virtual void begin_within(const Step& step) = 0;
    /// Text naming the rod whose strains leave the least margin of the step, where the last check found one near its
    /// limit (mechanics/step_watch.hpp).
    virtual std::string near_limit() const = 0;

    /// Names of the passes of a group's rods across, in order; empty where no rod lies across.
    virtual std::vector<std::string_view> passes(std::size_t group) const = 0;
    /// Evaluates formulas of places again, whose tables have changed.
    virtual void renew_formulas() = 0;
    /// Owned rods, ordered by group, and in space order within a group.
    virtual std::span<const LocalRod> local() const = 0;
    /// Place of local()[i] among rods across.
    virtual RodPlace place(std::size_t i) const = 0;
    /// Copies the canonical (staggered) state of local()[i] out or in, one slot per node.
    virtual void export_rod(std::size_t i, std::span<Slot<1>> out) const = 0;
    virtual void import_rod(std::size_t i, std::span<const Slot<1>> in) = 0;
    /// Calls reader(thread, i, copy) with a copy of local()[rods[i]] for every i, on all threads, tile by tile. Few
    /// rods let threads share tiles. `rods` must rise. `lag`: time by which copies other than canonical ones advance,
    /// s. `time`: time of turning walls in strained copies, s.
    virtual void read(std::span<const std::size_t> rods, Copy copy, double lag, const RodReader& reader,
                      double time = 0) const = 0;
    /// Writes the figures of every owned rod, [local], from copies advanced by `lag` to `time`.
    virtual void figures(double time, double lag, std::span<RodFigures> out) const = 0;
    /// Sum over owned rods of a hash of (gid, canonical state), modulo 2^64. Any distribution of rods gives the same
    /// sum.
    virtual std::uint64_t digest() const = 0;
    /// Throws NumericalError naming rod, element and quantity where a rod is invalid: not finite, an element inverted,
    /// or strains at which the step is too long.
    virtual void inspect(std::int64_t step, double dt) const = 0;
    /// Energy budget of local()[i]; zeros without an audit.
    virtual RodBudget budget(std::size_t i) const = 0;
    /// True where budgets of a group have work of a fluid, on any rank.
    virtual bool budgets_fluid(std::size_t group) const = 0;
    /// True where budgets of a group have what implicit steps take.
    virtual bool budgets_steps(std::size_t group) const = 0;
    /// Continues from the sums of a checkpoint; no effect without an audit.
    virtual void set_budget(std::size_t i, const RodBudget& budget) = 0;
    /// Memory of passes about local()[i] from step to step: the same numbers for any width and lane.
    virtual std::vector<double> memory(std::size_t i) const = 0;
    virtual void set_memory(std::size_t i, std::span<const double> numbers) = 0;
    /// Number of threads that work on rods.
    virtual int threads() const = 0;
    /// Makes the stages of one step with local()[i] and the rods in its tile, and returns the effect of each pass, in
    /// order. Loads of other rods are those of their last step. It serves a diagnosis, after which the state is
    /// restored.
    virtual std::vector<PassEffect> dissect(std::size_t i, std::span<const Step> stages) {
        static_cast<void>(i);
        static_cast<void>(stages);
        return {};
    }
    /// Keeps the state in a place of its own, 0 or 1; returns to it. Memory of passes stays as it is.
    virtual void keep(std::size_t place) = 0;
    virtual void go_back(std::size_t place) = 0;
    /// Largest distance of a node from where a kept state has it, m.
    virtual double farthest_from(std::size_t place) const = 0;
    /// Bytes held for state, parameters and scratch.
    virtual std::size_t bytes() const = 0;
    /// Largest ratio of the step to the limit that strains left, at any check and for any rod without damping, where it
    /// was beyond StepWatch::feeds; 0 otherwise.
    virtual double undamped_share() const { return 0; }
};

/// Hash of a rod's canonical state, its term of the state digest.
std::uint64_t hash_rod(std::int64_t gid, std::span<const Slot<1>> state);

} // namespace skein
