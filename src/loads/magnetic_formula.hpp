// Couple and force of a magnetic field from formulas, on rods magnetised in their material. theory.md (40d)
//   U = -sum V_k m_k . Q_k B(y_k, t),  y_k = (x_k + x_k+1)/2
//   c_k += V_k m_k x Q_k B                        [N m] body; m_k as in magnetic_field, or a formula too [A/m]
//   f_k, f_k+1 += V_k/2 grad (Q_k^T m_k . B)      [N] lab; by derivatives of the formulas
#pragma once

#include "loads/formula_reading.hpp"
#include "loads/formula_vector.hpp"
#include "loads/magnetic_field.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct MagneticFormula {
    static constexpr std::string_view kind = "magnetic_formula", label = "magnetics by formula";
    static constexpr bool for_rigid_bodies = false;
    std::vector<std::string> field, magnetisation;

    void fields(FieldVisitor& f) {
        f.visit({.name = "field",
                 .unit = "T",
                 .text = "three formulas: B in the middle of elements, lab frame",
                 .required = true},
                field);
        f.visit({.name = "magnetisation",
                 .unit = "A/m",
                 .text = "three formulas of s, L, rod: magnetisation along d1, d2, d3; default: [rods.magnetisation]"},
                magnetisation);
    }
    /// Reads the formulas. It is called first, with all names that they may hold.
    void use(const FormulaScope& scope);
    /// True where a formula depends on the variable.
    bool depends_on(Variable v) const { return values_.program.uses(v); }
    bool acts_on(const RodSpec& rods) const { return !magnetisation.empty() || MagneticField::acts_on(rods); }
    void check(RodSpecs groups, Objections& objections) const;
    double predicted_ns() const { return 1 + values_.program.predicted_ns(); }
    std::string fault_at_start(const RodGroup& group) const;
    /// Stiffness against positions and rotations of an element together. theory.md (40e)
    DragRate largest_stiffness(const RodGroup& group) const;

    void prepare(std::span<const Step> steps) {
        require_read(reading_.get(), kind);
        values_.prepare(steps);
    }

    template <int W> struct TileData {
        MagneticField::TileData<W> moments;
        PlaceValues<W> places;
    };
    bool has_tables_of_places() const { return values_.has_tables_of_places() || moments_.has_tables_of_places(); }
    template <int W> TileData<W> bind(const RodTile<W>& rod) const {
        return {moments_.given ? moments_of(rod) : MagneticField{}.bind<W>(rod), place_values<W>(values_, rod, true)};
    }

    template <int W, class Map = Across<W>>
    void add(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load, const Step& step) const {
        if (!values_.same_everywhere()) return add_by_places<W, Map>(rod, data, load, step);
        const auto b = broadcast<W>(nth(values_.uniform, step.slot));
        const Vec3<Pack<W>>* m = data.moments.moment.data();
        for (int k = 0; k < rod.n; ++k, m += data.moments.stride)
            load[k].couple = fma(Pack<W>(Map::element(rod, k).volume), couple_at<Map>(rod, k, *m, b), load[k].couple);
    }

    // Members below are set by use() and read by add().
    template <int W, class Map> [[gnu::noinline]] void add_by_places(const RodTile<W>& rod, const TileData<W>& data,
                                                                     SlotLoad<W>* load, const Step& step) const {
        using P = Pack<W>;
        FormulaRun<W> run(values_, data.places, step.slot);
        const auto moment = [&](int k) -> const Vec3<P>& { return nth(data.moments.moment, k * data.moments.stride); };
        const auto triple = [&](int first, int i) {
            return Vec3<P>{run[first][i], run[first + 1][i], run[first + 2][i]};
        };
        /// Half of the force on element k, place i of an evaluated strip.
        const auto half_force = [&](int k, int i) {
            const Vec3<P> m =
                (P(0.5) * P(Map::element(rod, k).volume)) * transpose_times(rod.slot[k].director, moment(k));
            return where_present<Map>(rod, k, fma(m.x, triple(3, i), fma(m.y, triple(6, i), m.z * triple(9, i))));
        };
        Vec3<P> before = nothing<W>();
        if (Map::along && !uniform_) {
            run.template at_middles<Map>(rod, rod.n - 1, 1);
            before = first_node_value<Map>(rod, half_force(rod.n - 1, 0));
        }
        const int longest = run.strip_of(rod.n);
        for (int first = 0; first < rod.n; first += longest) {
            const int count = std::min(longest, rod.n - first);
            run.template at_middles<Map>(rod, first, count);
            for (int i = 0; i < count; ++i) {
                const int k = first + i;
                load[k].couple = fma(P(Map::element(rod, k).volume), couple_at<Map>(rod, k, moment(k), triple(0, i)),
                                     load[k].couple);
                if (uniform_) continue;
                const Vec3<P> half = half_force(k, i);
                load[k].force = load[k].force + before + half;
                before = half;
            }
        }
        if (!uniform_) load[rod.n].force += before;
    }

    template <class Map, int W> SKEIN_INLINE static Vec3<Pack<W>>
    couple_at(const RodTile<W>& rod, int k, const Vec3<Pack<W>>& m, const Vec3<Pack<W>>& b) {
        return where_present<Map>(rod, k, cross(m, rod.slot[k].director * b));
    }

    template <int W> MagneticField::TileData<W> moments_of(const RodTile<W>& rod) const {
        MagneticField::TileData<W> data;
        data.stride = 1;
        const auto places = place_values<W>(moments_, rod, true);
        FormulaRun<W> run(moments_, places, 0);
        for (int first = 0; first < rod.n; first += strip<W>) {
            const int count = std::min(strip<W>, rod.n - first);
            run.template at_middles<Across<W>>(rod, first, count); // depends on no state
            for (int i = 0; i < count; ++i) data.moment.push_back({run[0][i], run[1][i], run[2][i]});
        }
        return data;
    }

    std::shared_ptr<const FormulaReading> reading_;
    std::vector<int> nodes_; ///< B, then the gradients of its three components
    std::vector<int> moment_nodes_;
    FormulaVector values_, moments_;
    bool uniform_ = true;
};

} // namespace skein
