// The published drift: rotations with 1e-14 added to the angle that the axis is divided by, two half drifts between two kicks. The
// 1e-14 takes as much off every turn: 2e-11 rad in 1000 steps, and up to 2e-9 of the angular velocity. W = 1.
#pragma once

#include "rod/drift.hpp"

namespace skein::replay {

/// Q <- R(h w) Q with the axis h w/(|h w| + 1e-14), as a turn by that much less.
struct PublishedTop {
    template <int W> SKEIN_INLINE static void turn(const ElementConstants&, Quaternion<Pack<W>>& q, Vec3<Pack<W>>& w, Pack<W> h) {
        const Vec3<Pack<W>> v = h * w;
        const Pack<W> angle = norm(v);
        q = rotation<W>(angle / (angle + Pack<W>(1e-14)) * v) * q;
    }
};

class PublishedDrift final : public TilePass<1> {
public:
    /// `stages`: of a step; its first drift is the closing one of the step before and its own.
    explicit PublishedDrift(std::size_t stages) : stages_(stages) {}
    std::string_view name() const override { return "drift (as published)"; }
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step& step) const override {
        const bool two = step.index > 1 && static_cast<std::size_t>(step.slot) % stages_ == 0;
        for (int i = 0; i <= two; ++i) drift<PublishedTop>(rod, two ? 0.5 * step.drift : step.drift);
    }

private:
    std::size_t stages_;
};

/// Copies moved on to the end of their step; constraints and the closing of rings come after.
inline void close_step(const RodGroup& group, std::span<Slot<1>> state, double h) {
    const RodTile<1> rod{state.data(), group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {0}, 1};
    drift<PublishedTop>(rod, h);
}

} // namespace skein::replay
