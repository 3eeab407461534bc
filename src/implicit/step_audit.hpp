// Energy books of the stages of implicit steps, whose loads are known when corrections have ended. theory.md (130)
#pragma once

#include "implicit/row_terms.hpp"
#include "mechanics/audit.hpp"

#include <memory>
#include <utility>

namespace skein {

template <int W> class StepAudit {
public:
    using P = Pack<W>;
    using V = Vec3<P>;

    StepAudit(std::shared_ptr<EnergyBudget<W>> budget, bool moving) : budget_(std::move(budget)), moving_(moving) {}

    explicit operator bool() const { return budget_ != nullptr; }
    void bind(const RodTile<W>& rod) const {
        if (budget_ && budget_->tiles.size() <= rod.number) budget_->tiles.resize(rod.number + 1);
    }

    /// A stage begins: notes what its rates carry.
    void begin(const RodTile<W>& rod, const RowTerms<W>& terms) const {
        auto& tile = of(rod);
        tile.kinetic_before = free_energy(rod, terms);
        if (budget_->kicked.any()) tile.carried_before = carried_energy(rod);
    }
    /// Books the works of a time t, s, at the rates now. Loads: all but internal ones; internal ones; of the fluid,
    /// null without. `wall_power`: of walls that turn, W. `strained`: W/s, rates by their stiffness, of which steps
    /// take a share over `lost` [s^2].
    void book(const RodTile<W>& rod, const RowTerms<W>& terms, const SlotLoad<W>* outer, const SlotLoad<W>* inner,
              const SlotLoad<W>* medium, const P& t, const P& wall_power, const P& strained, const P& lost) const {
        P external(0.0), by_fluid(0.0), held(0.0), free(0.0), damped(0.0);
        for (int k = 0; k <= last(rod); ++k) {
            const ImplicitRod::Row& c = terms[k];
            const V& v = rod.slot[k].velocity;
            const V is_free{P(c.free[0]), P(c.free[1]), P(c.free[2])}, f = outer[k].force + inner[k].force;
            external += dot(outer[k].force, v);
            if (medium) by_fluid += dot(medium[k].force, v);
            const P all = dot(f, v), of_free = dot(f, scale(is_free, v));
            free += of_free;
            held += all - of_free;
            damped = fma(P(c.mass * c.node_rate), dot(v, scale(is_free, v)), damped);
            if (k >= rod.n) continue;
            const V &w = rod.slot[k].spin, couple = outer[k].couple + inner[k].couple;
            external += dot(outer[k].couple, w);
            if (medium) by_fluid += dot(medium[k].couple, w);
            if (!terms.turns(k)) {
                held += dot(couple, w);
                continue;
            }
            free += dot(couple, w);
            const V rate =
                fma(outer[k].dilatation + inner[k].dilatation, broadcast<W>(c.rate_by_stretch), broadcast<W>(c.rate));
            damped += dot(w, scale(rate, scale(broadcast<W>(c.inertia), w)));
        }
        auto& tile = of(rod);
        tile.loads = fma(t, external - by_fluid, tile.loads);
        tile.fluid = fma(t, by_fluid, tile.fluid);
        tile.dissipated = fma(t, damped, tile.dissipated);
        tile.numerical = fma(lost, strained, fma(t, free - damped, tile.numerical));
        if (moving_) tile.walls = tile.walls - t * (held + wall_power);
    }
    /// A stage has ended: books the change of what its rates carry.
    void end(const RodTile<W>& rod, const RowTerms<W>& terms) const {
        auto& tile = of(rod);
        tile.numerical -= free_energy(rod, terms) - tile.kinetic_before;
        const bool fluid = budget_->kicked.any();
        if (fluid) tile.fluid += carried_energy(rod) - tile.carried_before;
        if (!moving_) return;
        tile.walls += budget_->held_energy(rod) - tile.held_before;
        if (fluid) {
            const P held = budget_->held_energy_carried(rod) - tile.held_before_carried;
            tile.walls -= held;
            tile.fluid += held;
        }
    }

private:
    typename EnergyBudget<W>::TileBudget& of(const RodTile<W>& rod) const { return budget_->tiles[rod.number]; }
    static int last(const RodTile<W>& rod) { return rod.group->closed() ? rod.n - 1 : rod.last; }

    /// Kinetic energy of free directions, with the inertia that steps feel.
    static P free_energy(const RodTile<W>& rod, const RowTerms<W>& terms) {
        P sum(0.0);
        for (int k = 0; k <= last(rod); ++k) {
            const ImplicitRod::Row& c = terms[k];
            const V& v = rod.slot[k].velocity;
            sum = fma(P(0.5 * c.mass), dot(v, scale(V{P(c.free[0]), P(c.free[1]), P(c.free[2])}, v)), sum);
            if (k >= rod.n || !terms.turns(k)) continue;
            const V& w = rod.slot[k].spin;
            sum = fma(P(0.5), dot(w, scale(broadcast<W>(c.inertia), w)), sum);
        }
        return sum;
    }
    /// Kinetic energy of free nodes and elements that the fluid carries.
    P carried_energy(const RodTile<W>& rod) const {
        P sum(0.0);
        for (int k = 0; k <= last(rod); ++k) {
            if (!rod.group->holds_node(k)) {
                const Vec3d free = rod.group->slides(k) ? rod.group->free_directions(k) : Vec3d{1, 1, 1};
                sum += budget_->node_energy_carried(scale(broadcast<W>(free), rod.slot[k].velocity), k);
            }
            if (k < rod.n && !rod.group->holds_element(k)) sum += budget_->element_energy_carried(rod.slot[k].spin, k);
        }
        return sum;
    }

    std::shared_ptr<EnergyBudget<W>> budget_; ///< null without an audit
    bool moving_;
};

} // namespace skein
