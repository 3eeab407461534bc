// Couple of a uniform, rotating magnetic field on rods magnetised in their material. theory.md (34)-(35)
//   b(t) = r(t) ( B0 + B (u sin wt + v cos wt) )        [T] lab, w = 2 pi/T; r(t) rises from `onset` and falls from
//                                                       `until`
//   c_k += V_k m_k x Q_k b(t)                           [N m] body; m_k = M Q_k(0) m_hat, fixed in the body [A/m]
// Source: Gu et al. 2020 (Nat. Commun. 11, 2637), Methods. Cost: 45 flop per element.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace skein {

struct MagneticField {
    static constexpr std::string_view kind = "magnetic_field", label = "magnetics";
    Vec3d constant{0, 0, 0};    ///< B0, T, lab
    double rotating = 0;        ///< B, T
    Vec3d sine_axis{1, 0, 0};   ///< u, lab
    Vec3d cosine_axis{0, 0, 1}; ///< v, lab
    double period = 0;          ///< T, s; negative turns the other way
    Ramp ramp;
    double until = 0; ///< s; 0: the field stays

    void fields(FieldVisitor& f) {
        f.visit({.name = "constant", .unit = "T", .text = "B0, constant part, lab frame"}, constant);
        f.visit({.name = "rotating", .unit = "T", .text = "B, strength of the rotating part", .at_least = 0}, rotating);
        f.visit(
            {.name = "sine_axis", .unit = "-", .text = "first axis, u; the rotating part is B (u sin wt + v cos wt)"},
            sine_axis);
        f.visit({.name = "cosine_axis", .unit = "-", .text = "second axis, v"}, cosine_axis);
        f.visit({.name = "period", .unit = "s", .text = "2 pi/w; a negative period reverses the rotation"}, period);
        ramp.fields(f);
        f.visit({.name = "until",
                 .unit = "s",
                 .text = "time at which the field begins to fall; 0: it stays",
                 .at_least = 0},
                until);
    }
    static bool acts_on(const RodSpec& rods) { return rods.magnetisation.pattern != MagnetisationPattern::none; }
    void check(RodSpecs groups, Objections& objections) const {
        if (until > 0 && until <= ramp.onset)
            objections.add("until", "'until' " + number_text(until) + " s is not after 'onset' " +
                                        number_text(ramp.onset) + " s");
        if (!groups.empty() &&
            std::none_of(groups.begin(), groups.end(), [](const RodSpec* rods) { return acts_on(*rods); }))
            objections.add("", "none of the groups that this magnetic_field acts on has a [rods.magnetisation]");
        if (rotating == 0) {
            if (zero(constant)) objections.add("", "a magnetic_field needs 'constant' or 'rotating' [T]: both are 0");
            // A period is optional: rotating = 0 switches the rotation off and leaves other keys as they are.
            if (!objections.given("rotating"))
                objections.unused({"period", "sine_axis", "cosine_axis"}, "in a field without 'rotating' [T]");
            return;
        }
        if (period == 0) objections.add("", "a rotating field needs 'period' [s], not 0");
        if (zero(sine_axis) && zero(cosine_axis))
            objections.add("sine_axis", "'sine_axis' and 'cosine_axis' are both 0: the field would not rotate");
    }

    /// r(t).
    double share(double time) const {
        if (until > 0 && time > until)
            return ramp.duration > 0 ? 1 - ramp_at(time - until, ramp.duration, ramp.shape) : 0;
        return ramp.at(time);
    }
    /// b(t), T, lab.
    Vec3d at(double time) const {
        Vec3d b = constant;
        if (rotating != 0 && period != 0) {
            const double angle = 2 * std::numbers::pi / period * time;
            b += rotating * (std::sin(angle) * sine_axis + std::cos(angle) * cosine_axis);
        }
        return share(time) * b;
    }

    /// Computes b for the steps of a batch: sine and cosine once a step, not once a tile.
    void prepare(std::span<const Step> steps) {
        for (const Step& s : steps) field[s.slot] = at(s.time);
    }
    Vec3d field[Clock::largest_batch];

    /// m_k of a tile's rods: one per element, or a single one where the start shape is straight (stride 0).
    template <int W> struct TileData {
        AlignedVector<Vec3<Pack<W>>> moment;
        int stride = 0;
    };
    template <int W> TileData<W> bind(const RodTile<W>& rod) const {
        bool straight = true;
        for (int i = 0; i < lanes_of<W>; ++i) {
            const auto start = rod.group_of(i).start_directors();
            for (const Quaterniond& q : start) straight = straight && same_bits(q, start[0]);
        }
        TileData<W> data;
        data.stride = straight ? 0 : 1;
        data.moment.resize(straight ? 1 : to_index(rod.n));
        for (int k = 0; k < static_cast<int>(data.moment.size()); ++k)
            for (int i = 0; i < lanes_of<W>; ++i) {
                const RodGroup& group = rod.group_of(i);
                const Quaterniond start = group.start_director(rod.index_of(i), to_index(rod.element_of(i, k)));
                set_lane(nth(data.moment, k), i,
                         group.magnetisation_strength(rod.index_of(i)) *
                             (start * group.magnetisation(rod.index_of(i))));
            }
        return data;
    }

    template <int W, class Map = Across<W>>
    void add(const RodTile<W>& rod, const TileData<W>& data, SlotLoad<W>* load, const Step& step) const {
        const auto b = broadcast<W>(field[step.slot]);
        const Vec3<Pack<W>>* m = data.moment.data();
        for (int k = 0; k < rod.n; ++k, m += data.stride)
            load[k].couple =
                fma(Pack<W>(Map::element(rod, k).volume), cross(*m, rod.slot[k].director * b), load[k].couple);
    }
};

} // namespace skein
