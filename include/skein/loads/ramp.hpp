// Linear ramp that loads share: 0 at t = 0, 1 from t = duration on (1 throughout for duration 0).
#pragma once

#include <algorithm>

namespace skein {

inline double ramp_at(double time, double duration) { return duration > 0 ? std::min(1.0, time / duration) : 1.0; }

} // namespace skein
