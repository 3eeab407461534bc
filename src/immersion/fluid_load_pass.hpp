// Pass that adds loads of the fluid, and scales all loads for the effective inertia of rods in it.
//                                                                                                theory.md (88), (89)
#pragma once

#include "core/transposed.hpp"
#include "immersion/fluid_loads.hpp"
#include "immersion/inertia_in_fluid.hpp"
#include "rod/bearing.hpp"
#include "rod/slot_freedom.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace skein {

/// Last pass before the kick. Its drag is implicit: it acts on the rates after the kick, so any strength is stable.
/// These are 0 where the slot is held, and those that bearings leave. Loads are divided by the effective share of the
/// inertia, because the kick divides by the rod's own.
template <int W> class FluidLoadPass final : public TilePass<W> {
public:
    FluidLoadPass(std::shared_ptr<FluidLoads> loads, const RodGroup& group, const InertiaInFluid& inertia)
        : loads_(std::move(loads)), bearings_(bearings_of(group)) {
        const std::vector<SlotFreedom> freedom = slot_freedoms(group);
        for (int k = 0; k < group.slots(); ++k) {
            const double effective = nth(inertia.of_nodes, k).effective, mass = effective * nth(group.node_mass, k);
            per_share_.push_back(1 / effective);
            const auto& free = nth(freedom, k).free;
            per_mass_.push_back(mass > 0 ? (1 / mass) * Vec3d{free[0], free[1], free[2]} : Vec3d{0, 0, 0});
        }
        for (int k = 0; k < group.elements(); ++k) {
            const Vec3d& effective = nth(inertia.of_elements, k).effective;
            per_turning_share_.push_back({1 / effective.x, 1 / effective.y, 1 / effective.z});
            const auto& free = nth(freedom, k).free;
            per_inertia_.push_back(free[3] + free[4] + free[5] == 0
                                       ? Vec3d{0, 0, 0}
                                       : scale(per_turning_share_.back(), nth(group.element, k).inv_inertia));
        }
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        using P = Pack<W>;
        std::size_t first[W];
        for (int l = 0; l < W; ++l) // spare lanes repeat the last rod
            first[l] = loads_->first(rod.group->id(), rod.first + to_index(std::min(l, rod.lanes - 1)));
        const P kick(step.kick);
        const auto of_slot = [&](std::size_t slot, auto member) {
            return load_transposed<W>([&](int l) { return &(loads_->load[first[l] + slot].*member).x; }).vector;
        };
        for (const Bearing& b : bearings_) {
            const std::size_t slot = to_index(b.element);
            const Slot<W>& s = rod.slot[slot];
            load[slot].couple +=
                of_bearing(b, s, s.director * of_slot(slot, &FluidLoad::couple) + load[slot].couple,
                           of_slot(slot, &FluidLoad::turn_drag), kick * broadcast<W>(per_inertia_[slot]));
        }
        for (int k = 0; k <= rod.last; ++k) {
            const std::size_t slot = to_index(k);
            const auto of = [&](auto member) { return of_slot(slot, member); };
            const auto add = [&](auto member, const Vec3<P>& impulse) {
                const auto at = [&](int l) { return &(loads_->received[first[l] + slot].*member).x; };
                store_transposed<W>(load_transposed<W>(at).vector + impulse, P(0.0), at);
            };
            const Slot<W>& s = rod.slot[k];
            const Vec3<P> push = implicit(of(&FluidLoad::push), of(&FluidLoad::drag), load[k].force, s.velocity,
                                          broadcast<W>(per_mass_[slot]), kick);
            add(&FluidImpulse::on_node, kick * push);
            load[k].force = P(per_share_[slot]) * (load[k].force + push);
            if (k == rod.n) break;
            const Vec3<P> couple = implicit(s.director * of(&FluidLoad::couple), of(&FluidLoad::turn_drag),
                                            load[k].couple, s.spin, broadcast<W>(per_inertia_[slot]), kick);
            add(&FluidImpulse::on_element, kick * transpose_times(s.director, couple));
            load[k].couple = scale(broadcast<W>(per_turning_share_[slot]), load[k].couple + couple);
        }
    }

private:
    using P = Pack<W>;
    /// push - drag (rate after the kick).
    static Vec3<P> implicit(const Vec3<P>& push, const Vec3<P>& drag, const Vec3<P>& other, const Vec3<P>& rate,
                            const Vec3<P>& per_inertia, P kick) {
        const auto one = [&](P a, P d, P f, P v, P per) {
            const P gain = kick * per;
            return (a - d * fma(gain, f, v)) / fma(gain, d, P(1.0));
        };
        return {one(push.x, drag.x, other.x, rate.x, per_inertia.x),
                one(push.y, drag.y, other.y, rate.y, per_inertia.y),
                one(push.z, drag.z, other.z, rate.z, per_inertia.z)};
    }

    /// Couple of a bearing, with which the rate after the kick is one that it leaves. Others but the drag add up to
    /// `couple`.
    static Vec3<P> of_bearing(const Bearing& bearing, const Slot<W>& s, const Vec3<P>& couple, const Vec3<P>& drag,
                              const Vec3<P>& gain) {
        const auto dragged = [](const P& g, const P& d) { return g / fma(g, d, P(1.0)); };
        const Vec3<P> by_couple{dragged(gain.x, drag.x), dragged(gain.y, drag.y), dragged(gain.z, drag.z)};
        const auto turned = [](const P& by, const P& g, const P& c, const P& w) { return by * (c + w / g); };
        const Vec3<P> rate{turned(by_couple.x, gain.x, couple.x, s.spin.x),
                           turned(by_couple.y, gain.y, couple.y, s.spin.y),
                           turned(by_couple.z, gain.z, couple.z, s.spin.z)};
        const Vec3<P> change = rate_on(bearing, s.director, rate, by_couple) - rate;
        return {change.x / by_couple.x, change.y / by_couple.y, change.z / by_couple.z};
    }

    std::shared_ptr<FluidLoads> loads_;
    std::vector<Bearing> bearings_;
    std::vector<double> per_share_;             ///< by slot: 1 over the effective share of its mass
    std::vector<Vec3d> per_turning_share_;      ///< by element, body: 1 over the effective share of its inertia
    std::vector<Vec3d> per_mass_, per_inertia_; ///< by slot: 1 over the effective inertia, 0 if the slot is held
};

} // namespace skein
