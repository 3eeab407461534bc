#include "io/point_file.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <cmath>

namespace skein {

namespace {

constexpr double largest_place = 1e30, least_radius = 1e-30; // m: squares of squares are numbers

bool within(const Vec3d& p) {
    return std::abs(p.x) <= largest_place && std::abs(p.y) <= largest_place && std::abs(p.z) <= largest_place;
}

bool finite(const Vec3d& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

bool nearly_along(const Vec3d& a, const Vec3d& b) { return !(norm(cross(a, b)) >= 1e-6 * norm(a) * norm(b)); }

} // namespace

void RodPoints::clear() {
    points.clear();
    radii.clear();
    normals.clear();
    start_normal.clear();
}

RodColumns PointFile::columns() const {
    RodColumns columns;
    columns.nodes = true;
    columns.radii = radii_;
    columns.directors = normals_;
    columns.normal = start_normals_;
    return columns;
}

void PointFile::refuse(std::int64_t rod, std::int64_t point, const std::string& what) const {
    throw InputError(fmt::format("{}: {}", place(rod, point), what));
}
void PointFile::refuse(const std::string& what) const { throw InputError(fmt::format("{}: {}", path_, what)); }

/// Checks the points of a rod, and gives them in m.
void PointFile::check(std::int64_t rod, RodPoints& given) const {
    if (given.points.size() < 2) refuse(rod, given.points.empty() ? -1 : 0, "the rod has fewer than two points");
    for (std::size_t i = 0; i < given.points.size(); ++i) {
        const auto point = static_cast<std::int64_t>(i);
        if (!finite(given.points[i])) refuse(rod, point, "not a finite number");
        given.points[i] = unit_ * given.points[i];
        if (!within(given.points[i])) refuse(rod, point, fmt::format("lies beyond {:g} m", largest_place));
        if (i > 0 && !(norm(given.points[i] - given.points[i - 1]) > 0))
            refuse(rod, point, "is the same point as the one before; leave one of them out");
    }
    for (std::size_t i = 0; i < given.radii.size(); ++i) {
        const auto point = static_cast<std::int64_t>(i);
        double& radius = given.radii[i];
        if (!std::isfinite(radius)) refuse(rod, point, "the radius is not a finite number");
        if (!(radius > 0)) refuse(rod, point, fmt::format("the radius is {:g}; it must be above 0", radius));
        radius *= unit_;
        if (!(radius >= least_radius && radius <= largest_place))
            refuse(rod, point,
                   fmt::format("the radius is {:g} m; it must lie between {:g} and {:g} m", radius, least_radius,
                               largest_place));
    }
    for (std::size_t i = 0; i < given.normals.size(); ++i) {
        const auto point = static_cast<std::int64_t>(i);
        const double size = norm(given.normals[i]);
        if (!(size > 0 && std::isfinite(size))) refuse(rod, point, "the normal has no direction");
        given.normals[i] = (1 / size) * given.normals[i];
        if (i > 0 && !(dot(given.normals[i], given.normals[i - 1]) > 0))
            refuse(rod, point, "the normal turns by more than 90 degrees from the point before");
    }
}

/// Turns points into nodes.
struct PointFile::Resampler {
    const PointFile& file;
    RodRows& rows;
    PointCurve curve{};
    std::vector<PointCurve::Place> places{};
    std::vector<Vec3d> nodes{};

    void take(std::int64_t rod, const RodPoints& given) {
        curve.pass_through(given.points);
        curve.cut(file.target_, places);
        nodes.clear();
        for (const PointCurve::Place& place : places) nodes.push_back(curve.at(place));
        nodes.front() = given.points.front();
        nodes.back() = given.points.back();
        check_nodes(rod);
        rows.origins.push_back(nodes.front());
        rows.nodes.insert(rows.nodes.end(), nodes.begin(), nodes.end());
        put_radii(given);
        put_normals(rod, given);
        const double distance = curve.deviation(places, nodes);
        const auto points = static_cast<std::int64_t>(given.points.size());
        const bool largest = distance > rows.deviation.distance;
        rows.deviation.include({distance, largest ? file.name(rod) : "", points, points});
    }

    /// Frames follow edges, which no reversal may interrupt.
    void check_nodes(std::int64_t rod) const {
        for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
            const auto point = static_cast<std::int64_t>(places[k].piece);
            const Vec3d edge = nodes[k + 1] - nodes[k];
            if (!(norm(edge) > 0))
                file.refuse(
                    rod, point,
                    fmt::format("resampled to {} elements, nodes {} and {} are one point", nodes.size() - 1, k, k + 1));
            if (k == 0) continue;
            const Vec3d before = nodes[k] - nodes[k - 1];
            if (dot(before, edge) < -0.99 * norm(before) * norm(edge))
                file.refuse(
                    rod, point,
                    fmt::format("resampled to {} elements, the rod turns back at node {}", nodes.size() - 1, k));
        }
    }

    void put_radii(const RodPoints& given) {
        if (given.radii.empty()) return;
        double before = given.radii.front();
        for (std::size_t k = 1; k < places.size(); ++k) {
            const double radius = value_at(places[k], std::span<const double>(given.radii));
            rows.element_radii.push_back(0.5 * (before + radius));
            before = radius;
        }
    }

    void put_normals(std::int64_t rod, const RodPoints& given) {
        const auto refuse_along = [&](std::size_t k) {
            file.refuse(rod, static_cast<std::int64_t>(places[k].piece),
                        fmt::format("the normal is not across element {} of the rod", k));
        };
        if (!given.start_normal.empty()) {
            if (nearly_along(nodes[1] - nodes[0], given.start_normal[0])) refuse_along(0);
            rows.normals.push_back(given.start_normal[0]);
        }
        if (given.normals.empty()) return;
        Vec3d before = given.normals.front();
        for (std::size_t k = 0; k + 1 < places.size(); ++k) {
            const Vec3d after = value_at(places[k + 1], std::span<const Vec3d>(given.normals));
            rows.element_normals.push_back(0.5 * (before + after));
            if (nearly_along(nodes[k + 1] - nodes[k], rows.element_normals.back())) refuse_along(k);
            before = after;
        }
    }
};

RodRows PointFile::read(std::int64_t begin, std::int64_t end) const {
    RodRows rows;
    const std::size_t rods = to_index(end - begin);
    rows.origins.reserve(rods);
    rows.nodes.reserve(rods * (target_ + 1));
    if (radii_) rows.element_radii.reserve(rods * target_);
    Resampler resampler{*this, rows};
    read_points(begin, end, [&](std::int64_t rod, RodPoints& points) {
        check(rod, points);
        resampler.take(rod, points);
    });
    return rows;
}

} // namespace skein
