// Energy audit of one group: work of loads, walls and damping on each rod, kick by kick. theory.md section 16
//   loads        h F.(v- + v+)/2 + h C.(w- + w+)/2 over all nodes and elements, F and C of external loads alone;
//                contacts between bodies have an energy of their own and are left out
//   walls        -h f.v - h c.w at held nodes and elements, f and c all loads there; the couple on the far side of a
//                half cell (12); and the kinetic energy that walls give to held nodes and elements
//   dissipated   work of all loads on free nodes and elements, less the gain of their kinetic energy
//   fluid        h f.(v- + v+)/2 of its loads, and the gain of kinetic energy that the fluid carries for the rod: kicks
//                feel a share of the rod's inertia, and the fluid's reaction is that of the rest
// v-, w- hold before the kick and v+, w+ at the end of the step. Sums run along the rod and in time, lane by lane: the
// same bits for any ranks, threads and lanes. Passes run before moving ends are moved, after the elastic pass, before
// and after contacts, before the kick, and last of all.
#pragma once

#include "mechanics/elastic.hpp"
#include "mechanics/kicked_shares.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <memory>
#include <tuple>
#include <utility>
#include <vector>

namespace skein {

/// Energy budget of one group, by tile number, shared by the passes of its audit.
template <int W> struct EnergyBudget {
    using P = Pack<W>;
    struct Rates {
        Vec3<P> velocity, spin;
    };
    /// Constants of a slot of rods that lie along, whole: 1 where a lane has a node or an element that is free, or
    /// held.
    struct LaneRow {
        P free_node, held_node, free_element, held_element;
        P half_mass;     ///< kg
        Vec3<P> inertia; ///< kg m^2
    };
    struct TileBudget {
        AlignedVector<SlotLoad<W>> inner, all; ///< loads that have an energy, and all loads, [n + 1]
        AlignedVector<SlotLoad<W>> medium;     ///< loads of the fluid, [n + 1]; none without it
        bool noted = false;                    ///< true while `all` holds the loads before contacts
        AlignedVector<Rates> before;           ///< rates before the kick, [n + 1]
        AlignedVector<LaneRow> rows;           ///< of a tile along, [n + 1]
        P held_before{};         ///< kinetic energy of held nodes and elements before their walls moved, J
        P held_before_carried{}; ///< its part that the fluid carries, J
        P wall_power{};          ///< power of the couples of half cells on walls, W
        P loads{}, walls{}, dissipated{}, fluid{}; ///< sums, J
        P numerical{};                             ///< sum of what implicit steps take, J
        P kinetic_before{}, carried_before{};      ///< of an implicit stage as it begins, J
        std::tuple<P, P, P, P, P> kept[2];         ///< sums at other times
    };
    AlignedVector<TileBudget> tiles;

    /// `by_steps`: steps are implicit, and take energy by themselves.
    explicit EnergyBudget(const RodGroup& group, KickedShares kicked = {}, bool by_steps = false)
        : kicked(std::move(kicked)), by_steps(by_steps), group_(group) {}

    const KickedShares kicked;
    const bool by_steps;

    RodBudget budget(std::size_t tile, int l) const {
        const TileBudget& p = tiles[tile];
        return {p.loads[l], p.walls[l], p.dissipated[l], p.held_before[l], p.fluid[l], p.numerical[l]};
    }
    void set_budget(std::size_t tile, int l, const RodBudget& budget) {
        TileBudget& p = tiles[tile];
        p.loads.set(l, budget.loads);
        p.walls.set(l, budget.walls);
        p.dissipated.set(l, budget.dissipated);
        p.held_before.set(l, budget.held_before);
        p.fluid.set(l, budget.fluid);
        p.numerical.set(l, budget.numerical);
    }
    /// Keeps the sums of a tile in a place of its own, 0 or 1; returns to them.
    void keep(std::size_t tile, std::size_t place) {
        TileBudget& p = tiles[tile];
        p.kept[place] = {p.loads, p.walls, p.dissipated, p.fluid, p.numerical};
    }
    void go_back(std::size_t tile, std::size_t place) {
        TileBudget& p = tiles[tile];
        std::tie(p.loads, p.walls, p.dissipated, p.fluid, p.numerical) = p.kept[place];
    }
    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const TileBudget& p : tiles)
            sum += sizeof(TileBudget) + p.inner.size() * (2 * sizeof(SlotLoad<W>) + sizeof(Rates)) +
                   p.medium.size() * sizeof(SlotLoad<W>) + p.rows.size() * sizeof(LaneRow);
        return sum;
    }

    P node_energy(const Vec3<P>& v, int i) const { return P(0.5 * nth(group_.node_mass, i)) * dot(v, v); }
    P element_energy(const Vec3<P>& w, int k) const {
        return element_energy_of(broadcast<W>(nth(group_.element, k).inertia), w);
    }
    /// The parts of these that the fluid carries.
    P node_energy_carried(const Vec3<P>& v, int i) const { return P(1 - nth(kicked.of_nodes, i)) * node_energy(v, i); }
    P element_energy_carried(const Vec3<P>& w, int k) const {
        const Vec3d carried = Vec3d{1, 1, 1} - nth(kicked.of_elements, k);
        return element_energy_of(broadcast<W>(scale(carried, nth(group_.element, k).inertia)), w);
    }
    /// Constants of a tile's rods by lane, where they lie along as wholes.
    static AlignedVector<LaneRow> rows_of(const RodTile<W>& rod) {
        AlignedVector<LaneRow> rows(to_index(rod.n) + 1, LaneRow{});
        for (int i = 0; i <= rod.n; ++i)
            for (int l = 0; l < lanes_of<W>; ++l) {
                const int k = rod.strands->slot(l, i);
                if (k < 0) continue;
                const RodGroup& group = rod.group_of(l);
                LaneRow& row = nth(rows, i);
                (group.holds_node(k) ? row.held_node : row.free_node).set(l, 1);
                row.half_mass.set(l, 0.5 * nth(group.node_mass, k));
                if (k == group.elements()) continue;
                (group.holds_element(k) ? row.held_element : row.free_element).set(l, 1);
                set_lane(row.inertia, l, nth(group.element, k).inertia);
            }
        return rows;
    }
    /// Held directions of a node that slides: 1, and 0 in the free ones.
    Vec3<P> held_directions(int i) const { return broadcast<W>(Vec3d{1, 1, 1} - group_.free_directions(i)); }
    /// Kinetic energy of held nodes and elements, J.
    P held_energy(const RodTile<W>& rod) const {
        return held_sum(
            rod, [&](const Vec3<P>& v, int i) { return node_energy(v, i); },
            [&](const Vec3<P>& w, int k) { return element_energy(w, k); });
    }
    /// The part of it that the fluid carries.
    P held_energy_carried(const RodTile<W>& rod) const {
        return held_sum(
            rod, [&](const Vec3<P>& v, int i) { return node_energy_carried(v, i); },
            [&](const Vec3<P>& w, int k) { return element_energy_carried(w, k); });
    }

private:
    static P element_energy_of(const Vec3<P>& inertia, const Vec3<P>& w) { return P(0.5) * dot(w, scale(inertia, w)); }
    template <class OfNode, class OfElement>
    P held_sum(const RodTile<W>& rod, const OfNode& of_node, const OfElement& of_element) const {
        P sum(0.0);
        for (const int i : {0, rod.n})
            if (group_.holds_node(i)) sum = sum + of_node(rod.slot[i].velocity, i);
            else if (group_.slides(i)) sum = sum + of_node(scale(held_directions(i), rod.slot[i].velocity), i);
        if (group_.holds_element(0)) sum = sum + of_element(rod.slot[0].spin, 0);
        if (rod.n > 1 && group_.holds_element(rod.n - 1)) sum = sum + of_element(rod.slot[rod.n - 1].spin, rod.n - 1);
        return sum;
    }

    const RodGroup& group_;
};

/// Base of the passes of an audit.
template <int W> class AuditPass : public TilePass<W> {
public:
    explicit AuditPass(std::shared_ptr<EnergyBudget<W>> budget) : budget_(std::move(budget)) {}
    void expect(std::size_t tiles) override { budget_->tiles.resize(tiles); }

protected:
    const EnergyBudget<W>& budget() const { return *budget_; }
    typename EnergyBudget<W>::TileBudget& of(const RodTile<W>& rod) const { return budget_->tiles[rod.number]; }

    /// Makes room for a tile, once for all passes of the budget.
    void make_room(const RodTile<W>& rod) {
        const std::size_t slots = to_index(rod.last) + 1;
        if (budget_->tiles.size() <= rod.number) budget_->tiles.resize(rod.number + 1); // a pass without expect()
        auto& tile = of(rod);
        if (!tile.inner.empty()) return;
        if (rod.strands) tile.rows = budget_->rows_of(rod);
        tile.inner.resize(slots);
        tile.all.resize(slots);
        tile.before.resize(slots);
        if (budget_->kicked.any()) tile.medium.resize(slots);
    }
    /// Notes internal loads; in a second call of a step it adds those of contacts, and returns true.
    bool note_inner(const RodTile<W>& rod, const SlotLoad<W>* load) const {
        auto& tile = of(rod);
        if (std::exchange(tile.noted, false)) {
            for (int k = 0; k <= rod.last; ++k) {
                const std::size_t at = to_index(k);
                const Vec3<Pack<W>> force = load[k].force - tile.all[at].force;
                tile.inner[at].force += force;
                tile.inner[at].couple += load[k].couple - tile.all[at].couple;
                if (k == rod.n && is_closed(rod)) tile.inner[0].force += force;
            }
            return true;
        }
        std::copy(load, load + rod.last + 1, tile.inner.begin());
        if (is_closed(rod)) tile.inner[0].force += nth(tile.inner, rod.n).force;
        return false;
    }
    static bool is_closed(const RodTile<W>& rod) { return !rod.strands && rod.group->closed(); }

    std::shared_ptr<EnergyBudget<W>> budget_;
};

/// Pass before moving ends take their new rates.
template <int W> class AuditEndsPass final : public AuditPass<W> {
public:
    using AuditPass<W>::AuditPass;
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override {
        auto& tile = this->of(rod);
        tile.held_before = this->budget().held_energy(rod);
        if (this->budget().kicked.any()) tile.held_before_carried = this->budget().held_energy_carried(rod);
    }
};

/// Power of the couples on walls that turn, W.
template <class Law, int W> Pack<W> power_of_walls(const ElasticPass<Law, W>& elastic, const EndWalls<W>& walls,
                                                   const RodTile<W>& rod, const Step& step) {
    const Vec3<Pack<W>> start = walls.spin(EndWalls<W>::start, rod, step),
                        end = walls.spin(EndWalls<W>::end, rod, step);
    return dot(elastic.couple_on_start_wall(rod, step), start) + dot(elastic.couple_on_end_wall(rod, step), end);
}

/// Pass after the elastic pass, with internal loads, and again after contacts, whose loads it adds.
template <class Law, int W> class AuditInnerPass final : public AuditPass<W> {
public:
    AuditInnerPass(std::shared_ptr<EnergyBudget<W>> budget, Ends ends, std::shared_ptr<EndWalls<W>> walls)
        : AuditPass<W>(std::move(budget)), elastic_(ends, walls), walls_(std::move(walls)) {}

    void bind(const RodTile<W>& rod) override {
        elastic_.bind(rod);
        walls_->bind(rod);
        this->make_room(rod);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        if (this->note_inner(rod, load)) return;
        if (walls_->moving()) this->of(rod).wall_power = power_of_walls(elastic_, *walls_, rod, step);
    }

private:
    ElasticPass<Law, W> elastic_;
    std::shared_ptr<EndWalls<W>> walls_;
};

/// The same of bodies, which have no internal loads.
template <int W> class AuditUnstrainedPass final : public AuditPass<W> {
public:
    using AuditPass<W>::AuditPass;
    void bind(const RodTile<W>& rod) override { this->make_room(rod); }
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override { this->note_inner(rod, load); }
};

/// Pass before the kick, with all loads, and before contacts.
template <int W> class AuditLoadsPass final : public AuditPass<W> {
public:
    using AuditPass<W>::AuditPass;
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        auto& tile = this->of(rod);
        std::copy(load, load + rod.last + 1, tile.all.begin());
        tile.noted = true;
        for (int k = 0; k <= rod.last; ++k) nth(tile.before, k) = {rod.slot[k].velocity, rod.slot[k].spin};
    }
};

/// Pass after the fluid, which has divided all loads by the shares that kicks feel. Its own loads count as those that
/// are booked by themselves.
template <int W> class AuditMediumPass final : public AuditPass<W> {
public:
    using AuditPass<W>::AuditPass;
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        using P = Pack<W>;
        auto& tile = this->of(rod);
        const KickedShares& kicked = this->budget().kicked;
        for (int k = 0; k <= rod.last; ++k) {
            const std::size_t at = to_index(k);
            SlotLoad<W>& medium = tile.medium[at];
            medium.force = P(kicked.of_nodes[at]) * load[k].force - tile.all[at].force;
            tile.all[at].force += medium.force;
            tile.inner[at].force += medium.force;
            if (k == rod.n) break;
            medium.couple = scale(broadcast<W>(kicked.of_elements[at]), load[k].couple) - tile.all[at].couple;
            tile.all[at].couple += medium.couple;
            tile.inner[at].couple += medium.couple;
        }
    }
};

/// Pass at the end of the step: work of the fluid. The gain of energy that it bears is no loss of the rod, nor a gift
/// of its walls.
template <int W> class AuditMediumWorkPass final : public AuditPass<W> {
public:
    AuditMediumWorkPass(std::shared_ptr<EnergyBudget<W>> budget, bool moving)
        : AuditPass<W>(std::move(budget)), moving_(moving) {}

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        using P = Pack<W>;
        const EnergyBudget<W>& budget = this->budget();
        auto& tile = this->of(rod);
        P power(0.0), carried(0.0);
        for (int i = 0; i < rod.group->nodes(); ++i) {
            const Vec3<P>&before = tile.before[to_index(i)].velocity, &after = rod.slot[i].velocity;
            power = power + dot(tile.medium[to_index(i)].force, P(0.5) * (before + after));
            if (rod.group->holds_node(i)) continue;
            const Vec3d free = rod.group->slides(i) ? rod.group->free_directions(i) : Vec3d{1, 1, 1};
            const auto energy = [&](const Vec3<P>& v) {
                return budget.node_energy_carried(scale(broadcast<W>(free), v), i);
            };
            carried = carried + (energy(after) - energy(before));
        }
        for (int k = 0; k < rod.n; ++k) {
            const Vec3<P>&before = tile.before[to_index(k)].spin, &after = rod.slot[k].spin;
            power = power + dot(tile.medium[to_index(k)].couple, P(0.5) * (before + after));
            if (rod.group->holds_element(k)) continue;
            carried = carried + (budget.element_energy_carried(after, k) - budget.element_energy_carried(before, k));
        }
        const P held = moving_ ? budget.held_energy_carried(rod) - tile.held_before_carried : P(0.0);
        tile.fluid = fma(P(step.kick), power, tile.fluid) + carried + held;
        tile.dissipated = tile.dissipated + carried;
        tile.walls = tile.walls - held;
    }

private:
    bool moving_;
};

/// Pass at the end of the step.
template <int W> class AuditBalancePass final : public AuditPass<W> {
public:
    AuditBalancePass(std::shared_ptr<EnergyBudget<W>> budget, bool moving)
        : AuditPass<W>(std::move(budget)), moving_(moving) {}

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        using P = Pack<W>;
        const EnergyBudget<W>& budget = this->budget();
        auto& tile = this->of(rod);
        tile.noted = false;
        if (rod.strands) return balance_along(tile, rod, step);
        // Power of external loads, and of all loads on held and on free directions; gain of kinetic energy.
        P external(0.0), held(0.0), free(0.0), gained(0.0);
        const auto tally = [&](const Vec3<P>& all, const Vec3<P>& inner, const Vec3<P>& before, const Vec3<P>& after,
                               bool is_held, const auto& energy) {
            const Vec3<P> mean = P(0.5) * (before + after);
            const P power = dot(all, mean);
            external = external + dot(all - inner, mean);
            if (is_held) {
                held = held + power;
            } else {
                free = free + power;
                gained = gained + (energy(after) - energy(before));
            }
        };
        for (int i = 0; i < rod.group->nodes(); ++i) {
            const std::size_t at = to_index(i);
            if (rod.group->slides(i)) { // the wall takes a part of the force
                const Vec3<P> by_wall = budget.held_directions(i), &all = tile.all[at].force,
                              &inner = tile.inner[at].force;
                const auto share = [&](const Vec3<P>& of, bool is_held, const Vec3<P>& before, const Vec3<P>& after) {
                    tally(scale(of, all), scale(of, inner), scale(of, before), scale(of, after), is_held,
                          [&](const Vec3<P>& v) { return budget.node_energy(v, i); });
                };
                share(by_wall, true, tile.before[at].velocity, rod.slot[i].velocity);
                share(broadcast<W>(Vec3d{1, 1, 1}) - by_wall, false, tile.before[at].velocity, rod.slot[i].velocity);
                continue;
            }
            tally(tile.all[at].force, tile.inner[at].force, tile.before[at].velocity, rod.slot[i].velocity,
                  rod.group->holds_node(i), [&](const Vec3<P>& v) { return budget.node_energy(v, i); });
        }
        for (int k = 0; k < rod.n; ++k) {
            const std::size_t at = to_index(k);
            tally(tile.all[at].couple, tile.inner[at].couple, tile.before[at].spin, rod.slot[k].spin,
                  rod.group->holds_element(k), [&](const Vec3<P>& w) { return budget.element_energy(w, k); });
        }
        const P h(step.kick);
        tile.loads = fma(h, external, tile.loads);
        tile.dissipated = tile.dissipated + (h * free - gained);
        if (moving_)
            tile.walls = tile.walls + (budget.held_energy(rod) - tile.held_before - h * (held + tile.wall_power));
    }

private:
    /// The same of rods that lie along, each in a lane; their ends do not move.
    static void balance_along(typename EnergyBudget<W>::TileBudget& tile, const RodTile<W>& rod, const Step& step) {
        using P = Pack<W>;
        P external(0.0), free(0.0), gained(0.0);
        const auto tally = [&](const Vec3<P>& all, const Vec3<P>& inner, const Vec3<P>& before, const Vec3<P>& after,
                               const P& is_free, const P& is_held, const auto& energy) {
            const Vec3<P> mean = P(0.5) * (before + after);
            const Mask<W> moves = is_free > P(0.5), there = is_free + is_held > P(0.5);
            external = select(there, external + dot(all - inner, mean), external);
            free = select(moves, free + dot(all, mean), free);
            gained = select(moves, gained + (energy(after) - energy(before)), gained);
        };
        for (int i = 0; i <= rod.n; ++i) {
            const std::size_t at = to_index(i);
            const auto& row = tile.rows[at];
            tally(tile.all[at].force, tile.inner[at].force, tile.before[at].velocity, rod.slot[i].velocity,
                  row.free_node, row.held_node, [&](const Vec3<P>& v) { return row.half_mass * dot(v, v); });
        }
        for (int k = 0; k < rod.n; ++k) {
            const std::size_t at = to_index(k);
            const auto& row = tile.rows[at];
            tally(tile.all[at].couple, tile.inner[at].couple, tile.before[at].spin, rod.slot[k].spin, row.free_element,
                  row.held_element, [&](const Vec3<P>& w) { return P(0.5) * dot(w, scale(row.inertia, w)); });
        }
        const P h(step.kick);
        tile.loads = fma(h, external, tile.loads);
        tile.dissipated = tile.dissipated + (h * free - gained);
    }

    bool moving_;
};

} // namespace skein
