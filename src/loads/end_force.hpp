// Forces on the two end nodes, fixed in the lab or in the axes of the end elements (followers), with a ramp. theory.md
// (33)
//   f_0 += r(t) F_start,              f_n += r(t) F_end                  [N] lab; F lab
//   f_0 += r(t) Q_0^T F_start,        f_n += r(t) Q_{n-1}^T F_end        [N] lab; F body
#pragma once

#include "loads/load_frame.hpp"
#include "skein/core/fields.hpp"
#include "skein/loads/load.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"

namespace skein {

struct EndForce {
    static constexpr std::string_view kind = "end_force", label = "end forces";
    static constexpr bool for_rigid_bodies = false, for_rings = false;
    Vec3d start{0, 0, 0};             ///< N, on node 0
    Vec3d end{0, 0, 0};               ///< N, on node n
    LoadFrame frame = LoadFrame::lab; ///< axes of `start` and `end`
    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "start", .unit = "N", .text = "force on the first node"}, start);
        f.visit({.name = "end", .unit = "N", .text = "force on the last node"}, end);
        f.choice({.name = "frame",
                  .text = "axes of `start` and `end`; body axes turn with the end elements (follower forces)"},
                 frame, load_frame_names);
        ramp.fields(f);
    }
    void check(RodSpecs, Objections& objections) const {
        if (zero(start) && zero(end)) objections.add("", "an end_force needs 'start' or 'end' [N]: both are 0");
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        const double r = ramp.at(step.time);
        if (frame == LoadFrame::lab) return Map::add_to_ends(rod, load, r * start, r * end);
        add_follower<Map>(rod, load, false, r * start);
        add_follower<Map>(rod, load, true, r * end);
    }

private:
    template <class Map, int W>
    static void add_follower(const RodTile<W>& rod, SlotLoad<W>* load, bool last, const Vec3d& force) {
        if constexpr (Map::along) {
            for (const LaneRange& range : rod.strands->ranges()) {
                const int elements = range.group->elements();
                const auto [at, of] = rod.strands->place(range.lane, last ? elements - 1 : 0);
                const auto [row, l] = rod.strands->place(range.lane, last ? elements : 0);
                const Vec3d f = transpose_times(lane(rod.slot[at].director, of), force);
                set_lane(load[row].force, l, lane(load[row].force, l) + f);
            }
        } else {
            load[last ? rod.n : 0].force +=
                transpose_times(rod.slot[last ? rod.n - 1 : 0].director, broadcast<W>(force));
        }
    }
};

} // namespace skein
