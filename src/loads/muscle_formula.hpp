// Muscles as formulas of a scene: a moment in the rod that changes with time and place along it. theory.md (36), (36a)
//   m_j = m(s_j, t)  [N m]   at every vertex j, as couples on its two elements (loads/vertex_couples.hpp), or
//   m_j = B_j k(s_j, t)      k [1/m] a change of the rest curvature, B_j the stiffness of the vertex's cell
// A ring's last vertex, s = L, is where it closes. The ends s = 0 and s = L of an open rod are vertices where they are
// clamped: the element has m_0, or -m_n, and the clamp the opposite. Cost: 30 flop per element beside the formulas,
// about body axes 100.
#pragma once

#include "loads/formula_reading.hpp"
#include "loads/formula_vector.hpp"
#include "loads/load_frame.hpp"
#include "loads/vertex_couples.hpp"
#include "skein/core/error.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"
#include "tiles/end_moments.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct MuscleFormula {
    static constexpr std::string_view kind = "muscle_formula", label = "muscles by formula";
    static constexpr bool for_rigid_bodies = false;
    std::vector<std::string> moment;
    LoadFrame frame = LoadFrame::body;
    std::vector<std::string> curvature = {}; ///< instead of `moment`

    void fields(FieldVisitor& f) {
        f.visit({.name = "moment",
                 .unit = "N m",
                 .text = "three formulas of s, t, L, rod, X, Y, Z: moment of the muscles at the vertex at s"},
                moment);
        f.visit({.name = "curvature",
                 .unit = "1/m",
                 .text = "three formulas: change of the rest curvature about d1, d2, d3 at the vertex by muscles; "
                         "instead of `moment`"},
                curvature);
        f.choice(
            {.name = "frame",
             .text = "axes of `moment`; body axes (d1, d2, d3) turn with the rod, like a change of its rest curvature"},
            frame, load_frame_names);
    }
    /// Reads the formulas. It is called first, with all names that they may hold.
    void use(const FormulaScope& scope);
    /// True where a formula depends on the variable.
    bool depends_on(Variable v) const { return moment_.program.uses(v); }
    void check(RodSpecs groups, Objections& objections) const;
    double predicted_ns() const { return 2 + moment_.program.predicted_ns(); }
    std::string fault_at_start(const RodGroup& group) const;

    void prepare(std::span<const Step> steps) {
        require_read(reading_.get(), kind);
        moment_.prepare(steps);
    }

    template <int W> struct TileData {
        PlaceValues<W> places;
        AlignedVector<Pack<W>> acts;            ///< [node]: 1 where it is a vertex
        AlignedVector<Vec3<Pack<W>>> stiffness; ///< [node]: stiffness of its cell, N m^2; empty for formulas of moments
    };
    bool has_tables_of_places() const { return moment_.has_tables_of_places(); }
    /// Values of places alone change with tables.
    template <int W> void renew(const RodTile<W>& rod, TileData<W>& data) const {
        data.places = place_values<W>(moment_, rod, false);
    }
    template <int W> TileData<W> bind(const RodTile<W>& rod) const {
        TileData<W> data{place_values<W>(moment_, rod, false), {}, {}};
        for (int i = 0; i <= rod.n; ++i) {
            Pack<W> acts(1.0);
            Vec3<Pack<W>> stiffness{};
            for (int l = 0; l < lanes_of<W>; ++l) {
                const RodGroup& group = rod.group_of(l);
                const int slot = rod.strands ? rod.strands->slot(l, i) : i;
                const bool held = slot == 0                  ? group.spec().start == EndKind::clamped
                                  : slot == group.elements() ? group.spec().end == EndKind::clamped
                                                             : slot > 0;
                acts.set(l, held || group.closed());
                set_lane(stiffness, l, slot < 0 ? Vec3d{0, 0, 0} : group.cell_at(slot).stiffness);
            }
            data.acts.push_back(acts);
            if (!curvature.empty()) data.stiffness.push_back(stiffness);
        }
        return data;
    }

    template <int W, class Map = Across<W>>
    void add(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load, const Step& step) const {
        using P = Pack<W>;
        const int n = rod.n;
        const bool closed = !Map::along && rod.group->closed();
        FormulaRun<W> run(moment_, data.places, step.slot);
        const auto moment = [&](int node, int i) {
            const Mask<W> acts = nth(data.acts, node) > P(0.5);
            const Vec3<P> value{run[0][i], run[1][i], run[2][i]};
            return select(acts, data.stiffness.empty() ? value : scale(nth(data.stiffness, node), value),
                          Vec3<P>{P(0.0), P(0.0), P(0.0)});
        };
        const auto moment_alone = [&](int node) {
            run.at_nodes(rod, node, 1);
            return moment(node, 0);
        };
        Vec3<P> first = moment_alone(0);
        const Vec3<P> last = last_node_value<Map>(rod, first, moment_alone(n));
        if (closed) first = last;
        const auto each_inner_row = [&](auto&& add_at) {
            const int longest = run.strip_of(n - 1);
            for (int begin = 1; begin < n; begin += longest) {
                const int count = std::min(longest, n - begin);
                run.at_nodes(rod, begin, count);
                for (int i = 0; i < count; ++i) add_at(begin + i, moment(begin + i, i));
            }
        };
        Vec3<P> before = first;
        if (frame == LoadFrame::lab) {
            const auto add_to = [&](int k, const Vec3<P>& after) {
                load[k].couple += rod.slot[k].director * (before - after);
                before = after;
            };
            each_inner_row([&](int node, const Vec3<P>& m) { add_to(node - 1, m); });
            return add_to(n - 1, last);
        }
        // One vertex serves both sides where a ring closes, or where a lane's rod goes on in the next.
        VertexCouples<P> seam;
        if constexpr (Map::along) {
            seam = about<Map>(rod, n - 1, from_lane_after(rod.slot[0].director), last);
            before = select(rod.strands->first, first, from_lane_before(seam.after));
        } else {
            seam = about<Map>(rod, n - 1, rod.slot[closed ? 0 : n - 1].director, last);
            if (closed) before = seam.after;
        }
        each_inner_row([&](int node, const Vec3<P>& m) {
            const VertexCouples<P> c = about<Map>(rod, node - 1, rod.slot[node].director, m);
            load[node - 1].couple += before + c.before;
            before = c.after;
        });
        load[n - 1].couple += before + seam.before;
    }

    /// Adds the moments at the ends of an open rod, for joints there.
    template <int W> void add_end_moments(const RodTile<W>& rod, const TileData<W>& data, const Step& step,
                                          EndMoments<W>& moments) const {
        if (rod.group->closed()) return;
        FormulaRun<W> run(moment_, data.places, step.slot);
        const auto add = [&](int node, int element, EndMoment<Pack<W>>& at) {
            run.at_nodes(rod, node, 1);
            const Vec3<Pack<W>> value{run[0][0], run[1][0], run[2][0]};
            if (!curvature.empty()) at.body += scale(broadcast<W>(rod.element[element].bending), value);
            else (frame == LoadFrame::lab ? at.lab : at.body) += value;
        };
        add(0, 0, moments.start);
        add(rod.n, rod.n - 1, moments.end);
    }

    // Members below are set by use() and read by add().
    const char* key() const { return curvature.empty() ? "moment" : "curvature"; }
    /// Couples of the vertex after element k; without a turn where a rod ends.
    template <class Map, int W> SKEIN_INLINE static VertexCouples<Pack<W>>
    about(const RodTile<W>& rod, int k, const Quaternion<Pack<W>>& next, const Vec3<Pack<W>>& m) {
        const Quaternion<Pack<W>>& here = rod.slot[k].director;
        if constexpr (Map::along) return about_body_axes(select(Map::cell(rod, k).inner, next, here), here, m);
        else return about_body_axes(next, here, m);
    }

    std::shared_ptr<const FormulaReading> reading_;
    std::vector<int> nodes_;
    FormulaVector moment_;
};

} // namespace skein
