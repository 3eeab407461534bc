// Numbers to be typed in: two digits, on the side that is asked for.
#pragma once

namespace skein {

/// The largest number of two digits that is not above x > 0, and the smallest that is not below; to 1e-12.
double rounded_down(double x);
double rounded_up(double x);

} // namespace skein
