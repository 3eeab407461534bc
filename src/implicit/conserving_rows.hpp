// Internal loads of a rod over a step, whose work is the change of its energy to round-off, and their stiffness row by
// row, for Newton corrections.   theory.md (119)-(122)
//   step          from (x0, Q0) to (x1, Q1);  m: means of both, of frames as matrices
//   element k     nu1 - nu0 = Qm (dx1 - dx0)/l + (Qm dxm/l) x a,   F = Qm^T n,   couple dxm x F   (lab)
//   cell k|k+1    phi1 - phi0 = G (b - a),   couples +-G^T tau   (lab)
//   laws          stresses n, tau of mean_laws.hpp
// Both sides of an element and of a cell have opposite forces and couples, and the couple of an element is that of its
// forces, so that momenta stay too. Unknowns of a row are the displacement dx of a node at the middle, and half the
// turn p of an element at the end, both in the lab.
//   element    d num = Q1 (d(dx) + dx1 x p)/l,   X = Qm^T S Q1/l,   dF = X d(dx) + T p,   T = X [dx1] - [Q1^T n]
//   cell       d phim = Y (p' - p),   Y = P B1,   Z = G^T K Y,   dC = Z (p' - p) - [C] (p + p')/2
// Mean strains s are unknowns of their own, which follow the corrections linearly, as in elastic_rows.hpp.
#pragma once

#include "implicit/block_rows.hpp"
#include "implicit/finite_turn.hpp"
#include "implicit/mean_laws.hpp"
#include "implicit/step_walls.hpp"
#include "mechanics/elastic.hpp"

namespace skein {

template <class Law, int W> class ConservingRows {
public:
    using P = Pack<W>;
    using V = Vec3<P>;
    using Q = Quaternion<P>;
    using M = Mat3<P>;

    struct Element {
        M start, end, mean;              ///< axes
        V start_apart, apart, end_apart; ///< from node to node, m; `apart`: of the mean
        V start_strain, strain;          ///< `strain`: of the mean
        V stress, force;                 ///< of the carried strain, body; of all, lab
    };
    struct Cell {
        TurnBetween<P> start;
        M turn, by_end;      ///< G, Y
        V stiffness, couple; ///< f B/D, body; C, lab
        P tension;           ///< on both elements, N
        bool present;        ///< false at free ends
    };
    /// Numbers of a rod in a step, by element and cell: [n] and [n + 1]. The first cell is before the first element.
    struct Work {
        AlignedVector<Element> element;
        AlignedVector<Cell> cell;
        M wall[2];     ///< means
        Q wall_end[2]; ///< at the end
    };

    ConservingRows(Ends ends, const StepWalls<W>& walls) : ends_(ends), walls_(walls) {}

    /// Begins a step. `start`: places and directors, [n + 1].
    void begin(const RodTile<W>& rod, const Slot<W>* start, const Step& step, Work& work) const {
        const int n = rod.n;
        if (work.element.size() < to_index(n)) work.element.resize(to_index(n));
        if (work.cell.size() <= to_index(n)) work.cell.resize(to_index(n) + 1);
        for (int k = 0; k < n; ++k) {
            Element& e = work.element[to_index(k)];
            e.start = matrix(start[k].director);
            e.start_apart = start[node_after(rod, k)].position - start[k].position;
            e.start_strain = P(rod.element[k].inv_rest_length) * (e.start * e.start_apart);
        }
        for (int k = 1; k < n; ++k) put(work, k, start[k].director, start[k - 1].director);
        work.cell[0].present = work.cell[to_index(n)].present = false;
        if (ends_.closed) put(work, 0, start[0].director, start[n - 1].director);
        if (ends_.start_wall) put(work, 0, start[0].director, take_wall(EndWalls<W>::start, rod, step, work));
        if (ends_.end_wall) put(work, n, take_wall(EndWalls<W>::end, rod, step, work), start[n - 1].director);
    }

    /// Sets internal forces and dilatations of `load`, whose couples are 0, and internal couples, lab, [n].
    /// `displacement`: of nodes from the start to the mean; `director`: of elements at the end.
    void loads(const RodTile<W>& rod, const V* displacement, const Q* director, const V* carried, SlotLoad<W>* load,
               V* couple, Work& work) const {
        const int n = rod.n;
        for (int k = 0; k < n; ++k) move(work.element[to_index(k)], rod, k, displacement, director[k]);
        compute_cells(rod, director, carried, work);
        V force_before{};
        for (int k = 0; k < n; ++k) {
            Element& e = work.element[to_index(k)];
            const Cell &before = work.cell[to_index(k)], &after = work.cell[cell_after(rod, k)];
            const V& s = carried[k];
            e.stress = mean_stress<Law>(rod.element[k], e.start_strain, end_strain(e, s));
            if constexpr (Law::bending_pulls) e.stress.z += before.tension + after.tension;
            e.force = transpose_times(e.mean, e.stress + scale(stiffness_of(rod, k, s), e.strain - s));
            load[k] = {e.force - force_before, {}, s.z};
            couple[k] = cross(e.apart, e.force) + (after.couple - before.couple);
            force_before = e.force;
        }
        load[n].force = -force_before;
        load[n].couple = {};
    }

    /// Calls take(k, row) with the stiffness of each row at the state of the last loads, in order, from 0 to `last`.
    template <class Take>
    void stiffness(const RodTile<W>& rod, const V* carried, int last, const Work& work, Take&& take) const {
        const int n = rod.n;
        ElementSlopes element_before = ends_.closed ? slopes(rod, n - 1, carried, work) : ElementSlopes{};
        CellSlopes before = slopes(work.cell[0]);
        BlockRow<W> row;
        for (int k = 0; k < n; ++k) {
            const CellSlopes after = slopes(work.cell[cell_after(rod, k)]);
            const ElementSlopes own = slopes(rod, k, carried, work);
            fill(row, element_before, own, before, after);
            take(k, row);
            element_before = own;
            before = after;
        }
        if (last < n) return;
        fill(row, element_before, {}, {}, {});
        take(n, row);
    }

    /// Mean strain that follows a correction linearly from `strain` on.
    static V followed(const RodTile<W>& rod, int k, const V& strain, const V& apart, const V& half_turn,
                      const Work& work) {
        const Element& e = work.element[to_index(k)];
        return fma(P(rod.element[k].inv_rest_length), e.end * (apart + cross(e.end_apart, half_turn)), strain);
    }

private:
    struct ElementSlopes {
        M x{}, t{}, u{}, v{}; ///< X, T; of the couple by a node and by the turn
    };
    struct CellSlopes {
        M z{};
        V c{}; ///< C/2
    };

    int node_after(const RodTile<W>& rod, int k) const { return ends_.closed && k == rod.n - 1 ? 0 : k + 1; }
    std::size_t cell_after(const RodTile<W>& rod, int k) const { return to_index(node_after(rod, k)); }

    static M mean_of(const M& a, const M& b) {
        const P half(0.5);
        return {half * (a.d1 + b.d1), half * (a.d2 + b.d2), half * (a.d3 + b.d3)};
    }
    /// [v] m
    static M cross_with(const V& v, const M& m) {
        return {fma(v.y, m.d3, -(v.z * m.d2)), fma(v.z, m.d1, -(v.x * m.d3)), fma(v.x, m.d2, -(v.y * m.d1))};
    }
    /// m - [v]
    static M less_cross(const M& m, const V& v) {
        return {{m.d1.x, m.d1.y + v.z, m.d1.z - v.y},
                {m.d2.x - v.z, m.d2.y, m.d2.z + v.x},
                {m.d3.x + v.y, m.d3.y - v.x, m.d3.z}};
    }
    static void put(Work& work, int cell, const Q& after, const Q& before) {
        work.cell[to_index(cell)].present = true;
        work.cell[to_index(cell)].start = turn_between(after, before);
    }
    /// Frame of a wall at the start; notes that at the end.
    Q take_wall(typename EndWalls<W>::End end, const RodTile<W>& rod, const Step& step, Work& work) const {
        const Q start = walls_.start_frame(end, rod, step), at_end = walls_.end_frame(end, rod, step);
        const int i = end == EndWalls<W>::start ? 0 : 1;
        work.wall[i] = mean_of(matrix(start), matrix(at_end));
        work.wall_end[i] = at_end;
        return start;
    }

    void move(Element& e, const RodTile<W>& rod, int k, const V* displacement, const Q& director) const {
        e.end = matrix(director);
        e.mean = mean_of(e.start, e.end);
        const V by = displacement[node_after(rod, k)] - displacement[k];
        e.apart = e.start_apart + by;
        e.end_apart = e.apart + by;
        e.strain = P(0.5) * fma(P(rod.element[k].inv_rest_length), e.end * e.end_apart, e.start_strain);
    }
    /// Strain at the end of the step by the carried mean.
    static V end_strain(const Element& e, const V& s) { return s + (s - e.start_strain); }
    static V stiffness_of(const RodTile<W>& rod, int k, const V& s) {
        const ElementConstants& c = rod.element[k];
        return {P(c.stiffness.x), P(c.stiffness.y), Law::stretch_stiffness(c, s.z)};
    }

    void compute_cells(const RodTile<W>& rod, const Q* director, const V* carried, Work& work) const {
        const int n = rod.n;
        const auto between = [&](int cell, int k, int next) {
            const Element &before = work.element[to_index(k)], &after = work.element[to_index(next)];
            const VoronoiConstants& v = rod.voronoi[k];
            const auto inverse_of = [&](const P& e, const P& e_next) {
                return Law::bending_pulls ? P(1.0) / fma(P(v.share_before), e, P(v.share_after) * e_next) : P(1.0);
            };
            compute(work.cell[to_index(cell)], turn_between(director[next], director[k]), after.end, after.mean,
                    before.mean, v, rod.element[k].rest_stretch,
                    inverse_of(before.start_strain.z, after.start_strain.z),
                    inverse_of(end_strain(before, carried[k]).z, end_strain(after, carried[next]).z));
        };
        const auto at_wall = [&](int cell, int i, int k, const VoronoiConstants& half) {
            const Element& e = work.element[to_index(k)];
            const Q& wall = work.wall_end[i];
            const bool first = i == 0;
            compute(work.cell[to_index(cell)],
                    first ? turn_between(director[k], wall) : turn_between(wall, director[k]),
                    first ? e.end : matrix(wall), first ? e.mean : work.wall[i], first ? work.wall[i] : e.mean, half,
                    rod.element[k].rest_stretch, P(1.0) / e.start_strain.z, P(1.0) / end_strain(e, carried[k]).z);
        };
        for (const int cell : {0, n}) {
            work.cell[to_index(cell)].couple = {P(0.0), P(0.0), P(0.0)};
            work.cell[to_index(cell)].tension = P(0.0);
        }
        if (ends_.closed) between(0, n - 1, 0);
        if (ends_.start_wall) at_wall(0, 0, 0, rod.group->start_wall);
        for (int k = 1; k < n; ++k) between(k, k - 1, k);
        if (ends_.end_wall) at_wall(n, 1, n - 1, rod.group->end_wall);
    }

    /// `from` and `to`: inverse dilatations at both ends of the step.
    static void compute(Cell& cell, const TurnBetween<P>& end, const M& after_end, const M& after, const M& before,
                        const VoronoiConstants& v, double rest_stretch, const P& from, const P& to) {
        cell.turn = finite_turn(cell.start, end, after, before);
        const V b = broadcast<W>(v.stiffness), rest = broadcast<W>(v.rest_curvature);
        const P inv(v.inv_length), half(0.5);
        const V strain0 = fma(inv, cell.start.log, -rest), strain1 = fma(inv, end.log, -rest);
        const CellFactor<P> factor = mean_factor<Law>(from, to, rest_stretch);
        cell.couple = transpose_times(cell.turn, factor * scale(b, half * (strain0 + strain1)));
        cell.stiffness = (factor * inv) * b;
        const M turned = cross_with(end.log, after_end), twice = cross_with(end.log, turned);
        const auto row = [&](const V& one, const V& two, const V& three) {
            return fma(end.jacobian, three, fma(half, two, one));
        };
        cell.by_end = {row(after_end.d1, turned.d1, twice.d1), row(after_end.d2, turned.d2, twice.d2),
                       row(after_end.d3, turned.d3, twice.d3)};
        if constexpr (Law::bending_pulls) {
            const V q = half * (scale(strain0, scale(b, strain0)) + scale(strain1, scale(b, strain1)));
            cell.tension = MeanLaw<Law>::tension(CellEnergies<P>{q.x + q.y, q.z}, from, to, rest_stretch);
        }
    }

    static ElementSlopes slopes(const RodTile<W>& rod, int k, const V* carried, const Work& work) {
        const Element& e = work.element[to_index(k)];
        ElementSlopes r;
        r.x = transpose_product(e.mean, P(rod.element[k].inv_rest_length) * stiffness_of(rod, k, carried[k]), e.end);
        const M turned{cross(r.x.d1, e.end_apart), cross(r.x.d2, e.end_apart), cross(r.x.d3, e.end_apart)};
        r.t = less_cross(turned, transpose_times(e.end, e.stress));
        r.u = less_cross(cross_with(e.apart, r.x), transpose_times(e.mean, e.stress));
        r.v = cross_with(e.apart, r.t);
        return r;
    }
    static CellSlopes slopes(const Cell& cell) {
        if (!cell.present) return {};
        return {transpose_product(cell.turn, cell.stiffness, cell.by_end), P(0.5) * cell.couple};
    }

    /// Places a block at (i, j), with a sign.
    static void put(RowBlock<W>& block, int i, int j, double sign, const M& m) {
        const V* const rows[3] = {&m.d1, &m.d2, &m.d3};
        for (int a = 0; a < 3; ++a) {
            block[i + a][j] = P(sign) * rows[a]->x;
            block[i + a][j + 1] = P(sign) * rows[a]->y;
            block[i + a][j + 2] = P(sign) * rows[a]->z;
        }
    }
    static void fill(BlockRow<W>& row, const ElementSlopes& element_before, const ElementSlopes& own,
                     const CellSlopes& before, const CellSlopes& after) {
        const auto sum = [](const M& a, const M& b) { return M{a.d1 + b.d1, a.d2 + b.d2, a.d3 + b.d3}; };
        const M none{};
        put(row.diagonal, 0, 0, 1, sum(element_before.x, own.x));
        put(row.diagonal, 0, 3, -1, own.t);
        put(row.diagonal, 3, 0, 1, own.u);
        // cells: Z + [C]/2 of that after the element, Z - [C]/2 of that before it
        const M cells = less_cross(sum(before.z, after.z), before.c - after.c);
        put(row.diagonal, 3, 3, 1, less(cells, own.v));
        put(row.before, 0, 0, -1, element_before.x);
        put(row.before, 0, 3, 1, element_before.t);
        put(row.before, 3, 0, 1, none);
        put(row.before, 3, 3, -1, less_cross(before.z, -before.c));
        put(row.after, 0, 0, -1, own.x);
        put(row.after, 0, 3, 1, none);
        put(row.after, 3, 0, -1, own.u);
        put(row.after, 3, 3, -1, less_cross(after.z, after.c));
    }
    static M less(const M& a, const M& b) { return {a.d1 - b.d1, a.d2 - b.d2, a.d3 - b.d3}; }

    Ends ends_;
    const StepWalls<W>& walls_;
};

} // namespace skein
