// Numbers for a person to type: two digits, rounded to a given side.
#pragma once

namespace skein {

/// Largest number of two digits that is not above x > 0, and smallest that is not below; to 1e-12.
double rounded_down(double x);
double rounded_up(double x);

} // namespace skein
