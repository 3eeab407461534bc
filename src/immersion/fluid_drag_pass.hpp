// Pass that adds loads of the fluid for steps that solve for the rates in them. theory.md (88), (89)
#pragma once

#include "core/transposed.hpp"
#include "immersion/fluid_loads.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"

#include <algorithm>
#include <memory>

namespace skein {

/// push - drag (rate now), for the whole inertia that a step feels. What rods receive is booked when rates are known.
template <int W> class FluidDragPass final : public TilePass<W> {
    using P = Pack<W>;

public:
    explicit FluidDragPass(std::shared_ptr<FluidLoads> loads) : loads_(std::move(loads)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        const Lanes first = first_of(rod);
        for (int k = 0; k <= rod.last; ++k) load[k].force += force(rod, first, k);
        for (int k = 0; k < rod.n; ++k) load[k].couple += couple(rod, first, k);
    }
    /// Drags of a slot: of lab components of the velocity, kg/s; of body components of the spin, N m s.
    struct Drags {
        Vec3<Pack<W>> node, element;
    };
    Drags drags(const RodTile<W>& rod, int k) const {
        const Lanes first = first_of(rod);
        return {of_slot(first, k, &FluidLoad::drag), of_slot(first, k, &FluidLoad::turn_drag)};
    }
    /// Adds the impulses of a time, s, at the present rates.
    void book(const RodTile<W>& rod, const P& time) const {
        const Lanes first = first_of(rod);
        const auto add = [&](int k, auto member, const V& impulse) {
            const auto at = [&](int l) { return &(loads_->received[first.slot[l] + to_index(k)].*member).x; };
            store_transposed<W>(load_transposed<W>(at).vector + impulse, P(0.0), at);
        };
        for (int k = 0; k <= rod.last; ++k) add(k, &FluidImpulse::on_node, time * force(rod, first, k));
        for (int k = 0; k < rod.n; ++k)
            add(k, &FluidImpulse::on_element, transpose_times(rod.slot[k].director, time * couple(rod, first, k)));
    }

private:
    using V = Vec3<P>;
    struct Lanes {
        std::size_t slot[W]; ///< first of each lane's rod; spare lanes repeat the last rod
    };

    Lanes first_of(const RodTile<W>& rod) const {
        Lanes first;
        for (int l = 0; l < W; ++l)
            first.slot[l] = loads_->first(rod.group->id(), rod.first + to_index(std::min(l, rod.lanes - 1)));
        return first;
    }
    V of_slot(const Lanes& first, int k, Vec3d FluidLoad::*member) const {
        return load_transposed<W>([&](int l) { return &(loads_->load[first.slot[l] + to_index(k)].*member).x; }).vector;
    }
    V force(const RodTile<W>& rod, const Lanes& first, int k) const {
        return of_slot(first, k, &FluidLoad::push) - scale(of_slot(first, k, &FluidLoad::drag), rod.slot[k].velocity);
    }
    V couple(const RodTile<W>& rod, const Lanes& first, int k) const {
        return rod.slot[k].director * of_slot(first, k, &FluidLoad::couple) -
               scale(of_slot(first, k, &FluidLoad::turn_drag), rod.slot[k].spin);
    }

    std::shared_ptr<FluidLoads> loads_;
};

} // namespace skein
