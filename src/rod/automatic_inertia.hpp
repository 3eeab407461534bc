// Rotary inertia that lengthens the step of thin rods and costs less accuracy than their elements do already.
// theory.md, end of section 9
#pragma once

#include "skein/rod/rod_spec.hpp"

namespace skein {

struct AutomaticInertia {
    double dt = 0;        ///< s: number of `rotary_inertia_for_dt`; 0: rotary inertia does not limit the step
    double gain = 1;      ///< longest step over that without, by the modes of a rod alone
    double share = 0;     ///< largest change of the two lowest bending frequencies of each plane, over their error
    int highest = 0;      ///< number of the highest bending mode that is right to 1 %, with this inertia; 0: none
    double frequency = 0; ///< up to which bending is right to 1 %, Hz
};

/// The number that "auto" stands for, for rods of this spec, whose own is not looked at. Formulas along the rod must
/// have been read.
AutomaticInertia automatic_inertia(const RodSpec& spec);

/// The same rod with other elements: lengths, sections, curvatures and held parts are taken along it.
RodSpec with_elements(RodSpec spec, long elements);

} // namespace skein
