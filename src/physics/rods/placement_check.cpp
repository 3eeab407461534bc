#include "physics/rods/placement_check.hpp"

#include "physics/table_objections.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace skein {

namespace {

void counts_and_spacing(const Placement& p, Objections& objections, const std::string& where, std::size_t fewest,
                        std::size_t most) {
    const std::size_t n = p.counts.size();
    const std::string needed =
        fewest == most ? fmt::format("{} value", fewest) : fmt::format("{} or {} values", fewest, most);
    if (n < fewest || n > most)
        objections.add("counts", fmt::format("'counts' needs {} {}, and has {}", needed, where, n));
    else if (p.spacing.size() != n)
        objections.add("spacing",
                       fmt::format("'spacing' needs one value per count, {} in all, and has {}", n, p.spacing.size()));
}

/// Faults of a list whose rods have directions of their own.
void directions(const Placement& p, Objections& objections) {
    if (!p.tangents.empty()) {
        objections.unused({"tangent", "normal"}, "beside 'tangents'");
        objections.length("tangents", p.tangents.size(), static_cast<long>(p.origins.size()),
                          "one for each of 'origins'");
    }
    for (std::size_t i = 0; i < p.tangents.size(); ++i)
        if (zero(p.tangents[i])) return objections.add(fmt::format("tangents.{}", i), "a tangent without direction");
    if (p.normals.empty()) return;
    if (p.tangents.empty()) return objections.add("normals", "'normals' has no use without 'tangents'");
    objections.length("normals", p.normals.size(), static_cast<long>(p.tangents.size()), "one for each of 'tangents'");
    for (std::size_t i = 0; i < std::min(p.normals.size(), p.tangents.size()); ++i)
        if (zero(p.normals[i]) || parallel(p.tangents[i], p.normals[i]))
            return objections.add(fmt::format("normals.{}", i),
                                  "a normal that has no direction, or that of its tangent");
}

/// Packed rods start straight, each in a frame of its own.
void packing(const RodSpec& rods, Objections& objections, const std::string& where) {
    const Packing& p = rods.placement.packing;
    if (p.count == 0) objections.add("", fmt::format("'count', the number of rods, is needed {}", where));
    const Shape& s = rods.shape;
    const bool curved =
        !s.start_curvature_profile.empty() ||
        (s.start_curvature ? !zero(*s.start_curvature) : !zero(s.rest_curvature) || !s.rest_curvature_profile.empty());
    if (s.closed || curved || !zero(s.rest_strain))
        objections.add("", fmt::format("the rods must start straight, without rest_strain, {}: curved ones can with "
                                       "start_curvature = [0, 0, 0]",
                                       where));
    for (const auto& [key, range] : {std::pair{"elevation", &p.elevation}, std::pair{"azimuth", &p.azimuth}})
        if (range->size() != 2 || (*range)[0] > (*range)[1])
            objections.add(key, fmt::format("'{}' needs two angles, the least and the largest", key));
    if (p.region == PackingRegion::cylinder) {
        objections.unused({"lower", "upper"}, "for the region \"cylinder\"");
        if (p.radius == 0 || p.height == 0)
            objections.add("", "'radius' and 'height' [m] are needed for the region \"cylinder\"");
        return;
    }
    const std::string region = fmt::format("for the region \"{}\"", nth(packing_region_names, p.region));
    objections.unused({"point", "radius", "height"}, region);
    if (!(p.upper.x > p.lower.x && p.upper.y > p.lower.y && (p.region == PackingRegion::slab || p.upper.z > p.lower.z)))
        objections.add(objections.given("upper") ? "upper" : "",
                       fmt::format("'upper' must lie beyond 'lower' {}", region));
}

} // namespace

void check_placement(const RodSpec& rods, Objections& of_group) {
    TableObjections objections(of_group, "placement");
    const Placement& p = rods.placement;
    if (zero(p.tangent)) objections.add("tangent", "'tangent' has no direction");
    else if (p.normal && zero(*p.normal)) objections.add("normal", "'normal' has no direction");
    else if (p.normal && parallel(p.tangent, *p.normal))
        objections.add("normal", "'tangent' and 'normal' are parallel; d1 needs a direction across the rod");
    const std::string where = fmt::format("for a placement of kind \"{}\"", nth(placement_names, p.kind));
    if (p.kind != PlacementKind::file) objections.unused({"unit", "id", "ignore", "trace"}, where);
    if (p.kind != PlacementKind::lattice) objections.unused({"stagger"}, where);
    if (p.kind != PlacementKind::packing)
        objections.unused({"count", "seed", "region", "lower", "upper", "point", "radius", "height", "elevation",
                           "azimuth", "elevation_law", "gap", "attempts"},
                          where);
    switch (p.kind) {
    case PlacementKind::single:
        objections.unused({"counts", "spacing", "file", "origins", "tangents", "normals"}, where);
        break;
    case PlacementKind::line:
        objections.unused({"file", "origins", "tangents", "normals"}, where);
        counts_and_spacing(p, objections, where, 1, 1);
        break;
    case PlacementKind::lattice:
        objections.unused({"file", "origins", "tangents", "normals"}, where);
        counts_and_spacing(p, objections, where, 2, 3);
        break;
    case PlacementKind::mask:
        objections.unused({"counts", "origins", "tangents", "normals"}, where);
        if (p.file.empty()) objections.add("", fmt::format("'file', the bitmap, is needed {}", where));
        if (p.spacing.size() != 2)
            objections.add("spacing", fmt::format("'spacing' needs 2 values {}, and has {}", where, p.spacing.size()));
        break;
    case PlacementKind::list:
        objections.unused({"counts", "spacing", "file"}, where);
        if (p.origins.empty()) objections.add("", fmt::format("'origins' are needed {}", where));
        directions(p, objections);
        break;
    case PlacementKind::file:
        objections.unused({"counts", "spacing", "origins", "tangents", "normals"}, where);
        if (p.file.empty()) objections.add("", fmt::format("'file', with a row per rod, is needed {}", where));
        break;
    case PlacementKind::packing:
        objections.unused(
            {"origin", "tangent", "normal", "counts", "spacing", "file", "origins", "tangents", "normals"}, where);
        packing(rods, objections, where);
        break;
    }
}

} // namespace skein
