#include "immersion/body_surface.hpp"

#include "immersion/markers.hpp"
#include "immersion/plate_markers.hpp"
#include "rod/solids.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace skein {

namespace {

using Part = BodyShape::Part;

int pieces_of(double length, double spacing) { return std::max(1, static_cast<int>(std::lround(length / spacing))); }

/// A vector along the axes of a box, in those of the body.
Vec3d of_box(const Part& box, const Vec3d& along) { return transpose_times(box.axes, along); }

SymmetricMatrix turned(const SymmetricMatrix& m, const Quaterniond& axes) {
    const auto row = [&](const Vec3d& e) { return transpose_times(axes, m * (axes * e)); };
    const Vec3d x = row({1, 0, 0}), y = row({0, 1, 0}), z = row({0, 0, 1});
    return {x.x, y.y, z.z, x.y, x.z, y.z};
}

Solid solid_of(const Part& p) {
    if (!p.box) return solid_capsule(p.from, p.to, p.radius);
    const Solid along = solid_box({0, 0, 0}, p.half, p.radius);
    return {along.volume, p.from, turned(along.inertia, p.axes)};
}

void add(DisplacedVolume& sum, double volume, const Vec3d& place) {
    sum.volume += volume;
    sum.centre += volume * place;
    sum.inertia += times(volume, of_point(place));
}

bool may_overlap(const BodyShape& body) {
    for (std::size_t i = 0; i < body.part.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Part &a = body.part[i], &b = body.part[j];
            const auto reach = [](const Part& p) { return 0.5 * norm(p.to - p.from) + p.cover(); };
            if (norm(0.5 * (a.from + a.to - b.from - b.to)) < reach(a) + reach(b)) return true;
        }
    return false;
}

/// Takes off what parts that overlap count too often, by the points of a lattice.
void take_overlaps_off(const BodyShape& body, DisplacedVolume& sum) {
    constexpr int points = 128; // across the body
    const double edge = 2 * body.reach / points, cell = edge * edge * edge;
    const auto at = [&](int i) { return (i + 0.5) * edge - body.reach; };
    for (int i = 0; i < points; ++i)
        for (int j = 0; j < points; ++j)
            for (int k = 0; k < points; ++k) {
                const Vec3d place{at(i), at(j), at(k)};
                const auto within = std::count_if(body.part.begin(), body.part.end(),
                                                  [&](const Part& p) { return distance_from(p, place) < 0; });
                if (within > 1) add(sum, -cell * static_cast<double>(within - 1), place);
            }
}

/// Places of a part's markers.
class PartMarkers {
public:
    PartMarkers(const Part& part, double spacing, double retraction)
        : part_(part), spacing_(spacing), retraction_(retraction) {
        if (part.box) add_box();
        else if (part.radius < spacing) add_line(part.from, part.to, std::max(part.radius - retraction, 0.0));
        else add_capsule();
    }
    std::vector<Vec3d> places;
    bool closed = true; ///< they enclose a volume

private:
    /// Markers on an axis that goes on beyond both of its ends.
    void add_line(const Vec3d& from, const Vec3d& to, double beyond) {
        closed = false;
        const double length = norm(to - from);
        if (length == 0) return places.push_back(from);
        const Vec3d axis = (1 / length) * (to - from), first = from - beyond * axis, last = to + beyond * axis;
        const int parts = pieces_of(length + 2 * beyond, spacing_);
        for (int i = 0; i <= parts; ++i) places.push_back(first + (1.0 * i / parts) * (last - first));
    }

    /// Two halves of a sphere, and rings between them.
    void add_capsule() {
        const double radius = part_.radius - retraction_, length = norm(part_.to - part_.from);
        const Vec3d axis = length > 0 ? (1 / length) * (part_.to - part_.from) : Vec3d{0, 0, 1};
        const auto [u, v] = directions_across(axis);
        const auto along_axis = [&](const Vec3d& at) { return at.x * u + at.y * v + at.z * axis; };
        for (const Vec3d& at : sphere_markers(radius, spacing_))
            places.push_back((at.z > 0 ? part_.to : part_.from) + along_axis(at));
        if (length == 0) return;
        for (const Vec3d& at : tube_markers(radius, radius, 0, length, spacing_))
            places.push_back(part_.from + along_axis(at));
    }

    /// Faces of a sharp box, moved to the rounded one within it; a middle plane, an axis or a point where it is thin.
    void add_box() {
        const double rounding = std::max(part_.radius - retraction_, 0.0),
                     less = std::max(retraction_ - part_.radius, 0.0);
        const auto within = [&](double half) { return std::max(half - less, 0.0); };
        const Vec3d half{within(part_.half.x), within(part_.half.y), within(part_.half.z)};
        const auto out = [&](int d) { return component_of(half, d) + rounding; };
        std::array<bool, 3> thin{};
        for (int d = 0; d < 3; ++d)
            nth(thin, d) = plate_markers(component_of(part_.half, d) + part_.radius, spacing_, retraction_) ==
                           SectionMarkers::sheet;
        const auto thins = std::count(thin.begin(), thin.end(), true);
        closed = thins == 0;
        const auto put = [&](const std::array<double, 3>& at) {
            places.push_back(part_.from + of_box(part_, closed ? rounded({at[0], at[1], at[2]}, half, rounding)
                                                               : Vec3d{at[0], at[1], at[2]}));
        };
        if (thins > 1) { // along the direction that is not thin, if there is one
            const int d = nth(thin, 0) ? (nth(thin, 1) ? 2 : 1) : 0,
                      parts = nth(thin, d) ? 1 : pieces_of(2 * out(d), spacing_);
            for (int i = 0; i < parts; ++i) {
                std::array<double, 3> at{};
                nth(at, d) = out(d) * ((2 * i + 1.0) / parts - 1);
                put(at);
            }
            return;
        }
        for (int across = 0; across < 3; ++across) {
            if (thins == 1 && !nth(thin, across)) continue;
            const int one = (across + 1) % 3, two = (across + 2) % 3;
            for (const double side : {-1.0, 1.0}) {
                if (nth(thin, across) && side < 0) continue;
                const int rows = pieces_of(2 * out(one), spacing_), columns = pieces_of(2 * out(two), spacing_);
                for (int i = 0; i < rows; ++i)
                    for (int j = 0; j < columns; ++j) {
                        std::array<double, 3> at{};
                        nth(at, across) = nth(thin, across) ? 0 : side * out(across);
                        nth(at, one) = out(one) * ((2 * i + 1.0) / rows - 1);
                        nth(at, two) = out(two) * ((2 * j + 1.0) / columns - 1);
                        put(at);
                    }
            }
        }
    }
    static Vec3d rounded(const Vec3d& at, const Vec3d& half, double rounding) {
        const Vec3d inner{std::clamp(at.x, -half.x, half.x), std::clamp(at.y, -half.y, half.y),
                          std::clamp(at.z, -half.z, half.z)};
        const double distance = norm(at - inner);
        return distance > 0 ? inner + (rounding / distance) * (at - inner) : at;
    }

    const Part& part_;
    double spacing_, retraction_;
};

} // namespace

double distance_from(const Part& part, const Vec3d& place) {
    if (part.box) {
        const Vec3d at = part.axes * (place - part.from);
        const Vec3d beyond{std::abs(at.x) - part.half.x, std::abs(at.y) - part.half.y, std::abs(at.z) - part.half.z};
        const Vec3d outside{std::max(beyond.x, 0.0), std::max(beyond.y, 0.0), std::max(beyond.z, 0.0)};
        return norm(outside) + std::min(std::max({beyond.x, beyond.y, beyond.z}), 0.0) - part.radius;
    }
    const Vec3d axis = part.to - part.from;
    const double squared = dot(axis, axis),
                 share = squared > 0 ? std::clamp(dot(place - part.from, axis) / squared, 0.0, 1.0) : 0;
    return norm(place - part.from - share * axis) - part.radius;
}

double PartsSurface::distance(const Vec3d& place) const {
    double least = HUGE_VAL;
    for (const Part& part : parts_) least = std::min(least, distance_from(part, place));
    return least;
}

DisplacedVolume displaced_volume(const BodyShape& body) {
    DisplacedVolume sum;
    for (const Part& part : body.part) {
        const Solid solid = solid_of(part);
        add(sum, solid.volume, solid.centre);
        sum.inertia += times(solid.volume, solid.inertia);
    }
    if (may_overlap(body)) take_overlaps_off(body, sum);
    sum.centre = (1 / sum.volume) * sum.centre;
    return sum;
}

AddedInertia added_inertia(const DisplacedVolume& displaced) {
    // Squared half axes of the ellipsoid, over the squared radius of the sphere of its volume.
    const SymmetricMatrix& about_mass = displaced.inertia;
    const Vec3d &c = displaced.centre,
                own = Vec3d{about_mass.xx, about_mass.yy, about_mass.zz} -
                      displaced.volume * Vec3d{c.y * c.y + c.z * c.z, c.z * c.z + c.x * c.x, c.x * c.x + c.y * c.y};
    const double sum = own.x + own.y + own.z;
    Vec3d square = Vec3d{sum - 2 * own.x, sum - 2 * own.y, sum - 2 * own.z};
    square = (1 / std::cbrt(square.x * square.y * square.z)) * square;
    // alpha_i = integral over l from 0 on of dl/((a_i^2 + l) (product of a_j^2 + l)^1/2) at a product of half axes of
    // 1, by l = (s/(1 - s))^2.
    constexpr int pieces = 2000;
    Vec3d alpha{0, 0, 0};
    for (int p = 0; p < pieces; ++p) {
        const double s = (p + 0.5) / pieces, root = s / (1 - s), l = root * root,
                     width = 2 * root / ((1 - s) * (1 - s));
        const Vec3d to = square + Vec3d{l, l, l};
        const double term = width / (pieces * std::sqrt(to.x * to.y * to.z));
        alpha += Vec3d{term / to.x, term / to.y, term / to.z};
    }
    const auto turning = [](double a, double b, double alpha_a, double alpha_b) { // squared half axes across
        const double lower = 2 * (a - b) + (a + b) * (alpha_b - alpha_a);
        return std::abs(a - b) > 1e-6 * (a + b) ? (a - b) * (a - b) * (alpha_b - alpha_a) / ((a + b) * lower) : 0.0;
    };
    const auto moving = [](double of) { return of / (2 - of); };
    return {{moving(alpha.x), moving(alpha.y), moving(alpha.z)},
            {turning(square.y, square.z, alpha.y, alpha.z), turning(square.z, square.x, alpha.z, alpha.x),
             turning(square.x, square.y, alpha.x, alpha.y)}};
}

std::vector<Vec3d> part_markers(const Part& part, double spacing, double retraction) {
    return PartMarkers(part, spacing, retraction).places;
}

std::vector<RodMarker> body_markers(const BodyShape& body, double spacing, double retraction) {
    constexpr double rounding = 1e-9; // of the spacing
    std::vector<PartMarkers> of_parts;
    for (const Part& part : body.part) of_parts.emplace_back(part, spacing, retraction);
    std::vector<RodMarker> markers;
    for (std::size_t p = 0; p < of_parts.size(); ++p)
        for (const Vec3d& at : of_parts[p].places) {
            bool covered = false;
            for (std::size_t q = 0; q < of_parts.size(); ++q)
                covered |=
                    q != p && of_parts[q].closed && distance_from(body.part[q], at) < -retraction - rounding * spacing;
            if (!covered) markers.push_back({.element = 0, .along = 0, .off_d1 = at.x, .off_d2 = at.y, .off_d3 = at.z});
        }
    return markers;
}

} // namespace skein
