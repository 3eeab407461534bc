// Relaxation: the kick of rods that seek their state of rest. theory.md (64)-(68)
//   M u = (f, c),  v <- a v + h u,  w <- a w + h Q u_turn       M: the rod's own stiffness, a block per node and
//   element
// Inertia does not affect a state of rest and may be chosen freely. With masses, frequencies of stretch and of bending
// are a factor of 2 (n/1.9)^2 l/r and more apart: 1e5 for a rod with L/r = 5000 in 50 elements. With M they are all
// about 1/s, so that steps of 1 s settle them together. M is the sum of
//   strained  present stiffness of the rod (tangent_stiffness.hpp)
//   touched   dx^2 and t^2 at places that walls and other rods push, as stiff as contacts may be
//   all       dx^2 and t^2 as stiff as a tenth of the whole rod, so that free rods have a finite solution
// M is positive, and is solved block by block, one rod or ring a lane (block_band.hpp). A rod that moves against its
// forces, v.f + w.c < 0, loses its rates. A rod that would turn or stretch too far in a step is slowed down as a whole.
// If it may touch something, its farthest step is halved with every turn against its forces, and otherwise grows by
// 1.05 a step. Each rod decides alone, so that there are no sums over rods. Cost: 1300 flop per element, of rings 2100.
#pragma once

#include "relaxation/note_forces.hpp"
#include "relaxation/relaxation_estimate.hpp"
#include "relaxation/relaxing_rod.hpp"
#include "relaxation/relaxing_tile.hpp"
#include "relaxation/tangent_stiffness.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

/// All of it but the stiffness of a law, so that it is compiled once.
template <int W> class RelaxingPass : public TilePass<W>, public RelaxesTogether<W> {
public:
    static constexpr double momentum = 0.9; ///< a: modes down to (1 - sqrt a)^2 of M's settle alike
    /// a of rods that may touch something, which have softer modes
    static constexpr double touched_momentum = 0.98;
    /// least share of the farthest step for rods that bounce
    static constexpr double least_reach = 1e-4;

    RelaxingPass(const RodGroup& group, RelaxationContacts contacts, std::shared_ptr<RelaxationResidual> residual)
        : group_(group.id()), ends_(ends_of(group)), rod_(group, contacts), contacts_(std::move(contacts)),
          residual_(std::move(residual)), momentum_(contacts_.any() ? touched_momentum : momentum) {}

    void expect(std::size_t tiles) override {
        if (contacts_.any()) reach_.assign(tiles, P(1.0));
        if (residual_) residual_->expect(to_index(group_), tiles);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        static thread_local AlignedVector<Block> blocks;
        if (blocks.size() <= to_index(rod.n)) blocks.resize(to_index(rod.n) + 1);
        const int last = ends_.closed ? rod.n - 1 : rod.n;
        assemble(rod, last, load, blocks.data());
        const RingCoupling<W>* ring = nullptr;
        if (ends_.closed) ring = solve_as_ring(last, blocks.data());
        else solve_band(last, blocks.data());
        if (!contacts_.shared.empty()) return leave(rod, last, load, blocks.data(), ring);
        const Mask<W> against = power_of(rod, last, load) < P(0.0);
        const auto of = [&](int k) { return blocks[to_index(k)].u; };
        note_residual(rod, last, of);
        const P within = reach_of(rod, against);
        const P excess = move(rod, last, of, select(against, P(0.0), P(momentum_)), step.kick);
        if (const Mask<W> beyond = excess > within; any(beyond))
            slow_down(rod, last, select(beyond, within / excess, P(1.0)));
    }

    Pack<W> reach(const RelaxingTile<W>& tile, const Mask<W>& against) const override {
        return reach_of(tile.rod, against);
    }
    Pack<W> move(const RelaxingTile<W>& tile, const Pack<W>& kept, double h) const override {
        return move(
            tile.rod, tile.last, [&](int k) { return tile.correction[to_index(k)].u; }, kept * P(momentum_), h);
    }
    void slow_down(const RelaxingTile<W>& tile, const Pack<W>& share) const override {
        slow_down(tile.rod, tile.last, share);
    }
    void note_residual(const RelaxingTile<W>& tile) const override {
        note_residual(tile.rod, tile.last, [&](int k) { return tile.correction[to_index(k)].u; });
    }

    void append_memory(const RodTile<W>& rod, int lane, std::vector<double>& numbers) const override {
        if (contacts_.any()) numbers.push_back(reach_[rod.number][lane]);
    }
    std::size_t restore(const RodTile<W>& rod, int lane, std::span<const double> numbers) override {
        if (!contacts_.any()) return 0;
        reach_[rod.number].set(lane, numbers[0]);
        return 1;
    }

protected:
    using P = Pack<W>;
    using Block = BandBlock<W>;

private:
    /// Adds the present stiffness of the rod.
    virtual void add_stiffness(const RodTile<W>& rod, const Ends& ends, Block* block) const = 0;

    static const RingCoupling<W>* solve_as_ring(int last, Block* block) {
        static thread_local AlignedVector<RingCoupling<W>> couplings;
        if (couplings.size() < to_index(last)) couplings.resize(to_index(last));
        solve_ring(last, block, couplings.data());
        return couplings.data();
    }

    /// Leaves the solutions of a tile to what moves all rods that share nodes.
    void leave(const RodTile<W>& rod, int last, const SlotLoad<W>* load, const Block* block,
               const RingCoupling<W>* ring) const {
        RelaxingTile<W>& tile = relaxing_tiles<W>().emplace_back(RelaxingTile<W>{this, rod, last, {}, {}, {}, {}});
        const std::size_t blocks = to_index(last) + 1;
        tile.power = power_of(rod, last, load);
        tile.shared = contacts_.shared;
        tile.correction.resize(blocks);
        for (std::size_t k = 0; k < blocks; ++k) std::copy_n(block[k].u, Block::size, tile.correction[k].u);
        tile.by_unit.assign(3 * contacts_.shared.size() * blocks, BandVector<W>{});
        BandVector<W>* column = tile.by_unit.data();
        for (const int node : contacts_.shared)
            for (std::size_t direction = 0; direction < 3; ++direction, column += blocks) {
                for (std::size_t k = 0; k < blocks; ++k) std::fill_n(column[k].u, Block::size, P(0.0));
                column[node].u[direction] = P(nth(rod_[node].free, direction));
                solve_again(last, block, ring, column);
            }
    }

    void assemble(const RodTile<W>& rod, int last, const SlotLoad<W>* load, Block* block) const {
        for (int k = 0; k <= last; ++k) {
            block[k].clear();
            block[k].add(0, P(rod_[k].own_node));
            block[k].add(3, P(rod_[k].own_turn));
        }
        if (contacts_.any()) touch(rod.n, last, load, block);
        add_stiffness(rod, ends_, block);
        for (int k = 0; k <= last; ++k) load_of(rod, load, k, block[k]);
        for (int k = 0; k <= last; ++k)
            for (int i = 0; i < Block::size; ++i)
                if (nth(rod_[k].free, i) == 0)
                    block[k].hold(i, k > 0 ? &block[k - 1] : ends_.closed ? &block[last] : nullptr);
    }

    void touch(int n, int last, const SlotLoad<W>* load, Block* block) const {
        const auto& before = detail::untouched_forces<W>();
        for (int k = 0; k <= last; ++k) {
            const Vec3<P> added = load[k].force - nth(before, k);
            const Mask<W> touched = dot(added, added) > P(0.0);
            block[k].add(0, select(touched, P(contacts_.stiffness), P(0.0)));
            const P turning = select(touched, P(contacts_.turning), P(0.0));
            if (k > 0) block[k - 1].add(3, turning);
            else if (ends_.closed) block[last].add(3, turning);
            if (k < n) block[k].add(3, turning);
        }
    }

    static void load_of(const RodTile<W>& rod, const SlotLoad<W>* load, int k, Block& b) {
        const Vec3<P>& f = load[k].force;
        b.u[0] = f.x;
        b.u[1] = f.y;
        b.u[2] = f.z;
        const Vec3<P> c =
            k < rod.n ? transpose_times(rod.slot[k].director, load[k].couple) : Vec3<P>{P(0.0), P(0.0), P(0.0)};
        b.u[3] = c.x;
        b.u[4] = c.y;
        b.u[5] = c.z;
    }

    P power_of(const RodTile<W>& rod, int last, const SlotLoad<W>* load) const {
        P power(0.0);
        for (int k = 0; k <= last; ++k) {
            const auto& free = rod_[k].free;
            const Vec3<P> open{P(free[0]), P(free[1]), P(free[2])}; // forces on held directions do no work
            power += dot(scale(open, load[k].force), rod.slot[k].velocity);
            if (k < rod.n) power += dot(load[k].couple, rod.slot[k].spin);
        }
        return power;
    }

    /// `of(k)`: the six numbers of a block's correction.
    template <class Of> void note_residual(const RodTile<W>& rod, int last, const Of& of) const {
        P correction(0.0), zero(0.0);
        for (int k = 0; k <= last; ++k) {
            const P* u = of(k);
            const P move = max(abs(u[0]), max(abs(u[1]), abs(u[2]))), turn = max(abs(u[3]), max(abs(u[4]), abs(u[5])));
            correction = max(correction, max(P(1 / rod_.length()) * move, turn));
            zero = fma(u[0] + u[1] + u[2] + u[3] + u[4] + u[5], P(0.0), zero); // or NaN
        }
        double largest = 0;
        for (int l = 0; l < W; ++l) largest = std::max(largest, zero[l] == 0 ? correction[l] : HUGE_VAL);
        if (residual_) residual_->set(to_index(group_), rod.number, largest);
    }

    P reach_of(const RodTile<W>& rod, const Mask<W>& against) const {
        if (!contacts_.any()) return P(1.0);
        P& own = reach_[rod.number];
        own = select(against, max(P(least_reach), P(0.5) * own), min(P(1.0), P(1.05) * own));
        return own;
    }

    /// Returns the largest share of the farthest step.
    template <class Of> P move(const RodTile<W>& rod, int last, const Of& of, const P& kept, double h) const {
        const int n = rod.n;
        P excess(0.0);
        const auto stretches = [&](int k, const Vec3<P>& apart) { // true where element k is stretched too far
            excess = max(excess, P(h * rod.element[k].inv_rest_length / rod_[k].most_turn) * norm(apart));
        };
        Vec3<P> before{};
        for (int k = 0; k <= last; ++k) {
            Slot<W>& s = rod.slot[k];
            const P* u = of(k);
            s.velocity = fma(P(h), Vec3<P>{u[0], u[1], u[2]}, kept * s.velocity);
            if (k > 0) stretches(k - 1, s.velocity - before);
            before = s.velocity;
            excess = max(excess, P(h / contacts_.farthest_move) * norm(s.velocity));
            if (k == n) break;
            s.spin = fma(P(h), s.director * Vec3<P>{u[3], u[4], u[5]}, kept * s.spin);
            excess = max(excess, P(h / rod_[k].most_turn) * norm(s.spin));
        }
        if (ends_.closed) stretches(last, rod.slot[0].velocity - before);
        return excess;
    }

    void slow_down(const RodTile<W>& rod, int last, const P& share) const {
        for (int k = 0; k <= last; ++k) {
            rod.slot[k].velocity = share * rod.slot[k].velocity;
            if (k < rod.n) rod.slot[k].spin = share * rod.slot[k].spin;
        }
    }

    int group_;
    Ends ends_;
    RelaxingRod rod_;
    RelaxationContacts contacts_;
    std::shared_ptr<RelaxationResidual> residual_;
    double momentum_;
    mutable AlignedVector<P> reach_; ///< by tile: share of the farthest step that a rod may take now
};

template <class Law, int W> class RelaxPass final : public RelaxingPass<W> {
public:
    using RelaxingPass<W>::RelaxingPass;

private:
    void add_stiffness(const RodTile<W>& rod, const Ends& ends, BandBlock<W>* block) const override {
        TangentStiffness<Law, W>::add(rod, ends, block);
    }
};

} // namespace skein
