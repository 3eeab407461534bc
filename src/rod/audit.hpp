// Energy audit of one group: what loads, walls and damping do to each rod, kick by kick.        theory.md section 16
//   loads        h F.(v- + v+)/2 + h C.(w- + w+)/2 over all nodes and elements, F and C of external loads alone
//   walls        -h f.v - h c.w at held nodes and elements, f and c all loads there; the couple on the far side of a half cell
//   (12);
//                and the kinetic energy that the walls give what they hold
//   dissipated   the work of all loads on what is free, less what its kinetic energy has gained
// v-, w- before the kick and v+, w+ at the end of the step. Sums run along the rod and in time, lane by lane: the same bits for any
// ranks, threads and lanes.
// Four passes: before the ends are moved (where they move), after the elastic pass, before the kick, and last of all.
#pragma once

#include "rod/elastic.hpp"
#include "rod/rods.hpp"
#include "skein/core/aligned.hpp"

#include <memory>

namespace skein {

/// What the passes of one group's audit share, by tile number.
template <int W> struct AuditBook {
    using P = Pack<W>;
    struct Rates {
        Vec3<P> velocity, spin;
    };
    struct Page {
        AlignedVector<SlotLoad<W>> inner, all; ///< internal loads, all loads, [n + 1]
        AlignedVector<Rates> before;           ///< rates before the kick, [n + 1]
        P held_before{};                       ///< kinetic energy of held nodes and elements before their walls moved, J
        P wall_power{};                        ///< of the couples that half cells exert on walls, W
        P loads{}, walls{}, dissipated{};      ///< sums, J
    };
    AlignedVector<Page> pages;

    explicit AuditBook(const RodGroup& group) : group_(group) {}

    RodWorks works(std::size_t tile, int lane_) const {
        const Page& p = pages[tile];
        return {p.loads[lane_], p.walls[lane_], p.dissipated[lane_]};
    }
    void set_works(std::size_t tile, int lane_, const RodWorks& works) {
        Page& p = pages[tile];
        p.loads.set(lane_, works.loads);
        p.walls.set(lane_, works.walls);
        p.dissipated.set(lane_, works.dissipated);
    }
    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const Page& p : pages) sum += sizeof(Page) + p.inner.size() * (2 * sizeof(SlotLoad<W>) + sizeof(Rates));
        return sum;
    }

    P node_energy(const Vec3<P>& v, int i) const { return P(0.5 * group_.node_mass[static_cast<std::size_t>(i)]) * dot(v, v); }
    P element_energy(const Vec3<P>& w, int k) const {
        return P(0.5) * dot(w, scale(broadcast<W>(group_.element[static_cast<std::size_t>(k)].inertia), w));
    }
    /// Kinetic energy of what the walls hold.
    P held_energy(const RodTile<W>& rod) const {
        P sum(0.0);
        for (const int i : {0, rod.n})
            if (group_.holds_node(i)) sum = sum + node_energy(rod.slot[i].velocity, i);
        if (group_.holds_element(0)) sum = sum + element_energy(rod.slot[0].spin, 0);
        if (rod.n > 1 && group_.holds_element(rod.n - 1)) sum = sum + element_energy(rod.slot[rod.n - 1].spin, rod.n - 1);
        return sum;
    }

private:
    const RodGroup& group_;
};

/// Before moving ends take their new rates.
template <int W> class AuditEndsPass final : public TilePass<W> {
public:
    explicit AuditEndsPass(std::shared_ptr<AuditBook<W>> book) : book_(std::move(book)) {}
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override {
        book_->pages[rod.number].held_before = book_->held_energy(rod);
    }

private:
    std::shared_ptr<AuditBook<W>> book_;
};

/// After the elastic pass, when the load is the internal one.
template <class Law, int W> class AuditInnerPass final : public TilePass<W> {
public:
    AuditInnerPass(std::shared_ptr<AuditBook<W>> book, Ends ends, std::shared_ptr<const MovingEnds> moving)
        : book_(std::move(book)), elastic_(ends, moving), moving_(std::move(moving)) {}

    void bind(const RodTile<W>& rod) override {
        const auto slots = static_cast<std::size_t>(rod.n) + 1;
        typename AuditBook<W>::Page& page = book_->pages.emplace_back();
        page.inner.resize(slots);
        page.all.resize(slots);
        page.before.resize(slots);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        typename AuditBook<W>::Page& page = book_->pages[rod.number];
        std::copy(load, load + rod.n + 1, page.inner.begin());
        if (rod.group->closed()) page.inner[0].force += page.inner[static_cast<std::size_t>(rod.n)].force;
        if (!moving_) return;
        page.wall_power = dot(elastic_.couple_on_start_wall(rod, step), broadcast<W>(moving_->start(step).spin)) +
                          dot(elastic_.couple_on_end_wall(rod, step), broadcast<W>(moving_->end(step).spin));
    }

private:
    std::shared_ptr<AuditBook<W>> book_;
    ElasticPass<Law, W> elastic_;
    std::shared_ptr<const MovingEnds> moving_;
};

/// Before the kick, when the load is complete.
template <int W> class AuditLoadsPass final : public TilePass<W> {
public:
    explicit AuditLoadsPass(std::shared_ptr<AuditBook<W>> book) : book_(std::move(book)) {}
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        typename AuditBook<W>::Page& page = book_->pages[rod.number];
        std::copy(load, load + rod.n + 1, page.all.begin());
        for (int k = 0; k <= rod.n; ++k) page.before[static_cast<std::size_t>(k)] = {rod.slot[k].velocity, rod.slot[k].spin};
    }

private:
    std::shared_ptr<AuditBook<W>> book_;
};

/// At the end of the step.
template <int W> class AuditBalancePass final : public TilePass<W> {
public:
    AuditBalancePass(std::shared_ptr<AuditBook<W>> book, bool moving) : book_(std::move(book)), moving_(moving) {}

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        using P = Pack<W>;
        const AuditBook<W>& book = *book_;
        typename AuditBook<W>::Page& page = book_->pages[rod.number];
        P external(0.0), held(0.0), free(0.0),
            gained(0.0); // power of external loads, of all on the held and on the free; kinetic energy
        const auto tally = [&](const Vec3<P>& all, const Vec3<P>& inner, const Vec3<P>& before, const Vec3<P>& after, bool is_held,
                               const auto& energy) {
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
        const int nodes = rod.group->closed() ? rod.n : rod.n + 1;
        for (int i = 0; i < nodes; ++i) {
            const auto at = static_cast<std::size_t>(i);
            tally(page.all[at].force, page.inner[at].force, page.before[at].velocity, rod.slot[i].velocity,
                  rod.group->holds_node(i), [&](const Vec3<P>& v) { return book.node_energy(v, i); });
        }
        for (int k = 0; k < rod.n; ++k) {
            const auto at = static_cast<std::size_t>(k);
            tally(page.all[at].couple, page.inner[at].couple, page.before[at].spin, rod.slot[k].spin, rod.group->holds_element(k),
                  [&](const Vec3<P>& w) { return book.element_energy(w, k); });
        }
        const P h(step.kick);
        page.loads = fma(h, external, page.loads);
        page.dissipated = page.dissipated + (h * free - gained);
        if (moving_) page.walls = page.walls + (book.held_energy(rod) - page.held_before - h * (held + page.wall_power));
    }

private:
    std::shared_ptr<AuditBook<W>> book_;
    bool moving_;
};

} // namespace skein
