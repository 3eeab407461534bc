#include "physics/rods/body_check.hpp"

#include "physics/rods/placement_check.hpp"
#include "physics/table_objections.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace skein {

namespace {

void parts(const BodySpec& body, Objections& of_body) {
    TableObjections spheres(of_body, "spheres"), capsules(of_body, "capsules"), boxes(of_body, "boxes");
    const auto of_each = [](TableObjections& table, const char* key, std::size_t has, std::size_t needs) {
        table.length(key, has, static_cast<long>(needs), "one for each of 'radii'");
    };
    const SphereParts& s = body.spheres;
    if (s.radii.size() != 1 || !s.centres.empty()) of_each(spheres, "centres", s.centres.size(), s.radii.size());
    const CapsuleParts& c = body.capsules;
    of_each(capsules, "from", c.from.size(), c.radii.size());
    of_each(capsules, "to", c.to.size(), c.radii.size());
    const BoxParts& b = body.boxes;
    if (b.radii.size() != 1 || !b.centres.empty()) of_each(boxes, "centres", b.centres.size(), b.radii.size());
    of_each(boxes, "sizes", b.sizes.size(), b.radii.size());
    for (std::size_t i = 0; i < std::min(b.sizes.size(), b.radii.size()); ++i)
        if (const Vec3d& size = b.sizes[i]; !(std::min({size.x, size.y, size.z}) >= 2 * b.radii[i]))
            boxes.add(fmt::format("sizes.{}", i),
                      fmt::format("a box of {} x {} x {} m has no room for edges of radius {} m: no side may be "
                                  "shorter than twice that",
                                  size.x, size.y, size.z, b.radii[i]));
    if (s.radii.empty() && c.radii.empty() && b.radii.empty())
        of_body.add("", "a body needs parts: give 'radii' of [bodies.spheres], [bodies.capsules] or [bodies.boxes]");
}

} // namespace

void check_body(const RodSpec& spec, Objections& objections) {
    const BodySpec& body = *spec.body;
    if (spec.material.density == 0 && body.mass == 0)
        objections.add("", "a body needs 'density' [kg/m^3] or 'mass' [kg] above 0");
    if (spec.material.density > 0 && body.mass > 0)
        objections.add("mass", "'mass' has no use beside 'density', which says it");
    if (const std::size_t n = body.inertia.size(); n != 0 && n != 3 && n != 6)
        objections.add(
            "inertia",
            fmt::format(
                "'inertia' needs 3 numbers, J_xx, J_yy and J_zz, or 6, these and J_xy, J_xz and J_yz, and has {}", n));
    parts(body, objections);
    if (spec.placement.kind == PlacementKind::file)
        TableObjections(objections, "placement").add("kind", "bodies are not placed by a file: use a list");
    check_placement(spec, objections);
}

} // namespace skein
