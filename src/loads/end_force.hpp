// Dead forces on the two end nodes, with a ramp. theory.md (33)
//   f_0 += r(t) F_start,  f_n += r(t) F_end        [N] lab
#pragma once

#include "skein/core/fields.hpp"
#include "skein/loads/load.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"

namespace skein {

struct EndForce {
    static constexpr std::string_view kind = "end_force", label = "end forces";
    static constexpr bool for_rigid_bodies = false, for_rings = false;
    Vec3d start{0, 0, 0}; ///< N, lab, on node 0
    Vec3d end{0, 0, 0};   ///< N, lab, on node n
    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "start", .unit = "N", .text = "force on the first node, lab frame"}, start);
        f.visit({.name = "end", .unit = "N", .text = "force on the last node, lab frame"}, end);
        ramp.fields(f);
    }
    void check(RodSpecs, Objections& objections) const {
        if (zero(start) && zero(end)) objections.add("", "an end_force needs 'start' or 'end' [N]: both are 0");
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        const double r = ramp.at(step.time);
        Map::add_to_ends(rod, load, r * start, r * end);
    }
};

} // namespace skein
