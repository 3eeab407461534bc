// Laplacian filter of the rates, in the middle of the kick: it removes what alternates from node to node. theory.md
// (41)-(41c)
//   F = M^-1 K:  nodes     (F v)_i = (m_{i-1} (v_i - v_{i-1}) + m_i (v_i - v_{i+1}))/(4 M_i),
//                          M of nodes, m = 4/M_k of (26)
//                elements  (F w)_k = J_k^-1 (C_{k-1} (w_k - w_{k-1}) + C_k (w_k - w_{k+1})),
//                          C_k = (2 J_k^-1 + 2 J_{k+1}^-1)^-1
//   v <- v - (s + s^2/2) y + (s^2/2) F^p y,   y = F^p v,   s = 1 - exp(-c h);  spins alike, all as lab vectors and
//                                                                               tensors
// Ends are natural: nothing is exchanged beyond them. In a ring indices run round. K is a sum of squares of
// differences, and M bounds it, so the eigenvalues of F are in [0, 1] for any masses: every application takes kinetic
// energy away. Neighbours exchange momentum: linear momentum and the angular momentum of the spins stay to round-off.
// Uniform motion and a rigid spin of the elements do not change. Nodes and elements held by an end move with its wall.
// Cost: 130 + 180 p flop per element.
#pragma once

#include "loads/damping.hpp"
#include "mechanics/audit.hpp"
#include "mechanics/drift.hpp"
#include "mechanics/hold.hpp"
#include "mechanics/moving_ends.hpp"
#include "rod/bearing.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace skein {

namespace detail {

/// A symmetric tensor.
template <class P> struct Symmetric {
    P xx, yy, zz, xy, xz, yz;

    SKEIN_INLINE friend Symmetric operator+(const Symmetric& a, const Symmetric& b) {
        return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
    }
    SKEIN_INLINE friend Vec3<P> operator*(const Symmetric& a, const Vec3<P>& v) {
        return {fma(a.xx, v.x, fma(a.xy, v.y, a.xz * v.z)), fma(a.xy, v.x, fma(a.yy, v.y, a.yz * v.z)),
                fma(a.xz, v.x, fma(a.yz, v.y, a.zz * v.z))};
    }
};

/// Inverse of a positive tensor.
template <class P> SKEIN_INLINE Symmetric<P> inverse(const Symmetric<P>& a) {
    const P x = fma(a.yy, a.zz, -(a.yz * a.yz)), y = fma(a.xz, a.yz, -(a.xy * a.zz)),
            z = fma(a.xy, a.yz, -(a.xz * a.yy));
    const P over = P(1.0) / fma(a.xx, x, fma(a.xy, y, a.xz * z));
    return {over * x, over * fma(a.xx, a.zz, -(a.xz * a.xz)), over * fma(a.xx, a.yy, -(a.xy * a.xy)), over * y,
            over * z, over * fma(a.xy, a.xz, -(a.xx * a.yz))};
}

/// Q^T diag(d) Q.
template <class P> SKEIN_INLINE Symmetric<P> in_lab(const Mat3<P>& q, const Vec3<P>& d) {
    const Vec3<P> a = d.x * q.d1, b = d.y * q.d2, c = d.z * q.d3;
    return {fma(a.x, q.d1.x, fma(b.x, q.d2.x, c.x * q.d3.x)), fma(a.y, q.d1.y, fma(b.y, q.d2.y, c.y * q.d3.y)),
            fma(a.z, q.d1.z, fma(b.z, q.d2.z, c.z * q.d3.z)), fma(a.x, q.d1.y, fma(b.x, q.d2.y, c.x * q.d3.y)),
            fma(a.x, q.d1.z, fma(b.x, q.d2.z, c.x * q.d3.z)), fma(a.y, q.d1.z, fma(b.y, q.d2.z, c.y * q.d3.z))};
}

} // namespace detail

template <int W> class LaplacianFilterPass final : public TilePass<W> {
public:
    /// order: p; rate: c, 1/s; h: length of the step, s. `audit`: books what filters of implicit steps take; null:
    /// none. `walls`: those that move and have not come to the begin of a step yet; null: they have.
    LaplacianFilterPass(const RodGroup& group, long order, double rate, double h, FilterTime time = FilterTime::in_kick,
                        std::shared_ptr<EnergyBudget<W>> audit = {}, std::shared_ptr<EndWalls<W>> walls = {})
        : order_(order), rate_(rate), time_(time), closed_(group.closed()), bearings_(bearings_of(group)),
          in_kick_(rate * h), audit_(std::move(audit)), walls_(std::move(walls)) {
        if (walls_) at_begin_.emplace(group);
        for (const ElementConstants& c : group.element) conductance_.push_back(0.25 * group.nodal_density * c.volume);
        const int n = group.elements();
        for (int i = 0; i <= n; ++i) {
            const double mass = nth(group.node_mass, i);
            inv_mass_.push_back(group.holds_node(i) || mass == 0 ? 0 : 1 / mass);
        }
        for (const int i : {0, n})
            if (group.slides(i)) sliding_.emplace_back(i, group.free_directions(i));
        for (int k = 0; k < n; ++k) held_.push_back(group.holds_element(k));
    }

    void bind(const RodTile<W>& rod) override {
        if (walls_) walls_->bind(rod);
    }
    void prepare(std::span<const Step> steps) override {
        if (!at_begin_) return;
        std::vector<Step> begins(steps.begin(), steps.end());
        for (Step& step : begins) step.time = step.begin;
        at_begin_->prepare(begins);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        if (time_ == FilterTime::in_kick) return filter(rod, in_kick_);
        if (time_ == FilterTime::before_step ? !step.first_stage : !step.last_stage) return;
        const double decays = (time_ == FilterTime::whole_step ? 1.0 : 0.5) * rate_ * step.dt;
        const auto times = static_cast<long>(std::max(1.0, std::ceil(decays / most_at_once)));
        const Shares shares(decays / static_cast<double>(times));
        const Slot<W> first = rod.slot[0], last_element = rod.slot[rod.n - 1], last = rod.slot[rod.last];
        if (walls_) move_held(rod, step);
        const P before = audit_ ? energy(rod) : P(0.0);
        for (long i = 0; i < times; ++i) filter(rod, shares);
        close_ring(rod);
        if (audit_) {
            auto& tile = audit_->tiles[rod.number];
            tile.dissipated += before - energy(rod);
        }
        if (walls_) put_back_held(rod, first, last_element, last);
    }

private:
    using P = Pack<W>;
    static constexpr double most_at_once = 0.1; ///< rate times time: beyond it the series of a filter is not its decay

    struct Shares {
        double once, twice; ///< s + s^2/2, s^2/2
        explicit Shares(double decays) {
            const double s = -std::expm1(-decays);
            once = s + 0.5 * s * s;
            twice = 0.5 * s * s;
        }
    };

    void filter(const RodTile<W>& rod, const Shares& shares) const {
        static thread_local AlignedVector<Row> rows;
        if (rows.size() <= to_index(rod.n)) rows.resize(to_index(rod.n) + 1);
        apply_hold<W>(*rod.group, rod.slot);
        filter_velocities(rod, rows.data(), shares);
        filter_spins(rod, rows.data(), shares);
        for (const Bearing& b : bearings_) {
            Slot<W>& s = rod.slot[b.element];
            s.spin = rate_on(b, s.director, s.spin, broadcast<W>(rod.element[b.element].inv_inertia));
        }
    }

    P energy(const RodTile<W>& rod) const {
        P sum(0.0);
        for (int i = 0; i < rod.group->nodes(); ++i) sum += audit_->node_energy(rod.slot[i].velocity, i);
        for (int k = 0; k < rod.n; ++k) sum += audit_->element_energy(rod.slot[k].spin, k);
        return sum;
    }

    /// Gives what moving ends hold their rates of the begin of the step.
    void move_held(const RodTile<W>& rod, const Step& step) const {
        using Walls = EndWalls<W>;
        const auto move = [&](typename Walls::End end, EndKind kind, int i, Slot<W>& element) {
            if (kind == EndKind::free) return;
            const Vec3<P> velocity = walls_->velocity(end, rod, *at_begin_, step);
            rod.slot[i].velocity = held_and_free(free_of(rod, i), velocity, rod.slot[i].velocity);
            if (kind == EndKind::clamped_frozen) element.spin = walls_->spin(end, rod, *at_begin_, step);
        };
        const RodSpec& spec = rod.group->spec();
        move(Walls::start, spec.start, 0, rod.slot[0]);
        move(Walls::end, spec.end, rod.n, rod.slot[rod.n - 1]);
    }
    /// The rates of before, of what ends hold.
    static void put_back_held(const RodTile<W>& rod, const Slot<W>& first, const Slot<W>& last_element,
                              const Slot<W>& last) {
        const auto put = [&](EndKind kind, int i, const Slot<W>& node, int k, const Slot<W>& element) {
            if (kind == EndKind::free) return;
            rod.slot[i].velocity = held_and_free(free_of(rod, i), node.velocity, rod.slot[i].velocity);
            if (kind == EndKind::clamped_frozen) rod.slot[k].spin = element.spin;
        };
        const RodSpec& spec = rod.group->spec();
        put(spec.start, 0, first, 0, first);
        put(spec.end, rod.n, last, rod.n - 1, last_element);
    }
    static Vec3d free_of(const RodTile<W>& rod, int i) {
        return rod.group->slides(i) ? rod.group->free_directions(i) : Vec3d{0, 0, 0};
    }

    struct Row {
        Vec3<P> rate;                     ///< rate to filter; lab
        detail::Symmetric<P> inv_inertia; ///< inverse inertia of the element; lab, 1/(kg m^2)
        detail::Symmetric<P> conductance; ///< C, between the element and the next; lab, kg m^2
    };

    void filter_velocities(const RodTile<W>& rod, Row* row, const Shares& shares) const {
        const int nodes = rod.group->nodes();
        for (int i = 0; i < nodes; ++i) row[i].rate = rod.slot[i].velocity;
        const auto exchanged = [&](int k, const Vec3<P>& difference) { return P(nth(conductance_, k)) * difference; };
        const auto per_mass = [&](int i, const Vec3<P>& f) { return P(nth(inv_mass_, i)) * f; };
        const auto apply = [&](double share) {
            for (long p = 0; p < order_; ++p) {
                differ(row, nodes, exchanged, per_mass);
                for (const auto& [i, free] : sliding_) row[i].rate = scale(broadcast<W>(free), row[i].rate);
            }
            for (int i = 0; i < nodes; ++i) rod.slot[i].velocity = fma(P(share), row[i].rate, rod.slot[i].velocity);
        };
        apply(-shares.once);
        apply(shares.twice);
    }

    void filter_spins(const RodTile<W>& rod, Row* row, const Shares& shares) const {
        const int n = rod.n, cells = rod.group->cells();
        for (int k = 0; k < n; ++k) {
            const Slot<W>& s = rod.slot[k];
            row[k].rate = transpose_times(s.director, s.spin);
            row[k].inv_inertia = detail::in_lab(matrix(s.director), broadcast<W>(rod.element[k].inv_inertia));
        }
        for (int k = 0; k < cells; ++k) {
            const detail::Symmetric<P> both = row[k].inv_inertia + row[k + 1 < n ? k + 1 : 0].inv_inertia;
            row[k].conductance = detail::inverse(both + both);
        }
        const auto exchanged = [&](int k, const Vec3<P>& difference) { return row[k].conductance * difference; };
        const auto per_inertia = [&](int k, const Vec3<P>& f) {
            return nth(held_, k) ? Vec3<P>{} : row[k].inv_inertia * f;
        };
        const auto apply = [&](double share) {
            for (long p = 0; p < order_; ++p) differ(row, n, exchanged, per_inertia);
            for (int k = 0; k < n; ++k) {
                Slot<W>& s = rod.slot[k];
                s.spin = fma(P(share), s.director * row[k].rate, s.spin);
            }
        };
        apply(-shares.once);
        apply(shares.twice);
    }

    /// rate <- F rate for `count` nodes or elements. exchanged(k, difference) is between k and the next; divided(k, f)
    /// divides by the inertia.
    template <class Exchanged, class Divided>
    SKEIN_INLINE void differ(Row* row, int count, const Exchanged& exchanged, const Divided& divided) const {
        const Vec3<P> first = row[0].rate;
        const int last = count - 1;
        Vec3<P> before{};
        if (closed_) before = exchanged(last, row[last].rate - first);
        for (int k = 0; k < last; ++k) {
            const Vec3<P> after = exchanged(k, row[k].rate - row[k + 1].rate);
            row[k].rate = divided(k, after - before);
            before = after;
        }
        const Vec3<P> after = closed_ ? exchanged(last, row[last].rate - first) : Vec3<P>{};
        row[last].rate = divided(last, after - before);
    }

    long order_;
    double rate_; ///< 1/s
    FilterTime time_;
    bool closed_;
    std::vector<Bearing> bearings_;
    Shares in_kick_;
    std::shared_ptr<EnergyBudget<W>> audit_; ///< null without an audit of implicit steps
    std::shared_ptr<EndWalls<W>> walls_;
    std::optional<MovingEnds> at_begin_;
    std::vector<double> conductance_;            ///< conductance between the nodes of an element, kg, [n]
    std::vector<double> inv_mass_;               ///< 1/kg, [n + 1]; 0 for held nodes
    std::vector<char> held_;                     ///< held elements, [n]
    std::vector<std::pair<int, Vec3d>> sliding_; ///< nodes that ends hold in some directions; 1 in the free ones
};

} // namespace skein
