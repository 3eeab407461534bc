// Relaxation: the kick of rods whose rest is wanted and not their motion.                              theory.md (64)-(68)
//   M u = (f, c),  v <- a v + h u,  w <- a w + h Q u_turn       M: the rod's own stiffness, in blocks of a node and its element
// The inertia of a rod at rest is free. Masses of nodes leave frequencies of stretch and of bending a factor of 2 (n/1.9)^2 l/r and
// more apart, 1e5 of a rod with L/r = 5000 in 50 elements; with M they are all about 1/s, so that steps of 1 s settle them
// together.
//   element   y = dx[k+1] - dx[k] - t x X,    y.C y,  C = Q^T S Q/l, S tangent;  y = change of X = x[k+1] - x[k] but for the turn
//             (dx[k+1] - dx[k])^2 N/l         of tension N > 0: what strings have across
//   cell      (t[k+1] - t[k]).B (t[k+1] - t[k])/(D E^3), B in the lab, the mean of both elements' frames;  t^2 q D/4 of moments
//   wall      t.B t 2/(l E^3)
//   touched   dx^2 and t^2 of what walls and other rods push, as stiff as contacts may be
//   all       dx^2 and t^2 as stiff as a hundredth of the whole rod, so that free rods have a finite answer
// M is positive, so it is split into G G^T block by block, as a band; both sweeps go along the rod, one rod a lane. A rod that
// moves against its forces, v.f + w.c < 0, forgets its rates; one that would turn or stretch too far in a step is slowed down as a
// whole; where it may touch something, how far it may go is halved with every turn against its forces, and grows by 1.05 a step
// otherwise. Each rod decides alone, so that there are no sums over rods. Cost: 1300 flop per element.
#pragma once

#include "rod/elastic.hpp"
#include "rod/relaxation_outlook.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace skein {

namespace detail {
/// Forces of a tile before walls and contacts add theirs; of this thread.
template <int W> AlignedVector<Vec3<Pack<W>>>& untouched_forces() {
    static thread_local AlignedVector<Vec3<Pack<W>>> forces;
    return forces;
}
} // namespace detail

/// Before walls and contacts: what they add tells the relaxation where rods are touched.
template <int W> class NoteForcesPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        auto& forces = detail::untouched_forces<W>();
        if (forces.size() <= static_cast<std::size_t>(rod.n)) forces.resize(static_cast<std::size_t>(rod.n) + 1);
        for (int k = 0; k <= rod.n; ++k) forces[static_cast<std::size_t>(k)] = load[k].force;
    }
    bool adds_loads() const override { return false; }
};

template <class Law, int W> class RelaxPass final : public TilePass<W> {
public:
    static constexpr double momentum = 0.9;          ///< a: modes down to (1 - sqrt a)^2 of M's settle alike
    static constexpr double touched_momentum = 0.98; ///< the same of rods that may touch something: these have softer modes
    static constexpr double least_reach = 1e-4;      ///< of the farthest step, down to which rods that bounce are slowed down
    static constexpr double farthest_turn = 0.1;     ///< rad in a step
    static constexpr double farthest_share = 2; ///< of the radius, across an element: what it stretches by then is of order (r/l)^2
    static constexpr double own_share = 0.1;    ///< of EI/L^3 and of EI/L, spread over the rod

    RelaxPass(const RodGroup& group, RelaxationContacts contacts, std::shared_ptr<RelaxationResidual> residual)
        : group_(group.id()), ends_(ends_of(group)), contacts_(contacts), residual_(std::move(residual)),
          momentum_(contacts.any() ? touched_momentum : momentum) {
        const int n = group.elements();
        for (const ElementConstants& e : group.element) length_ += e.rest_length;
        double bending = 0;
        for (const ElementConstants& e : group.element) bending += 0.5 * (e.bending.x + e.bending.y) * e.rest_length / length_;
        const double per_length = own_share * bending / (length_ * length_);
        for (int k = 0; k <= n; ++k) {
            Row row{};
            row.free = {1, 1, 1, 1, 1, 1};
            if (group.holds_node(k)) row.free[0] = row.free[1] = row.free[2] = 0;
            if (group.slides(k)) {
                const Vec3d free = group.free_directions(k);
                row.free[0] = free.x, row.free[1] = free.y, row.free[2] = free.z;
            }
            if (k == n || group.holds_element(k)) row.free[3] = row.free[4] = row.free[5] = 0;
            row.own_node = per_length * group.node_length[static_cast<std::size_t>(k)] / length_;
            if (k < n) {
                const ElementConstants& e = group.element[static_cast<std::size_t>(k)];
                row.own_turn = per_length * e.rest_length;
                row.most_turn = std::min(farthest_turn, farthest_share * e.radius * e.inv_rest_length);
            }
            row_.push_back(row);
        }
        const Hold& hold = group.spec().hold;
        const auto hold_axes = [](double* free, const std::string& axes) {
            for (const char axis : axes) free[axis - 'x'] = 0;
        };
        for (const long i : hold.nodes) hold_axes(&at(i < 0 ? n + 1 + i : i).free[0], hold.directions);
        for (const long k : hold.elements) hold_axes(&at(k < 0 ? n + k : k).free[3], hold.axes);
    }

    void expect(std::size_t tiles) override {
        if (contacts_.any()) reach_.assign(tiles, P(1.0));
        if (residual_) residual_->expect(static_cast<std::size_t>(group_), tiles);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        static thread_local AlignedVector<Block> blocks;
        if (blocks.size() <= static_cast<std::size_t>(rod.n)) blocks.resize(static_cast<std::size_t>(rod.n) + 1);
        assemble(rod, load, blocks.data());
        solve(rod.n, blocks.data());
        kick(rod, load, blocks.data(), step.kick);
    }

    std::span<Pack<W>> memory(const RodTile<W>& rod) override {
        if (!contacts_.any()) return {};
        return {&reach_[rod.number], 1};
    }

private:
    using P = Pack<W>;
    struct Row {
        std::array<double, 6> free; ///< 0: held; of the node and of its element, along lab axes
        double own_node, own_turn;  ///< N/m, N m
        double most_turn;           ///< rad in a step
    };
    /// One node and its element: the lower triangle of a block, then of its factor; the coupling to the next one, then what the
    /// factor makes of it; forces, then corrections. Lab.
    struct Block {
        P diagonal[6][6], next[6][6], u[6];
    };
    Row& at(long k) { return row_[static_cast<std::size_t>(k)]; }
    const Row& at(long k) const { return row_[static_cast<std::size_t>(k)]; }

    struct Tensor {
        P a[3][3];
    };
    /// Q^T diag(d) Q.
    static Tensor in_lab(const Mat3<P>& q, const Vec3<P>& d) {
        const P rows[3][3] = {{q.d1.x, q.d1.y, q.d1.z}, {q.d2.x, q.d2.y, q.d2.z}, {q.d3.x, q.d3.y, q.d3.z}};
        Tensor t;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                t.a[i][j] = fma(d.x * rows[0][i], rows[0][j], fma(d.y * rows[1][i], rows[1][j], d.z * rows[2][i] * rows[2][j]));
        return t;
    }
    /// Turns that stretch nothing else: onto the diagonal.
    static void add_turning(Block& b, const Tensor& t) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) b.diagonal[3 + i][3 + j] += t.a[i][j];
    }
    static void add(Block& b, int first, const P& stiffness) {
        for (int i = first; i < first + 3; ++i) b.diagonal[i][i] += stiffness;
    }

    void assemble(const RodTile<W>& rod, const SlotLoad<W>* load, Block* block) const {
        const int n = rod.n;
        for (int k = 0; k <= n; ++k) {
            Block& b = block[k];
            for (int i = 0; i < 6; ++i)
                for (int j = 0; j < 6; ++j) b.diagonal[i][j] = b.next[i][j] = P(0.0);
            add(b, 0, P(at(k).own_node));
            add(b, 3, P(at(k).own_turn));
        }
        if (contacts_.any()) {
            const auto& before = detail::untouched_forces<W>();
            for (int k = 0; k <= n; ++k) {
                const Vec3<P> added = load[k].force - before[static_cast<std::size_t>(k)];
                const Mask<W> touched = dot(added, added) > P(0.0);
                add(block[k], 0, select(touched, P(contacts_.stiffness), P(0.0)));
                for (int e = std::max(0, k - 1); e <= std::min(k, n - 1); ++e)
                    add(block[e], 3, select(touched, P(contacts_.turning), P(0.0)));
            }
        }
        Vec3<P> nu = element_strain<Across<W>>(rod, 0);
        for (int k = 0; k < n; ++k) {
            const ElementConstants& c = rod.element[k];
            const Mat3<P> q = matrix(rod.slot[k].director);
            stretch(rod, c, q, nu, k, block);
            // Half cells at walls bend as the cells do.
            const auto wall = [&] {
                const auto factor = Law::bending_factor(P(1.0) / nu.z, c.rest_stretch) * P(2 * c.inv_rest_length);
                add_turning(block[k], in_lab(q, factor * broadcast<W>(c.bending)));
            };
            if (k == 0 && ends_.start_wall) wall();
            if (k == n - 1 && ends_.end_wall) wall();
            if (k + 1 == n) break;
            const Vec3<P> nu_next = element_strain<Across<W>>(rod, k + 1);
            bend(rod, q, nu.z, nu_next.z, k, block);
            nu = nu_next;
        }
        for (int k = 0; k <= n; ++k) load_of(rod, load, k, block[k]);
        for (int k = 0; k <= n; ++k) hold(k, n, block);
    }

    /// Stretch and shear of element k, and tension.
    void stretch(const RodTile<W>& rod, const ElementConstants& c, const Mat3<P>& q, const Vec3<P>& nu, int k, Block* block) const {
        const P inv_length(c.inv_rest_length);
        const Vec3<P> stiffness{P(c.stiffness.x), P(c.stiffness.y), Law::stretch_stiffness(c, nu.z)};
        const Tensor s = in_lab(q, inv_length * stiffness);
        const P pull = max(Law::stress(c, nu).z, P(0.0)) * inv_length;
        const Vec3<P> x = rod.slot[k + 1].position - rod.slot[k].position;
        // y = dx' - dx + X t, X = [x]
        const P zero(0.0), X[3][3] = {{zero, -x.z, x.y}, {x.z, zero, -x.x}, {-x.y, x.x, zero}};
        P sx[3][3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) sx[i][j] = fma(s.a[i][0], X[0][j], fma(s.a[i][1], X[1][j], s.a[i][2] * X[2][j]));
        Block &b = block[k], &after = block[k + 1];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const P along = i == j ? s.a[i][j] + pull : s.a[i][j];
                b.diagonal[i][j] += along;
                after.diagonal[i][j] += along;
                b.next[i][j] -= along;
                b.diagonal[3 + j][i] -= sx[i][j];
                b.next[i][3 + j] += sx[i][j];
                b.diagonal[3 + i][3 + j] += fma(X[0][i], sx[0][j], fma(X[1][i], sx[1][j], X[2][i] * sx[2][j]));
            }
    }

    /// Bending and twist between elements k and k + 1.
    void bend(const RodTile<W>& rod, const Mat3<P>& q, P e, P e_next, int k, Block* block) const {
        const VoronoiConstants& v = rod.voronoi[k];
        const Mat3<P> q_next = matrix(rod.slot[k + 1].director);
        const auto factor =
            Law::bending_factor(P(1.0) / fma(P(v.share_before), e, P(v.share_after) * e_next), rod.element[k].rest_stretch);
        const Vec3<P> half = (factor * P(0.5 * v.inv_length)) * broadcast<W>(v.stiffness);
        const Tensor one = in_lab(q, half), other = in_lab(q_next, half);
        Tensor s;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) s.a[i][j] = one.a[i][j] + other.a[i][j];
        Block &b = block[k], &after = block[k + 1];
        add_turning(b, s);
        add_turning(after, s);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) b.next[3 + i][3 + j] -= s.a[i][j];
        const Vec3<P> phi = relative_rotation(rod.slot[k + 1].director, rod.slot[k].director);
        const Vec3<P> strain = fma(P(v.inv_length), phi, -broadcast<W>(v.rest_curvature));
        const P moments = P(0.25 / v.inv_length) * dot(strain, factor * scale(broadcast<W>(v.stiffness), strain));
        add(b, 3, moments);
        add(after, 3, moments);
    }

    static void load_of(const RodTile<W>& rod, const SlotLoad<W>* load, int k, Block& b) {
        const Vec3<P>& f = load[k].force;
        b.u[0] = f.x, b.u[1] = f.y, b.u[2] = f.z;
        const Vec3<P> c = k < rod.n ? transpose_times(rod.slot[k].director, load[k].couple) : Vec3<P>{P(0.0), P(0.0), P(0.0)};
        b.u[3] = c.x, b.u[4] = c.y, b.u[5] = c.z;
    }

    /// What is held stays, and moves nothing.
    void hold(int k, int n, Block* block) const {
        const auto& free = at(k).free;
        for (int i = 0; i < 6; ++i) {
            if (free[static_cast<std::size_t>(i)] != 0) continue;
            Block& b = block[k];
            for (int j = 0; j < 6; ++j) b.diagonal[i][j] = b.diagonal[j][i] = P(0.0);
            b.diagonal[i][i] = P(1.0);
            b.u[i] = P(0.0);
            for (int j = 0; j < 6; ++j) {
                if (k < n) b.next[j][i] = P(0.0);
                if (k > 0) block[k - 1].next[i][j] = P(0.0);
            }
        }
    }

    /// Lower triangles only. next[i][j]: row i of block k + 1, column j of block k.
    static void solve(int n, Block* block) {
        for (int k = 0; k <= n; ++k) {
            Block& b = block[k];
            auto& g = b.diagonal;
            for (int j = 0; j < 6; ++j) {
                for (int m = 0; m < j; ++m) g[j][j] = fnma(g[j][m], g[j][m], g[j][j]);
                const P inverse = P(1.0) / sqrt(g[j][j]);
                g[j][j] = inverse; // 1/G
                for (int i = j + 1; i < 6; ++i) {
                    for (int m = 0; m < j; ++m) g[i][j] = fnma(g[i][m], g[j][m], g[i][j]);
                    g[i][j] = inverse * g[i][j];
                }
            }
            for (int i = 0; i < 6; ++i) {
                for (int m = 0; m < i; ++m) b.u[i] = fnma(g[i][m], b.u[m], b.u[i]);
                b.u[i] = g[i][i] * b.u[i];
            }
            if (k == n) break;
            Block& after = block[k + 1];
            for (int i = 0; i < 6; ++i) {
                for (int j = 0; j < 6; ++j) {
                    for (int m = 0; m < j; ++m) b.next[i][j] = fnma(b.next[i][m], g[j][m], b.next[i][j]);
                    b.next[i][j] = g[j][j] * b.next[i][j];
                }
                for (int m = 0; m < 6; ++m) after.u[i] = fnma(b.next[i][m], b.u[m], after.u[i]);
                for (int j = 0; j <= i; ++j)
                    for (int m = 0; m < 6; ++m) after.diagonal[i][j] = fnma(b.next[i][m], b.next[j][m], after.diagonal[i][j]);
            }
        }
        for (int k = n; k >= 0; --k) {
            Block& b = block[k];
            for (int i = 5; i >= 0; --i) {
                if (k < n)
                    for (int m = 0; m < 6; ++m) b.u[i] = fnma(b.next[m][i], block[k + 1].u[m], b.u[i]);
                for (int m = i + 1; m < 6; ++m) b.u[i] = fnma(b.diagonal[m][i], b.u[m], b.u[i]);
                b.u[i] = b.diagonal[i][i] * b.u[i];
            }
        }
    }

    void kick(const RodTile<W>& rod, const SlotLoad<W>* load, const Block* block, double h) const {
        const int n = rod.n;
        P power(0.0), correction(0.0), zero(0.0);
        for (int k = 0; k <= n; ++k) {
            const P* u = block[k].u;
            const auto& free = at(k).free;
            const Vec3<P> open{P(free[0]), P(free[1]), P(free[2])}; // forces on what is held do no work
            power += dot(scale(open, load[k].force), rod.slot[k].velocity);
            if (k < n) power += dot(load[k].couple, rod.slot[k].spin);
            const P move = max(abs(u[0]), max(abs(u[1]), abs(u[2]))), turn = max(abs(u[3]), max(abs(u[4]), abs(u[5])));
            correction = max(correction, max(P(1 / length_) * move, turn));
            zero = fma(u[0] + u[1] + u[2] + u[3] + u[4] + u[5], P(0.0), zero); // or no number
        }
        const Mask<W> against = power < P(0.0);
        const P kept = select(against, P(0.0), P(momentum_));
        P reach(1.0), excess(0.0);
        if (contacts_.any()) {
            P& own = reach_[rod.number];
            own = reach = select(against, max(P(least_reach), P(0.5) * own), min(P(1.0), P(1.05) * own));
        }
        Vec3<P> before{};
        for (int k = 0; k <= n; ++k) {
            Slot<W>& s = rod.slot[k];
            const P* u = block[k].u;
            s.velocity = fma(P(h), Vec3<P>{u[0], u[1], u[2]}, kept * s.velocity);
            if (k > 0) {
                const Vec3<P> apart = s.velocity - before;
                excess = max(excess, P(h * rod.element[k - 1].inv_rest_length / at(k - 1).most_turn) * norm(apart));
            }
            before = s.velocity;
            excess = max(excess, P(h / contacts_.farthest_move) * norm(s.velocity));
            if (k == n) break;
            s.spin = fma(P(h), s.director * Vec3<P>{u[3], u[4], u[5]}, kept * s.spin);
            excess = max(excess, P(h / at(k).most_turn) * norm(s.spin));
        }
        if (const Mask<W> beyond = excess > reach; any(beyond)) {
            const P share = select(beyond, reach / excess, P(1.0));
            for (int k = 0; k <= n; ++k) {
                rod.slot[k].velocity = share * rod.slot[k].velocity;
                if (k < n) rod.slot[k].spin = share * rod.slot[k].spin;
            }
        }
        double largest = 0;
        for (int l = 0; l < W; ++l) largest = std::max(largest, zero[l] == 0 ? correction[l] : HUGE_VAL);
        if (residual_) residual_->set(static_cast<std::size_t>(group_), rod.number, largest);
    }

    int group_;
    Ends ends_;
    RelaxationContacts contacts_;
    std::shared_ptr<RelaxationResidual> residual_;
    double momentum_;
    double length_ = 0;
    std::vector<Row> row_;           ///< [n + 1]
    mutable AlignedVector<P> reach_; ///< by tile: share of the farthest step that a rod may now take
};

} // namespace skein
