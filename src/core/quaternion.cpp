#include "skein/core/quaternion.hpp"

#include <cmath>

namespace skein {

Quaterniond quaternion(const Mat3d& q) {
    // The largest of 4 w^2 and 4 v_i^2 is at least 1, so that no divisor suffers cancellation.
    const double trace = q.d1.x + q.d2.y + q.d3.z;
    Quaterniond r;
    if (trace >= 0) {
        r = {1 + trace, {q.d2.z - q.d3.y, q.d3.x - q.d1.z, q.d1.y - q.d2.x}};
    } else if (q.d1.x >= q.d2.y && q.d1.x >= q.d3.z) {
        r = {q.d2.z - q.d3.y, {1 + q.d1.x - q.d2.y - q.d3.z, q.d1.y + q.d2.x, q.d1.z + q.d3.x}};
    } else if (q.d2.y >= q.d3.z) {
        r = {q.d3.x - q.d1.z, {q.d1.y + q.d2.x, 1 + q.d2.y - q.d1.x - q.d3.z, q.d2.z + q.d3.y}};
    } else {
        r = {q.d1.y - q.d2.x, {q.d1.z + q.d3.x, q.d2.z + q.d3.y, 1 + q.d3.z - q.d1.x - q.d2.y}};
    }
    const double scale = (r.w < 0 ? -1 : 1) / std::sqrt(dot(r, r));
    return {scale * r.w, scale * r.v};
}

} // namespace skein
