// Walls in implicit steps: loads and slopes at trial states, and the memory of contacts at the ends of stages.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"
#include "skein/tiles/tile.hpp"

#include <cstddef>

namespace skein {

/// Slopes of the loads of walls on the rods of a tile, lab. A point i moves with x and turns with t, the mean of its
/// elements. Its force changes by A x + B t, the couple there by C x + D t.
template <int W> struct WallSlopes {
    using P = Pack<W>;
    struct Point {
        P force[3][3]{}, force_by_turn[3][3]{}, couple[3][3]{}, couple_by_turn[3][3]{};
    };
    AlignedVector<Point> point; ///< of rods
    P body[6][6]{};             ///< of bodies, by displacement and turn
    Vec3<P> couple{};           ///< on them, N m
    P begins{};                 ///< 1 where a contact begins that is too stiff for its stage
    bool touches = false;

    void clear() {
        begins = P(0.0);
        if (!touches) return;
        for (Point& p : point) p = {};
        for (auto& line : body)
            for (P& entry : line) entry = P(0.0);
        couple = {P(0.0), P(0.0), P(0.0)};
        touches = false;
    }
};

/// Times of a stage, s, lane by lane: to the state where loads are evaluated, and on at the same rates.
template <int W> struct StageSpan {
    Pack<W> to, on;
    bool between; ///< forces stand for the way from start to end, in the middle of which the state is
};

template <int W> class ImplicitWalls {
public:
    virtual ~ImplicitWalls() = default;
    /// Adds loads at a state of a stage and notes their slopes. `start`: slots where the stage begins.
    virtual void try_state(const RodTile<W>& rod, const Slot<W>* start, SlotLoad<W>* load, const Step& step,
                           const StageSpan<W>& span) const = 0;
    /// The stage ends with the loads of this state, and contacts remember it.
    virtual void end_stage(const RodTile<W>& rod, const Slot<W>* start, const Step& step,
                           const StageSpan<W>& span) const = 0;
    /// Slopes at the state tried last.
    virtual const WallSlopes<W>& slopes(std::size_t tile) const = 0;
    /// Keeps the memory and figures of contacts in one of two places, and takes them back.
    virtual void keep(std::size_t place) = 0;
    virtual void go_back(std::size_t place) = 0;
};

} // namespace skein
