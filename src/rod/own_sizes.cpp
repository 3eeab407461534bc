#include "rod/own_sizes.hpp"

namespace skein {

void put_sizes(const Places& places, const RodSpec& spec, std::int64_t i, RodSpec& own) {
    const double r = places.radius(i, spec.section.radius);
    own.shape.length = places.length(i, spec.shape.length);
    own.section.radius = r;
    own.section.radius_2 = spec.section.radius_2 * (r / spec.section.radius);
    if (const std::span lengths = places.element_lengths(i); !lengths.empty()) {
        own.shape.length_profile.assign(lengths.begin(), lengths.end());
        const bool at_start = spec.placement.trace == Trace::start;
        places.put_curvatures(i, at_start ? own.shape.start_curvature_profile : own.shape.rest_curvature_profile);
    }
    if (const std::span radii = places.element_radii(i); !radii.empty()) {
        own.section.profile.assign(radii.begin(), radii.end());
        for (double& factor : own.section.profile) factor /= r;
    }
}

} // namespace skein
