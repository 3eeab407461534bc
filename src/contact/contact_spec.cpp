#include "contact/contact_spec.hpp"

namespace skein {

void ContactSpec::fields(FieldVisitor& f) {
    law.fields(f);
    f.visit({.name = "self", .unit = "", .text = "rods touch themselves too"}, self);
    f.visit({.name = "self_gap",
             .unit = "m",
             .text = "elements of one rod nearer than this along it, round a ring either way, never touch, nor do "
                     "those of two joined rods whose way over the joint is shorter; 0: half the way round the section",
             .at_least = 0},
            self_gap);
    f.visit({.name = "joined",
             .unit = "",
             .text = "rods and bodies that joints connect, and all of one copy of an assembly, touch each other, but "
                     "for elements nearer to a joint than `self_gap`; false: they never touch"},
            joined);
    f.visit({.name = "overlap",
             .unit = "-",
             .text = "over the diameter: the largest that the limit of the time step allows for",
             .above = 0,
             .at_most = 1},
            overlap);
    f.visit({.name = "allow_overlap",
             .unit = "",
             .text = "rods and bodies may overlap at the start by more than `overlap`, and are pushed apart as the law "
                     "says; elements "
                     "that never touch, and those whose law has soft_until, may without it; bodies whose axes begin "
                     "nearer than half "
                     "the sum of radii may pass each other until they have come apart that far"},
            allow_overlap);
}

void ContactPair::fields(FieldVisitor& f) {
    f.visit({.name = "between", .unit = "", .text = "two groups, or one twice", .required = true}, between);
    law.fields(f);
}

} // namespace skein
