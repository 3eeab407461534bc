// Couples on the first and last elements, fixed in the lab or in the element's axes (a follower), with a ramp.
// theory.md (33a)
//   c_0 += r(t) Q_0 C_start,  c_{n-1} += r(t) Q_{n-1} C_end        [N m] body; C lab
//   c_0 += r(t) C_start,      c_{n-1} += r(t) C_end                [N m] body; C body
// The couple acts at the element's middle, as a free end has no half cell that it could bend. Turns of elements and
// curvatures of cells are those of the moment C all along the rod.
#pragma once

#include "loads/load_frame.hpp"
#include "skein/core/fields.hpp"
#include "skein/loads/load.hpp"
#include "skein/loads/ramp.hpp"
#include "skein/tiles/mapping.hpp"

namespace skein {

struct EndCouple {
    static constexpr std::string_view kind = "end_couple", label = "end couples";
    static constexpr bool for_rigid_bodies = false, for_rings = false;
    Vec3d start{0, 0, 0};             ///< N m, on element 0
    Vec3d end{0, 0, 0};               ///< N m, on element n - 1
    LoadFrame frame = LoadFrame::lab; ///< axes of `start` and `end`
    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "start", .unit = "N m", .text = "couple on the first element"}, start);
        f.visit({.name = "end", .unit = "N m", .text = "couple on the last element"}, end);
        f.choice(
            {.name = "frame", .text = "axes of `start` and `end`; body axes turn with the element (a follower couple)"},
            frame, load_frame_names);
        ramp.fields(f);
    }
    void check(RodSpecs, Objections& objections) const {
        if (zero(start) && zero(end)) objections.add("", "an end_couple needs 'start' or 'end' [N m]: both are 0");
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        const double r = ramp.at(step.time);
        add_to<Map>(rod, load, false, r * start);
        add_to<Map>(rod, load, true, r * end);
    }

private:
    template <class Map, int W>
    void add_to(const RodTile<W>& rod, SlotLoad<W>* load, bool last, const Vec3d& couple) const {
        if constexpr (Map::along) {
            for (const LaneRange& range : rod.strands->ranges()) {
                const auto [row, l] = rod.strands->place(range.lane, last ? range.group->elements() - 1 : 0);
                const Vec3d c = frame == LoadFrame::lab ? lane(rod.slot[row].director, l) * couple : couple;
                set_lane(load[row].couple, l, lane(load[row].couple, l) + c);
            }
        } else {
            const int k = last ? rod.n - 1 : 0;
            const auto c = broadcast<W>(couple);
            load[k].couple += frame == LoadFrame::lab ? rod.slot[k].director * c : c;
        }
    }
};

} // namespace skein
