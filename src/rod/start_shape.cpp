#include "skein/rod/start_shape.hpp"

#include "core/fused.hpp"
#include "core/rotation.hpp"
#include "rod/sections.hpp"
#include "skein/core/error.hpp"
#include "skein/rod/rod_group.hpp"

#include <fmt/format.h>

#include <numbers>

namespace skein {

namespace {

Vec3d start_curvature_at(const Shape& shape, long k) {
    if (!shape.start_curvature_profile.empty()) return nth(shape.start_curvature_profile, k);
    return shape.start_curvature ? *shape.start_curvature : rest_curvature_at(shape, k);
}

/// Frame q after a piece of this curvature and length. A straight piece leaves the lab's axes as they are, which saves
/// most of the work for a million rods that are turned one by one.
Quaterniond bent(const Quaterniond& q, const Vec3d& curvature, double length) {
    return same_bits(q, no_turn) && zero(curvature) ? q : rotation(length * curvature) * q;
}

void require_closed(const RodSpec& spec, double gap, double misfit) {
    if (gap <= 1e-6 && misfit <= 1e-6) return;
    throw InputError(fmt::format("{}: the ring '{}' does not close: its ends are {:.3g} of its length apart and turned "
                                 "by {:.3g} rad; a circle has the curvature 2 pi/length = {:.9g} 1/m",
                                 spec.source, spec.name, gap, misfit, 2 * std::numbers::pi / spec.shape.length));
}

} // namespace

SKEIN_FUSED void StartShape::lay_out(const RodGroup& group) {
    const RodSpec& spec = group.spec();
    const Shape& shape = spec.shape;
    const std::size_t n = group.element.size();
    offsets.clear();
    offsets.reserve(n + 1);
    directors.clear();
    directors.reserve(n);
    // A weighted cell is turned by kappa D_w.
    const auto bent_at_node = [&](const Quaterniond& q, std::size_t i, const Vec3d& curvature, double length) {
        return bent(q, curvature, cell_weight(group, i) * length);
    };
    const Vec3d stretch = shape.rest_strain + Vec3d{0, 0, 1};
    Quaterniond q =
        bent_at_node(group.frame(), 0, start_curvature_at(shape, 0), 0.5 * group.element.front().rest_length);
    Vec3d x{0, 0, 0}, sum{0, 0, 0};
    for (std::size_t k = 0; k < n; ++k) {
        if (k > 0)
            q = bent_at_node(q, k, start_curvature_at(shape, static_cast<long>(k) - 1),
                             1 / group.voronoi[k - 1].inv_length);
        directors.push_back(q);
        offsets.push_back(x);
        sum += x;
        x += group.element[k].rest_length * (same_bits(q, no_turn) ? stretch : transpose_times(q, stretch));
    }
    offsets.push_back(x);
    centre = (1 / static_cast<double>(n + 1)) * (sum + x);
    end_frame =
        bent_at_node(q, n, start_curvature_at(shape, shape.elements - 2), 0.5 * group.element.back().rest_length);
    if (!shape.closed) return;
    const Quaterniond joined =
        bent(q, start_curvature_at(shape, shape.elements - 1), 1 / group.voronoi.back().inv_length);
    require_closed(spec, norm(x) / shape.length, norm(relative_rotation(joined, directors.front())));
    offsets.back() = offsets.front();
}

} // namespace skein
