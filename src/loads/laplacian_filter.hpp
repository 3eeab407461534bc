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

#include "mechanics/hold.hpp"
#include "rod/bearing.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <cmath>
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
    /// order: p; rate: c, 1/s; h: length of the step, s.
    LaplacianFilterPass(const RodGroup& group, long order, double rate, double h)
        : order_(order), closed_(group.closed()), bearings_(bearings_of(group)) {
        const double s = -std::expm1(-rate * h);
        once_ = s + 0.5 * s * s;
        twice_ = 0.5 * s * s;
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

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override {
        static thread_local AlignedVector<Row> rows;
        if (rows.size() <= to_index(rod.n)) rows.resize(to_index(rod.n) + 1);
        apply_hold<W>(*rod.group, rod.slot);
        filter_velocities(rod, rows.data());
        filter_spins(rod, rows.data());
        for (const Bearing& b : bearings_) {
            Slot<W>& s = rod.slot[b.element];
            s.spin = rate_on(b, s.director, s.spin, broadcast<W>(rod.element[b.element].inv_inertia));
        }
    }

private:
    using P = Pack<W>;
    struct Row {
        Vec3<P> rate;                     ///< rate to filter; lab
        detail::Symmetric<P> inv_inertia; ///< inverse inertia of the element; lab, 1/(kg m^2)
        detail::Symmetric<P> conductance; ///< C, between the element and the next; lab, kg m^2
    };

    void filter_velocities(const RodTile<W>& rod, Row* row) const {
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
        apply(-once_);
        apply(twice_);
    }

    void filter_spins(const RodTile<W>& rod, Row* row) const {
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
        apply(-once_);
        apply(twice_);
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
    bool closed_;
    std::vector<Bearing> bearings_;
    double once_, twice_;                        ///< s + s^2/2, s^2/2
    std::vector<double> conductance_;            ///< conductance between the nodes of an element, kg, [n]
    std::vector<double> inv_mass_;               ///< 1/kg, [n + 1]; 0 for held nodes
    std::vector<char> held_;                     ///< held elements, [n]
    std::vector<std::pair<int, Vec3d>> sliding_; ///< nodes that ends hold in some directions; 1 in the free ones
};

} // namespace skein
