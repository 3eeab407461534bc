// Terms of a row besides the rod's elasticity: inertia and damping over a time, loads on the right, held directions.
#pragma once

#include "implicit/elastic_rows.hpp"
#include "implicit/finite_turn.hpp"
#include "implicit/implicit_rod.hpp"

namespace skein {

template <int W> class RowTerms {
public:
    using P = Pack<W>;
    using V = Vec3<P>;

    RowTerms(const RodGroup& group, const DampingRates& rates, const KickedShares& shares)
        : rod_(group, rates, shares), closed_(group.closed()) {
        for (int k = 0; k < group.slots(); ++k) turns_in_lab_ |= rod_[k].turns_in_lab;
    }

    const ImplicitRod::Row& operator[](int k) const { return rod_[k]; }
    double length() const { return rod_.length(); }
    V free_node(int k) const { return {P(rod_[k].free[0]), P(rod_[k].free[1]), P(rod_[k].free[2])}; }
    bool turns(int k) const { return rod_[k].free[3] + rod_[k].free[4] + rod_[k].free[5] > 0; }

    /// Adds those of a node. `velocity`: now; `gained`: since the beginning of the time h.
    void add_node(int k, const P& h, const V& force, const V& velocity, const V& gained, BlockRow<W>& row) const {
        const ImplicitRod::Row& c = rod_[k];
        const P inv = P(1.0) / h, by_mass = P(c.mass) * inv;
        const V f = force - by_mass * fma(h * P(c.node_rate), velocity, gained);
        row.right[0] = f.x;
        row.right[1] = f.y;
        row.right[2] = f.z;
        const P node = by_mass * (inv + P(c.node_rate));
        for (int i = 0; i < 3; ++i) row.diagonal[i][i] += node;
    }
    /// Adds those of an element. `before`: moment of momentum at the beginning of the time h, in the frame now.
    ///   d(J w) = J (1 + [u]/2) t/h, u = h w;  d(R J w) = [R J w] t
    void add_element(int k, const P& h, const SlotLoad<W>& load, const V& spin, const V& before,
                     BlockRow<W>& row) const {
        const ImplicitRod::Row& c = rod_[k];
        const P inv = P(1.0) / h;
        const V j = broadcast<W>(c.inertia), momentum = scale(j, spin);
        const V rate = fma(load.dilatation, broadcast<W>(c.rate_by_stretch), broadcast<W>(c.rate));
        const V all = load.couple - inv * (momentum - before) - scale(rate, momentum);
        row.right[3] = all.x;
        row.right[4] = all.y;
        row.right[5] = all.z;
        const V by{fma(rate.x, inv, inv * inv), fma(rate.y, inv, inv * inv), fma(rate.z, inv, inv * inv)};
        const V stiff = scale(j, by);
        const P diagonal[3] = {stiff.x, stiff.y, stiff.z};
        const Three<P> half = detail::skew((P(0.5) * h) * spin), gyration = detail::skew(inv * before);
        for (int i = 0; i < 3; ++i)
            for (int m = 0; m < 3; ++m) {
                const P turned = fms(diagonal[i], half.a[i][m], gyration.a[i][m]);
                row.diagonal[3 + i][3 + m] += i == m ? turned + diagonal[i] : turned;
            }
    }

    /// Adds drags over the time h, of a node in the lab, of an element in its frame or (`in_lab`) the lab.
    static void add_drags(const RodTile<W>& rod, int k, const P& h, const V& node, const V& element, bool in_lab,
                          BlockRow<W>& row) {
        const P inv = P(1.0) / h, of_node[3] = {inv * node.x, inv * node.y, inv * node.z};
        for (int i = 0; i < 3; ++i) row.diagonal[i][i] += of_node[i];
        if (k >= rod.n) return;
        const V turning = inv * element;
        Mat3<P> all{{turning.x, P(0.0), P(0.0)}, {P(0.0), turning.y, P(0.0)}, {P(0.0), P(0.0), turning.z}};
        if (in_lab) {
            const Mat3<P> q = matrix(rod.slot[k].director);
            all = transpose_product(q, turning, q);
        }
        const V* const lines[3] = {&all.d1, &all.d2, &all.d3};
        for (int i = 0; i < 3; ++i) {
            row.diagonal[3 + i][3] += lines[i]->x;
            row.diagonal[3 + i][4] += lines[i]->y;
            row.diagonal[3 + i][5] += lines[i]->z;
        }
    }

    /// Holds what is not free. Turns of elements that are held about some lab axes become turns in the lab, t = Q u.
    void hold(const RodTile<W>& rod, int k, int last, BlockRow<W>& row) const {
        if (turns_in_lab_) turn_to_lab(rod, k, last, row);
        for (int i = 0; i < row_size; ++i)
            if (rod_[k].free[to_index(i)] == 0) row.hold(i);
    }
    /// The same of a block of row k without inertia, and of its columns where they are those of row k.
    void hold_rows(const RodTile<W>& rod, int k, RowBlock<W>& block) const {
        if (rod_[k].turns_in_lab) turn_rows(rod, k, block);
        for (int i = 0; i < row_size; ++i)
            if (rod_[k].free[to_index(i)] == 0)
                for (int j = 0; j < row_size; ++j) block[i][j] = P(0.0);
    }
    void hold_columns(const RodTile<W>& rod, int k, RowBlock<W>& block) const {
        if (rod_[k].turns_in_lab)
            for (auto& line : block) transpose_turn(rod.slot[k].director, line[3], line[4], line[5]);
    }
    /// Turns of a solution, in the elements' frames again.
    void turn_back(const RodTile<W>& rod, int last, RowVector<W>* solution) const {
        if (!turns_in_lab_) return;
        for (int k = 0; k <= last; ++k) {
            if (!rod_[k].turns_in_lab) continue;
            P* u = solution[k].u;
            const V turn = rod.slot[k].director * V{u[3], u[4], u[5]};
            u[3] = turn.x;
            u[4] = turn.y;
            u[5] = turn.z;
        }
    }

private:
    static void transpose_turn(const Quaternion<P>& q, P& x, P& y, P& z) {
        const V turned = transpose_times(q, V{x, y, z});
        x = turned.x;
        y = turned.y;
        z = turned.z;
    }
    static void turn_rows(const RodTile<W>& rod, int k, RowBlock<W>& block) {
        for (int j = 0; j < row_size; ++j) transpose_turn(rod.slot[k].director, block[3][j], block[4][j], block[5][j]);
    }
    void turn_to_lab(const RodTile<W>& rod, int k, int end, BlockRow<W>& row) const {
        const int before = k > 0 ? k - 1 : closed_ ? end : -1, after = k < end ? k + 1 : closed_ ? 0 : -1;
        const auto columns = [&](int of, RowBlock<W>& block) {
            if (of < 0 || !rod_[of].turns_in_lab) return;
            for (auto& line : block) transpose_turn(rod.slot[of].director, line[3], line[4], line[5]);
        };
        columns(before, row.before);
        columns(k, row.diagonal);
        columns(after, row.after);
        if (!rod_[k].turns_in_lab) return;
        for (RowBlock<W>* block : {&row.before, &row.diagonal, &row.after}) turn_rows(rod, k, *block);
        transpose_turn(rod.slot[k].director, row.right[3], row.right[4], row.right[5]);
    }

    ImplicitRod rod_;
    bool closed_, turns_in_lab_ = false;
};

/// Rates of row k of rows to `end` times their stiffness: (v, w)^T K (v, w).
template <int W> Pack<W> by_rates(const RodTile<W>& rod, int k, int end, const BlockRow<W>& row) {
    using P = Pack<W>;
    const auto rates = [&](int of, P(&u)[row_size]) {
        const Slot<W>& s = rod.slot[of];
        const bool turns = of < rod.n;
        const P all[row_size] = {s.velocity.x,
                                 s.velocity.y,
                                 s.velocity.z,
                                 turns ? s.spin.x : P(0.0),
                                 turns ? s.spin.y : P(0.0),
                                 turns ? s.spin.z : P(0.0)};
        std::copy_n(all, row_size, u);
    };
    const bool closed = rod.group->closed();
    const int prior = k > 0 ? k - 1 : closed ? end : -1, next = k < end ? k + 1 : closed ? 0 : -1;
    P own[row_size], other[row_size], force[row_size] = {};
    rates(k, own);
    const auto add = [&](const RowBlock<W>& block, const P(&u)[row_size]) {
        for (int i = 0; i < row_size; ++i)
            for (int j = 0; j < row_size; ++j) force[i] = fma(block[i][j], u[j], force[i]);
    };
    add(row.diagonal, own);
    if (prior >= 0) {
        rates(prior, other);
        add(row.before, other);
    }
    if (next >= 0) {
        rates(next, other);
        add(row.after, other);
    }
    P sum(0.0);
    for (int i = 0; i < row_size; ++i) sum = fma(own[i], force[i], sum);
    return sum;
}

} // namespace skein
