// Total couple, fixed in the lab, distributed evenly along each rod, by rest length. theory.md (32)
//   c_k += Q_k C l_k/L        [N m] body, at element k
// Cost: 12 fma per element.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"

namespace skein {

struct UniformCouple {
    static constexpr std::string_view kind = "uniform_couple";
    Vec3d couple{0, 0, 0}; ///< total on each rod, N m, lab
    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "couple", .unit = "N m", .text = "total couple on each rod, lab frame", .required = true},
                couple);
        ramp.fields(f);
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        const auto c = broadcast<W>(couple);
        const auto per_length = ramp.at(step.time) / Map::length(rod);
        for (int k = 0; k < rod.n; ++k)
            load[k].couple =
                fma(Pack<W>(per_length * Map::element(rod, k).rest_length), rod.slot[k].director * c, load[k].couple);
    }
};

} // namespace skein
