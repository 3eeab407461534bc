// A total force shared evenly along each rod, by rest length.                      theory.md (31)
//   f_k += F l_k/(2L),  f_{k+1} += F l_k/(2L)      [N] lab, at the two nodes of element k
// Cost: 6 fma per element.
#pragma once

#include "core/fields.hpp"
#include "loads/ramp.hpp"
#include "rod/tile.hpp"

namespace skein {

struct UniformForce {
    static constexpr std::string_view kind = "uniform_force";
    Vec3d force{0, 0, 0}; ///< total on each rod, N, lab
    double ramp = 0;      ///< s

    void fields(FieldVisitor& f) {
        f.visit({.name = "force", .unit = "N", .text = "total force on each rod, lab frame", .required = true}, force);
        f.visit({.name = "ramp", .unit = "s", .text = "linear rise from 0", .at_least = 0}, ramp);
    }

    template <int W> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        const double per_length = 0.5 * ramp_at(step.time, ramp) / rod.group->spec().shape.length;
        for (int k = 0; k < rod.n; ++k) {
            const auto half = broadcast<W>((per_length * rod.element[k].rest_length) * force);
            load[k].force += half;
            load[k + 1].force += half;
        }
    }
};

} // namespace skein
