// Force and couple as formulas of a scene. theory.md (42)-(44)
//   f_i += w_i F(x_i, v_i, s_i, t)          [N] lab, at nodes; w: rest length or mass of the node, or its share of the
//                                           rod's length
//   c_k += w_k Q_k C(x_k, v_k, s_k, t)      [N m] body, of elements, x_k and v_k in the middle of their nodes; without
//                                           Q_k in body axes
// Values that change with time alone are computed once a step, values of places alone once a run.
#pragma once

#include "loads/formula_reading.hpp"
#include "loads/formula_vector.hpp"
#include "loads/load_frame.hpp"
#include "skein/core/error.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace skein {

/// Unit to which a formula refers: a metre of rest length, a kilogram, or the whole rod, evenly.
enum class FormulaPer { length, mass, rod };
inline constexpr std::string_view formula_per_names[] = {"length", "mass", "rod"};
enum class FormulaAt { rod, start, end };
inline constexpr std::string_view formula_at_names[] = {"rod", "start", "end"};

struct FormulaLoad {
    static constexpr std::string_view kind = "formula", label = "loads by formula";
    static constexpr bool for_rigid_bodies = false;
    std::vector<std::string> force, couple;
    FormulaPer per = FormulaPer::length;
    FormulaAt at = FormulaAt::rod;
    LoadFrame frame = LoadFrame::lab;

    void fields(FieldVisitor& f);
    /// Reads the formulas. It is called first, with all names that they may hold.
    void use(const FormulaScope& scope);
    void check(RodSpecs groups, Objections& objections) const;
    /// True where a formula depends on the variable.
    bool depends_on(Variable v) const { return force_.program.uses(v) || couple_.program.uses(v); }
    /// True where the couple changes with places or velocities, which the limit of the step does not count. theory.md
    /// (40c)
    bool couple_answers() const { return couple_.given && (couple_.program.changes & with_state) != 0; }
    double predicted_ns() const { return 1 + force_.program.predicted_ns() + couple_.program.predicted_ns(); }
    /// Fault of the values at the start of rods and at some times of the run; empty where there is none.
    std::string fault_at_start(const RodGroup& group) const;
    /// Largest |dF/dv| and |dF/dx| over mass, at the same places and times. theory.md (44)
    DragRate largest_rate(const RodGroup& group) const;
    DragRate largest_stiffness(const RodGroup& group) const;

    void prepare(std::span<const Step> steps) {
        require_read(reading_.get(), kind);
        force_.prepare(steps);
        couple_.prepare(steps);
    }

    /// Values of places, by value and slot, and weights where the mapping has no constants for them.
    template <int W> struct TileData {
        PlaceValues<W> force, couple;
        AlignedVector<Pack<W>> force_weight, couple_weight;
    };
    template <int W> TileData<W> bind(const RodTile<W>& rod) const;
    bool has_tables_of_places() const { return force_.has_tables_of_places() || couple_.has_tables_of_places(); }

    template <int W, class Map = Across<W>>
    void add(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load, const Step& step) const {
        const std::size_t slot = to_index(step.slot);
        if (force_.given) {
            if (force_.same_everywhere()) add_uniform_force<W, Map>(rod, data, load, force_.uniform[slot]);
            else add_forces<W, Map>(rod, data, load, step);
        }
        if (couple_.given) {
            if (couple_.same_everywhere()) add_uniform_couple<W, Map>(rod, data, load, couple_.uniform[slot]);
            else add_couples<W, Map>(rod, data, load, step);
        }
    }

    // Members below are set by use() and read by add().
    template <int W, class Map>
    void add_uniform_force(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load, const Vec3d& force) const;
    template <int W, class Map> void add_uniform_couple(const RodTile<W>& rod, const TileData<W>& data,
                                                        SlotLoad<W>* load, const Vec3d& couple) const;
    // Loop from place to place, out of line, so that uniform loads do not pay for its registers.
    template <int W, class Map> [[gnu::noinline]] void add_forces(const RodTile<W>& rod, const TileData<W>& data,
                                                                  SlotLoad<W>* load, const Step& step) const;
    template <int W, class Map> [[gnu::noinline]] void add_couples(const RodTile<W>& rod, const TileData<W>& data,
                                                                   SlotLoad<W>* load, const Step& step) const;
    /// Calls f(weight) with w of node i, or of element k: a number across, a pack along.
    template <int W, class Map, class F>
    void with_node_weight(const RodTile<W>& rod, const TileData<W>& data, F&& f) const;
    template <int W, class Map, class F>
    void with_element_weight(const RodTile<W>& rod, const TileData<W>& data, F&& f) const;
    /// Adds couple_of(k) to elements first to last - 1.
    template <int W, class Map, class F> void add_element_couples(const RodTile<W>& rod, const TileData<W>& data,
                                                                  SlotLoad<W>* load, int first, int last,
                                                                  F couple_of) const;
    /// Range of the elements that have a couple: begin and end.
    template <int W, class Map> std::pair<int, int> elements_of(const RodTile<W>& rod) const {
        if (at == FormulaAt::rod || Map::along) return {0, rod.n};
        return at == FormulaAt::start ? std::pair(0, 1) : std::pair(rod.n - 1, rod.n);
    }
    double weight_over_mass(const RodGroup& group, int node) const;

    std::shared_ptr<const FormulaReading> reading_;
    std::vector<int> force_nodes_, couple_nodes_;
    FormulaVector force_, couple_;
};

template <int W> FormulaLoad::TileData<W> FormulaLoad::bind(const RodTile<W>& rod) const {
    TileData<W> data;
    if (force_.given) data.force = place_values<W>(force_, rod, false);
    if (couple_.given) data.couple = place_values<W>(couple_, rod, true);
    if (at == FormulaAt::rod || !rod.strands) return data;
    // Ends of strands lie in different rows: 1 in their places.
    data.force_weight.resize(to_index(rod.n) + 1, Pack<W>(0.0));
    data.couple_weight.resize(to_index(rod.n), Pack<W>(0.0));
    for (int i = 0; i <= rod.n; ++i)
        for (int l = 0; l < lanes_of<W>; ++l) {
            const int slot = rod.strands->slot(l, i), elements = rod.group_of(l).elements();
            nth(data.force_weight, i).set(l, slot == (at == FormulaAt::start ? 0 : elements));
            if (i < rod.n) nth(data.couple_weight, i).set(l, slot == (at == FormulaAt::start ? 0 : elements - 1));
        }
    return data;
}

template <int W, class Map, class F>
SKEIN_INLINE void FormulaLoad::with_node_weight(const RodTile<W>& rod, const TileData<W>& data, F&& f) const {
    if (at != FormulaAt::rod) {
        if constexpr (Map::along) f([&](int i) { return nth(data.force_weight, i); });
        else f([](int) { return 1.0; });
    } else if (per == FormulaPer::length) f([&](int i) { return Map::node_length(rod, i); });
    else if (per == FormulaPer::mass) f([&](int i) { return Map::node_mass(rod, i); });
    else f([&, share = 1.0 / Map::length(rod)](int i) { return share * Map::node_length(rod, i); });
}

template <int W, class Map, class F>
SKEIN_INLINE void FormulaLoad::with_element_weight(const RodTile<W>& rod, const TileData<W>& data, F&& f) const {
    if (at != FormulaAt::rod) {
        if constexpr (Map::along) f([&](int k) { return nth(data.couple_weight, k); });
        else f([](int) { return 1.0; });
    } else if (per == FormulaPer::length) f([&](int k) { return Map::element(rod, k).rest_length; });
    else if (per == FormulaPer::mass) f([&](int k) { return Map::density(rod) * Map::element(rod, k).volume; });
    else f([&, share = 1.0 / Map::length(rod)](int k) { return share * Map::element(rod, k).rest_length; });
}

template <int W, class Map> void FormulaLoad::add_uniform_force(const RodTile<W>& rod, const TileData<W>& data,
                                                                SlotLoad<W>* load, const Vec3d& force) const {
    constexpr Vec3d none{-0.0, -0.0, -0.0}; // changes no bit of any sum
    if (at == FormulaAt::start) return Map::add_to_ends(rod, load, force, none);
    if (at == FormulaAt::end) return Map::add_to_ends(rod, load, none, force);
    const auto f = broadcast<W>(force);
    with_node_weight<W, Map>(
        rod, data, [&](auto weight) __attribute__((always_inline)) {
            for (int i = 0; i <= rod.last; ++i) load[i].force = fma(Pack<W>(weight(i)), f, load[i].force);
        });
}

template <int W, class Map> void FormulaLoad::add_forces(const RodTile<W>& rod, const TileData<W>& data,
                                                         SlotLoad<W>* load, const Step& step) const {
    using P = Pack<W>;
    const bool one_end = at != FormulaAt::rod && !Map::along;
    const int begin = one_end && at == FormulaAt::end ? rod.last : 0, end = one_end ? begin + 1 : rod.last + 1;
    FormulaRun<W> run(force_, data.force, step.slot);
    const int strip = run.strip_of(end - begin);
    for (int first = begin; first < end; first += strip) {
        const int count = std::min(strip, end - first);
        run.at_nodes(rod, first, count);
        const Strided<W> x = run[0], y = run[1], z = run[2];
        with_node_weight<W, Map>(
            rod, data, [&](auto weight) __attribute__((always_inline)) {
                for (int i = 0; i < count; ++i) {
                    Vec3<P>& f = load[first + i].force;
                    const P w(weight(first + i));
                    const Vec3<P> value{x[i], y[i], z[i]};
                    // Values may be NaN where there is no node.
                    if constexpr (Map::along) f = select(w > P(0.0), fma(w, value, f), f);
                    else f = fma(w, value, f);
                }
            });
    }
}

template <int W, class Map, class F>
SKEIN_INLINE void FormulaLoad::add_element_couples(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load,
                                                   int first, int last, F couple_of) const {
    using P = Pack<W>;
    with_element_weight<W, Map>(
        rod, data, [&](auto weight) __attribute__((always_inline)) {
            for (int k = first; k < last; ++k) {
                const P w(weight(k));
                Vec3<P> c = couple_of(k);
                if (frame == LoadFrame::lab) c = rod.slot[k].director * c;
                Vec3<P>& sum = load[k].couple;
                if constexpr (Map::along)
                    sum = select((w > P(0.0)) & (Map::element(rod, k).absent < P(0.5)), fma(w, c, sum), sum);
                else sum = fma(w, c, sum);
            }
        });
}

template <int W, class Map> void FormulaLoad::add_couples(const RodTile<W>& rod, const TileData<W>& data,
                                                          SlotLoad<W>* load, const Step& step) const {
    FormulaRun<W> run(couple_, data.couple, step.slot);
    const auto [begin, end] = elements_of<W, Map>(rod);
    const int strip = run.strip_of(end - begin);
    for (int first = begin; first < end; first += strip) {
        const int count = std::min(strip, end - first);
        run.template at_middles<Map>(rod, first, count);
        const Strided<W> x = run[0], y = run[1], z = run[2];
        add_element_couples<W, Map>(rod, data, load, first, first + count, [&](int k) {
            return Vec3<Pack<W>>{x[k - first], y[k - first], z[k - first]};
        });
    }
}

template <int W, class Map> void FormulaLoad::add_uniform_couple(const RodTile<W>& rod, const TileData<W>& data,
                                                                 SlotLoad<W>* load, const Vec3d& couple) const {
    const auto [begin, end] = elements_of<W, Map>(rod);
    add_element_couples<W, Map>(rod, data, load, begin, end, [c = broadcast<W>(couple)](int) { return c; });
}

} // namespace skein
