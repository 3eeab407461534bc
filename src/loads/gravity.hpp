// Weight. theory.md (30)
//   f_i += r(t) m_i g       [N] lab, at nodes; m_i the node's mass
// Cost: 3 fma per node.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"

namespace skein {

struct Gravity {
    static constexpr std::string_view kind = "gravity";
    static constexpr bool ignores_motion = true;
    Vec3d acceleration{0, 0, -9.81}; ///< g, m/s^2, lab

    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "acceleration", .unit = "m/s^2", .text = "gravitational acceleration g, lab frame"},
                acceleration);
        ramp.fields(f);
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        const auto g = broadcast<W>(ramp.at(step.time) * acceleration);
        for (int i = 0; i <= rod.last; ++i) load[i].force = fma(Pack<W>(Map::node_mass(rod, i)), g, load[i].force);
    }
};

} // namespace skein
