// The published drift: rotations with 1e-14 added to the angle that the axis is divided by, two half drifts between two
// kicks. The 1e-14 takes as much off every turn: 2e-11 rad in 1000 steps, and up to 2e-9 of the angular velocity. W
// = 1.
#pragma once

#include "mechanics/drift.hpp"

namespace skein::replay {

/// Q <- R(h w) Q with the axis h w/(|h w| + 1e-14), as a turn by that much less.
struct PublishedTop {
    template <int W>
    SKEIN_INLINE static void turn(const ElementConstants&, Quaternion<Pack<W>>& q, Vec3<Pack<W>>& w, Pack<W> h) {
        const Vec3<Pack<W>> v = h * w;
        const Pack<W> angle = norm(v);
        q = rotation<W>(angle / (angle + Pack<W>(1e-14)) * v) * q;
    }
};

/// The drifts of a stage: that which opens a step closes the one before as well, and is two.
struct Drifts {
    int count;
    double length; ///< s, of each
};
inline Drifts drifts_of(const Step& step, std::size_t stages) {
    const bool opens = step.index > 1 && static_cast<std::size_t>(step.slot) % stages == 0;
    return opens ? Drifts{2, 0.5 * step.drift} : Drifts{1, step.drift};
}

class PublishedDrift final : public TilePass<1> {
public:
    /// `stages`: of a step.
    explicit PublishedDrift(std::size_t stages) : stages_(stages) {}
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step& step) const override {
        const auto [count, length] = drifts_of(step, stages_);
        for (int i = 0; i < count; ++i) drift<PublishedTop>(rod, length);
    }

private:
    std::size_t stages_;
};

} // namespace skein::replay
