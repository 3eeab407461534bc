// Total force distributed evenly along each rod, by rest length. theory.md (31)
//   f_i += F (l_{i-1} + l_i)/(2L)                  [N] lab, at nodes
// Cost: 8 flop per node.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"

namespace skein {

struct UniformForce {
    static constexpr std::string_view kind = "uniform_force";
    static constexpr bool ignores_motion = true;
    Vec3d force{0, 0, 0}; ///< total on each rod, N, lab
    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "force", .unit = "N", .text = "total force on each rod, lab frame", .required = true}, force);
        ramp.fields(f);
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        const auto f = broadcast<W>(force);
        const auto per_length = ramp.at(step.time) / Map::length(rod);
        for (int i = 0; i <= rod.last; ++i)
            load[i].force = fma(Pack<W>(per_length * Map::node_length(rod, i)), f, load[i].force);
    }
};

} // namespace skein
