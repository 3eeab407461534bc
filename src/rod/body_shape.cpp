#include "rod/body_shape.hpp"

#include "core/principal_axes.hpp"
#include "rod/solids.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace skein {

namespace {

[[noreturn]] void refuse(const RodSpec& spec, const std::string& fault) {
    throw InputError(fmt::format("{}: the body '{}': {}", spec.source, spec.name, fault));
}

/// Solids of all parts, whose surfaces are appended to `part` in the frame of the scene.
std::vector<Solid> add_parts(const BodySpec& body, std::vector<BodyShape::Part>& part) {
    std::vector<Solid> solids;
    const auto centre_of = [](const std::vector<Vec3d>& centres, std::size_t i) {
        return centres.empty() ? Vec3d{0, 0, 0} : centres[i];
    };
    for (std::size_t i = 0; i < body.spheres.radii.size(); ++i) {
        const Vec3d at = centre_of(body.spheres.centres, i);
        solids.push_back(solid_sphere(at, body.spheres.radii[i]));
        part.push_back({at, at, body.spheres.radii[i]});
    }
    for (std::size_t i = 0; i < body.capsules.radii.size(); ++i) {
        solids.push_back(solid_capsule(body.capsules.from[i], body.capsules.to[i], body.capsules.radii[i]));
        part.push_back({body.capsules.from[i], body.capsules.to[i], body.capsules.radii[i]});
    }
    for (std::size_t i = 0; i < body.boxes.radii.size(); ++i) {
        const double r = body.boxes.radii[i];
        const Vec3d at = centre_of(body.boxes.centres, i), half = 0.5 * body.boxes.sizes[i] - Vec3d{r, r, r};
        solids.push_back(solid_box(at, half, r));
        part.push_back({.from = at, .to = at, .radius = r, .half = half, .box = true});
    }
    return solids;
}

/// Volume, mass and centre of mass of a body.
void put_mass(BodyShape& shape, const RodSpec& spec, const std::vector<Solid>& solids) {
    Vec3d first{0, 0, 0};
    for (const Solid& s : solids) {
        shape.volume += s.volume;
        first += s.volume * s.centre;
    }
    shape.mass = spec.body->mass > 0 ? spec.body->mass : spec.material.density * shape.volume;
    if (!(shape.mass > 0) || !std::isfinite(shape.mass)) refuse(spec, fmt::format("its mass is {:g} kg", shape.mass));
    shape.centre = spec.body->centre.value_or((1 / shape.volume) * first);
}

/// Inertia about `centre`, kg m^2: `given` by a scene as J_xx, J_yy, J_zz and perhaps J_xy, J_xz, J_yz, or that of the
/// parts.
SymmetricMatrix inertia_of(const std::vector<double>& given, const std::vector<Solid>& solids, double mass,
                           double volume, const Vec3d& centre) {
    if (given.size() == 3) return {given[0], given[1], given[2]};
    if (given.size() == 6) return {given[0], given[1], given[2], given[3], given[4], given[5]};
    SymmetricMatrix j;
    for (const Solid& s : solids) {
        const double m = mass * (s.volume / volume);
        j += times(m, s.inertia);
        j += times(m, of_point(s.centre - centre));
    }
    return j;
}

void require_inertia(const RodSpec& spec, const Vec3d& v) {
    const auto require = [&](bool holds, const char* rule) {
        if (!holds)
            refuse(spec, fmt::format("its principal moments of inertia are {:g}, {:g} and {:g} kg m^2: {}", v.x, v.y,
                                     v.z, rule));
    };
    const double least = std::min({v.x, v.y, v.z}), most = std::max({v.x, v.y, v.z});
    require(least > 0, "all must be above 0");
    require(!(most > (v.x + v.y + v.z - most) * (1 + 1e-9)), "none may be larger than the other two together");
}

} // namespace

BodyShape::BodyShape(const RodSpec& spec) {
    const std::vector<Solid> solids = add_parts(*spec.body, part);
    put_mass(*this, spec, solids);
    const PrincipalAxes principal = principal_axes(inertia_of(spec.body->inertia, solids, mass, volume, centre));
    require_inertia(spec, principal.value);
    take_axes(principal.value, principal.axes);
    add_surface();
    for (const Point& p : point) reach = std::max(reach, norm(p.place) + p.radius);
}

void BodyShape::add_surface() {
    for (Part& p : part) {
        p.from = axes * (p.from - centre);
        p.to = axes * (p.to - centre);
        const int slot = 2 * static_cast<int>(&p - part.data());
        if (p.box) {
            p.axes = inverse(axes); // the frame of the parts
            add_corners_and_edges(p, slot);
            continue;
        }
        line.push_back({p.from, p.to, p.radius, slot});
        point.push_back({p.from, p.radius});
        if (norm(p.to - p.from) > 0) point.push_back({p.to, p.radius});
    }
}

BodyShape::Column BodyShape::column() const {
    Column c{HUGE_VAL, -HUGE_VAL, 0};
    for (const Point& p : point) {
        const Vec3d at = centre + transpose_times(axes, p.place);
        c.lowest = std::min(c.lowest, at.z);
        c.highest = std::max(c.highest, at.z);
        c.radius = std::max(c.radius, std::hypot(at.x, at.y) + p.radius);
    }
    return c;
}

void BodyShape::add_corners_and_edges(const Part& box, int slot) {
    const auto corner = [&](int bits) {
        const Vec3d at{bits & 1 ? box.half.x : -box.half.x, bits & 2 ? box.half.y : -box.half.y,
                       bits & 4 ? box.half.z : -box.half.z};
        return box.from + transpose_times(box.axes, at);
    };
    for (int bits = 0; bits < 8; ++bits) {
        const bool again =
            (bits & 1 && box.half.x == 0) || (bits & 2 && box.half.y == 0) || (bits & 4 && box.half.z == 0);
        if (!again) point.push_back({corner(bits), box.radius}); // a plate has four corners
        for (const int side : {1, 2, 4})
            if (!(bits & side))
                line.push_back({corner(bits), corner(bits | side), box.radius, bits == 0 && side == 1 ? slot : -1});
    }
}

bool BodyShape::has_boxes() const {
    return std::any_of(part.begin(), part.end(), [](const Part& p) { return p.box; });
}

void BodyShape::take_axes(const Vec3d& values, const Mat3d& rows) {
    const std::array<double, 3> j{values.x, values.y, values.z};
    const std::array<Vec3d, 3> row{rows.d1, rows.d2, rows.d3};
    std::size_t third = 2;
    double nearest = HUGE_VAL;
    for (const std::size_t c : {2, 0, 1}) {
        const double a = 1 / j[(c + 1) % 3], b = 1 / j[(c + 2) % 3], apart = std::abs(a - b);
        if (apart < nearest - 1e-12 * (a + b)) {
            nearest = apart;
            third = c;
        }
    }
    const std::size_t one = (third + 1) % 3, two = (third + 2) % 3;
    inertia = {j[one], j[two], j[third]};
    if (std::abs(inertia.x - inertia.y) <= 1e-12 * inertia.x) inertia.x = inertia.y = 0.5 * (inertia.x + inertia.y);
    axes = quaternion({row[one], row[two], row[third]});
}

} // namespace skein
