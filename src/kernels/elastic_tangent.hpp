// Internal loads of a rod at rest and their stiffness, element by element and cell by cell. theory.md (97), (98)
//   element   d nu = Q (dx' - dx)/l + nu x t,   F = Q^T n,   c = l nu x n
//   cell      slopes of its couples and its tension by both turns and both dilatations: dual numbers
// n and E are those of the carried strain; loads are corrected by their slopes times nu - carried.
#pragma once

#include "core/dual_rotation.hpp"
#include "kernels/static_rods.hpp"
#include "mechanics/elastic.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace skein {

template <class Law> class ElasticTangent {
public:
    struct Walls {
        Quaterniond start, end;
    };
    /// `load`: where to add, from the rod's first slot on.
    struct Target {
        Vec3d *force, *couple;
        double *force_size, *couple_size;
        StiffnessRow* row; ///< null: loads alone
    };

    static void add(const RodGroup& group, const Walls& walls, const Slot<1>* slot, const Vec3d* carried,
                    const Target& to) {
        const ElasticTangent rod(group, slot, carried, to);
        std::vector<Tension> tension(to_index(group.elements()));
        const Ends ends = ends_of(group);
        const int n = group.elements();
        for (int k = 0; k < group.cells(); ++k) rod.add_cell(k, k + 1 == n ? 0 : k + 1, tension);
        if (ends.start_wall) rod.add_wall(group.start_wall, walls.start, true, tension.front());
        if (ends.end_wall) rod.add_wall(group.end_wall, walls.end, false, tension.back());
        for (int k = 0; k < n; ++k) rod.add_element(k, nth(tension, k));
    }

private:
    using P = Pack<1>;
    using D = Pack<dual>;
    /// Axial force that cells add to an element, N: at the carried strains, and with its slopes.
    struct Tension {
        double value = 0, corrected = 0;
    };
    /// Gradient of an element's dilatation: by the node after it less the node before it, lab, and by its turn.
    struct Gradient {
        Vec3d node, turn;
    };
    /// Elements of a cell, or the one of a half cell (the other -1), with their frames.
    struct CellPlace {
        int before, after;
        Quaterniond frame_before, frame_after;
    };

    ElasticTangent(const RodGroup& group, const Slot<1>* slot, const Vec3d* carried, const Target& to)
        : group_(group), slot_(slot), carried_(carried), to_(to) {}

    int next(int k) const { return group_.closed() && k + 1 == group_.elements() ? 0 : k + 1; }
    Quaterniond frame(int k) const { return lane(slot_[k].director, 0); }
    Vec3d edge(int k) const { return lane(slot_[k + 1].position, 0) - lane(slot_[k].position, 0); }
    Vec3d strain(int k) const { return nth(group_.element, k).inv_rest_length * (frame(k) * edge(k)); }
    Gradient gradient(int k) const {
        const Vec3d nu = strain(k), axis = third_director(frame(k));
        return {nth(group_.element, k).inv_rest_length * axis, {-nu.y, nu.x, 0}};
    }

    static D along(double value, int direction) {
        D d(value);
        if (direction >= 0) d.d.set(direction, 1.0);
        return d;
    }
    static constexpr std::size_t stretch_before = 6; // directions: of both turns, and of both dilatations from here on
    static constexpr std::size_t rows = 8;

    /// Slopes of a cell's loads: rows and columns are both turns and both dilatations.
    using CellMatrix = std::array<std::array<double, rows>, rows>;

    void add_cell(int k, int after, std::vector<Tension>& tension) const {
        const VoronoiConstants& v = nth(group_.voronoi, k);
        const D e = D(v.share_before) * along(carried_[k].z, 6) + D(v.share_after) * along(carried_[after].z, 7);
        const CellPlace place{k, after, frame(k), frame(after)};
        const CellLoads<D> loads =
            loads_of(place, Law::bending_pulls ? D(1.0) / e : D(1.0), v, nth(group_.element, k).rest_stretch);
        add(place, loads, tension.data());
    }
    void add_wall(const VoronoiConstants& half, const Quaterniond& wall, bool start, Tension& tension) const {
        const int k = start ? 0 : group_.elements() - 1;
        const CellPlace place = start ? CellPlace{-1, 0, wall, frame(0)} : CellPlace{k, -1, frame(k), wall};
        const D e = along(carried_[k].z, start ? 7 : 6);
        const CellLoads<D> loads =
            loads_of(place, Law::bending_pulls ? D(1.0) / e : D(1.0), half, nth(group_.element, k).rest_stretch);
        add(place, loads, &tension - k);
    }
    static CellLoads<D> loads_of(const CellPlace& place, const D& inv_dilatation, const VoronoiConstants& v,
                                 double rest_stretch) {
        const auto turn = relative_rotation_along(place.frame_after, place.after < 0 ? -1 : 3, place.frame_before,
                                                  place.before < 0 ? -1 : 0);
        return cell_loads<Law, dual>({turn, inv_dilatation}, v.inv_length, v.stiffness, v.rest_curvature, rest_stretch);
    }

    /// Adds the loads of a cell, and their stiffness. `tension`: by element.
    void add(const CellPlace& at, const CellLoads<D>& loads, Tension* tension) const {
        const double off_before = at.before < 0 ? 0 : strain(at.before).z - carried_[at.before].z,
                     off_after = at.after < 0 ? 0 : strain(at.after).z - carried_[at.after].z;
        const auto corrected = [&](const D& a) { return a.v + a.d[6] * off_before + a.d[7] * off_after; };
        const auto couple = [&](int k, const Vec3<D>& c) {
            if (k < 0) return;
            const Vec3d one{corrected(c.x), corrected(c.y), corrected(c.z)};
            to_.couple[k] = to_.couple[k] + one;
            to_.couple_size[k] += norm(one);
        };
        couple(at.before, loads.before);
        couple(at.after, loads.after);
        if constexpr (Law::bending_pulls)
            for (const int k : {at.before, at.after})
                if (k >= 0) {
                    tension[k].value += loads.tension.v;
                    tension[k].corrected += corrected(loads.tension);
                }
        if (to_.row) add_stiffness(at, loads);
    }

    void add_stiffness(const CellPlace& at, const CellLoads<D>& loads) const {
        const double l_before = at.before < 0 ? 0 : nth(group_.element, at.before).rest_length,
                     l_after = at.after < 0 ? 0 : nth(group_.element, at.after).rest_length;
        CellMatrix m{};
        const D* of[6] = {&loads.before.x, &loads.before.y, &loads.before.z,
                          &loads.after.x,  &loads.after.y,  &loads.after.z};
        for (std::size_t i = 0; i < 6; ++i)
            for (std::size_t j = 0; j < rows; ++j) m[i][j] = -of[i]->d[static_cast<int>(j)];
        if constexpr (Law::bending_pulls)
            for (std::size_t j = 0; j < rows; ++j) {
                m[6][j] = l_before * loads.tension.d[static_cast<int>(j)];
                m[7][j] = l_after * loads.tension.d[static_cast<int>(j)];
            }
        // [c]/2 of the couples at the carried strains
        const auto turning = [&](const Vec3<D>& c, std::size_t first) {
            const double h[3] = {0.5 * c.x.v, 0.5 * c.y.v, 0.5 * c.z.v};
            m[first][first + 1] -= h[2];
            m[first][first + 2] += h[1];
            m[first + 1][first] += h[2];
            m[first + 1][first + 2] -= h[0];
            m[first + 2][first] -= h[1];
            m[first + 2][first + 1] += h[0];
        };
        turning(loads.before, 0);
        turning(loads.after, 3);
        spread(at, m);
    }

    static constexpr std::size_t slots = 3, size = slots * slot_unknowns;
    /// Unknowns of the slots from a cell's first on.
    using Row = std::array<double, size>;

    /// row += by * other, of `count` numbers.
    template <std::size_t count> static void add_times(double* row, double by, const double* other) {
        static_assert(count % 2 == 0);
        using Two = Pack<2>;
        for (std::size_t i = 0; i < count; i += 2) {
            Two a, b;
            std::memcpy(&a, row + i, sizeof a);
            std::memcpy(&b, other + i, sizeof b);
            a = a + Two(by) * b;
            std::memcpy(row + i, &a, sizeof a);
        }
    }

    /// The dilatation of an element by the unknowns from its slot on, to the third director of its turn.
    struct StretchParts {
        static constexpr std::size_t at[8] = {0, slot_unknowns, 1, slot_unknowns + 1, 2, slot_unknowns + 2, 3, 4};
        double factor[8];
    };
    StretchParts stretch_parts(int k) const {
        const Gradient g = gradient(k);
        return {{-g.node.x, g.node.x, -g.node.y, g.node.y, -g.node.z, g.node.z, g.turn.x, g.turn.y}};
    }

    /// Adds T^T m T: turns as they are, dilatations by their gradients.
    void spread(const CellPlace& at, const CellMatrix& m) const {
        const int first = at.before >= 0 ? at.before : at.after;
        const std::size_t second = at.before >= 0 ? 1 : 0; // slot of the element after the cell
        if constexpr (Law::bending_pulls) {
            spread_with_stretch(at, first, second, m);
        } else {
            const int element[2] = {at.before, at.after};
            for (std::size_t r = 0; r < 2; ++r)
                for (std::size_t c = 0; c < 2; ++c) {
                    if (element[r] < 0 || element[c] < 0) continue;
                    StiffnessBlock& block = to_.row[element[r]].at(offset(element[r], element[c]));
                    for (std::size_t i = 0; i < 3; ++i)
                        for (std::size_t j = 0; j < 3; ++j) block[3 + i][3 + j] += m[3 * r + i][3 * c + j];
                }
        }
    }
    void spread_with_stretch(const CellPlace& at, int first, std::size_t second, const CellMatrix& m) const {
        const bool acts[2] = {at.before >= 0, at.after >= 0};
        const std::size_t begin[2] = {0, second * slot_unknowns}; // of the slots of both elements
        StretchParts stretch[2]{};
        if (acts[0]) stretch[0] = stretch_parts(at.before);
        if (acts[1]) stretch[1] = stretch_parts(at.after);
        std::array<Row, rows> half; // m T
        for (std::size_t i = 0; i < rows; ++i) {
            half[i].fill(0);
            for (std::size_t e = 0; e < 2; ++e)
                for (std::size_t j = 0; acts[e] && j < 3; ++j) half[i][begin[e] + 3 + j] = m[i][3 * e + j];
            for (std::size_t e = 0; e < 2; ++e)
                for (std::size_t b = 0; acts[e] && b < 8; ++b)
                    half[i][begin[e] + StretchParts::at[b]] += m[i][stretch_before + e] * stretch[e].factor[b];
        }
        std::array<Row, size> all{};
        for (std::size_t e = 0; e < 2; ++e)
            for (std::size_t i = 0; acts[e] && i < 3; ++i) all[begin[e] + 3 + i] = half[3 * e + i];
        for (std::size_t e = 0; e < 2; ++e)
            for (std::size_t a = 0; acts[e] && a < 8; ++a)
                add_times<size>(all[begin[e] + StretchParts::at[a]].data(), stretch[e].factor[a],
                                half[stretch_before + e].data());
        const std::size_t reached = acts[0] && acts[1] ? 3 : 2;
        int slot[slots] = {first, next(first), 0};
        slot[2] = reached > 2 ? next(slot[1]) : 0;
        for (std::size_t r = 0; r < reached; ++r)
            for (std::size_t c = 0; c < reached; ++c) {
                StiffnessBlock& block = to_.row[slot[r]].at(offset(slot[r], slot[c]));
                for (std::size_t i = 0; i < slot_unknowns; ++i)
                    add_times<slot_unknowns>(block[i].data(), 1, &all[r * slot_unknowns + i][c * slot_unknowns]);
            }
    }
    /// From slot to slot, the shorter way round a ring.
    int offset(int row, int column) const {
        int offset = column - row;
        if (group_.closed()) {
            const int n = group_.elements();
            if (offset > StiffnessRow::reach) offset -= n;
            if (offset < -StiffnessRow::reach) offset += n;
        }
        return offset;
    }
    double& entry(int row, int i, int column, int j) const {
        return to_.row[row].at(offset(row, column))[to_index(i)][to_index(j)];
    }

    void add_element(int k, const Tension& tension) const {
        const ElementConstants& c = nth(group_.element, k);
        const Vec3d nu = strain(k), was = carried_[k], off = nu - was;
        const Vec3<P> stress = Law::stress(c, broadcast<1>(was));
        const Vec3d stiff{c.stiffness.x, c.stiffness.y, Law::stretch_stiffness(c, P(was.z))[0]};
        Vec3d n = lane(stress, 0), all = n + scale(stiff, off);
        n.z += tension.value;
        all.z += tension.corrected;
        const Quaterniond q = frame(k);
        const Vec3d force = transpose_times(q, all), couple = c.rest_length * cross(nu, all);
        const int after = next(k);
        to_.force[k] = to_.force[k] + force;
        to_.force[after] = to_.force[after] - force;
        to_.couple[k] = to_.couple[k] + couple;
        const double size = norm(force);
        to_.force_size[k] += size;
        to_.force_size[after] += size;
        to_.couple_size[k] += norm(couple);
        if (to_.row) add_element_stiffness(k, q, nu, n, stiff);
    }

    using Three = std::array<std::array<double, 3>, 3>;
    static Three skew(const Vec3d& a) { return {{{0, -a.z, a.y}, {a.z, 0, -a.x}, {-a.y, a.x, 0}}}; }
    static Three times(const Three& a, const Three& b) {
        Three r{};
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) r[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        return r;
    }

    void add_element_stiffness(int k, const Quaterniond& frame, const Vec3d& nu, const Vec3d& n,
                               const Vec3d& stiff) const {
        const ElementConstants& c = nth(group_.element, k);
        const int after = next(k);
        const Mat3d m = matrix(frame);
        const Three q = {{{m.d1.x, m.d1.y, m.d1.z}, {m.d2.x, m.d2.y, m.d2.z}, {m.d3.x, m.d3.y, m.d3.z}}};
        const double s[3] = {stiff.x, stiff.y, stiff.z};
        const Three by_nu = skew(nu), by_n = skew(n);
        Three turned = by_nu; // [nu] S - [n]
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) turned[i][j] = by_nu[i][j] * s[j] - by_n[i][j];
        const Three cx = times(turned, q), ct = times(turned, by_nu);
        const Vec3d couple = c.rest_length * cross(nu, n);
        const Three half = skew(0.5 * couple);
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                double xx = 0;
                for (std::size_t a = 0; a < 3; ++a) xx += q[a][i] * s[a] * q[a][j];
                xx *= c.inv_rest_length;
                const int r = static_cast<int>(i), t = static_cast<int>(j);
                entry(k, r, k, t) += xx;
                entry(after, r, after, t) += xx;
                entry(k, r, after, t) -= xx;
                entry(after, r, k, t) -= xx;
                entry(k, 3 + r, k, t) += cx[i][j];
                entry(k, 3 + r, after, t) -= cx[i][j];
                entry(k, t, k, 3 + r) += cx[i][j];
                entry(after, t, k, 3 + r) -= cx[i][j];
                entry(k, 3 + r, k, 3 + t) += half[i][j] - c.rest_length * ct[i][j];
            }
    }

    const RodGroup& group_;
    const Slot<1>* slot_;
    const Vec3d* carried_;
    const Target& to_;
};

} // namespace skein
