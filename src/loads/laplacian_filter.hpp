// Laplacian filter of the rates, after the kick: smooth motion stays, what alternates from node to node goes.   theory.md (41)
//   f = v;  p times: f_i <- (2 f_i - f_{i-1} - f_{i+1})/4 inside, 0 at both ends;  v <- v - f;  spins alike
// In a ring indices run round.
// Spins are filtered in body components. A wave of angle theta from node to node keeps 1 - sin(theta/2)^(2p) of itself per step,
// whatever the step: the shorter the step, the stronger the damping per second. Momentum is not kept. End nodes and end elements
// keep their rates, held or not. Source: PyElastica's LaplaceDissipationFilter; Jeanmart & Winckelmans 2007 (Phys. Fluids 19,
// 055110). Cost: 24 p flop per element.
#pragma once

#include "rod/tile.hpp"

namespace skein {

template <int W> class LaplacianFilterPass final : public TilePass<W> {
public:
    static constexpr std::string_view pass_name = "laplacian filter";
    explicit LaplacianFilterPass(long order) : order_(order) {}
    std::string_view name() const override { return pass_name; }

    /// The loads are spent once the kick has used them, and serve as scratch.
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        for (int i = 0; i <= rod.n; ++i) load[i].force = rod.slot[i].velocity;
        for (int k = 0; k < rod.n; ++k) load[k].couple = rod.slot[k].spin;
        if (rod.group->closed()) {
            for (long p = 0; p < order_; ++p) {
                differ_round<&SlotLoad<W>::force>(load, rod.n);
                differ_round<&SlotLoad<W>::couple>(load, rod.n);
            }
            for (int i = 0; i < rod.n; ++i) rod.slot[i].velocity -= load[i].force, rod.slot[i].spin -= load[i].couple;
            return;
        }
        for (long p = 0; p < order_; ++p) {
            differ<&SlotLoad<W>::force>(load, rod.n + 1);
            differ<&SlotLoad<W>::couple>(load, rod.n);
        }
        for (int i = 1; i < rod.n; ++i) rod.slot[i].velocity -= load[i].force;
        for (int k = 1; k + 1 < rod.n; ++k) rod.slot[k].spin -= load[k].couple;
    }

private:
    using P = Pack<W>;
    template <auto Field> static void differ_round(SlotLoad<W>* f, int count) {
        const Vec3<P> first = f[0].*Field;
        Vec3<P> before = f[count - 1].*Field;
        for (int i = 0; i < count; ++i) {
            const Vec3<P> here = f[i].*Field, after = i + 1 < count ? f[i + 1].*Field : first;
            f[i].*Field = P(0.25) * (here + here - before - after);
            before = here;
        }
    }
    template <auto Field> static void differ(SlotLoad<W>* f, int count) {
        Vec3<P> before = f[0].*Field;
        for (int i = 1; i + 1 < count; ++i) {
            const Vec3<P> here = f[i].*Field;
            f[i].*Field = P(0.25) * (here + here - before - f[i + 1].*Field);
            before = here;
        }
        f[0].*Field = f[count - 1].*Field = {P(0.0), P(0.0), P(0.0)};
    }

    long order_;
};

} // namespace skein
