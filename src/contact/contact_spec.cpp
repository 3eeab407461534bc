#include "contact/contact_spec.hpp"

namespace skein {

void ContactSpec::fields(FieldVisitor& f) {
    law.fields(f);
    f.visit({.name = "self", .unit = "", .text = "true: a rod may also touch itself"}, self);
    f.visit(
        {.name = "self_gap",
         .unit = "m",
         .text =
             "elements of one rod closer than this along the rod (on a ring, either way) never touch; the same holds "
             "for elements of two joined rods, along the path over the joint; 0: half the circumference of the section",
         .at_least = 0},
        self_gap);
    f.visit({.name = "joined",
             .unit = "",
             .text = "true: rods and bodies connected by joints, or in one copy of an assembly, may touch each other, "
                     "except elements closer to a joint than `self_gap`; false: they never touch"},
            joined);
    f.visit({.name = "overlap",
             .unit = "-",
             .text = "largest overlap, over the diameter, allowed for in the limit of the time step",
             .above = 0,
             .at_most = 1},
            overlap);
    f.visit({.name = "allow_overlap",
             .unit = "",
             .text =
                 "true: rods and bodies may overlap at the start by more than `overlap`; the contact law pushes them "
                 "apart. Elements that never touch, or with soft_until, need no such permission. Bodies whose axes "
                 "start closer than half the sum of their radii may pass each other until they are that far apart"},
            allow_overlap);
}

void ContactPair::fields(FieldVisitor& f) {
    f.visit({.name = "between", .unit = "", .text = "two groups, or one group twice", .required = true}, between);
    law.fields(f);
}

} // namespace skein
