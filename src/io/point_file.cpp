#include "io/point_file.hpp"

#include "parallel/pieces.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace skein {

namespace {

constexpr double largest_place = 1e30, least_radius = 1e-30; // m: squares of squares are numbers

bool within(const Vec3d& p) {
    return std::abs(p.x) <= largest_place && std::abs(p.y) <= largest_place && std::abs(p.z) <= largest_place;
}

bool finite(const Vec3d& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

bool nearly_along(const Vec3d& a, const Vec3d& b) { return !(norm(cross(a, b)) >= 1e-6 * norm(a) * norm(b)); }

} // namespace

RodColumns PointFile::columns() const {
    RodColumns columns;
    columns.nodes = true;
    columns.radii = radii_;
    columns.directors = normals_;
    columns.normal = start_normals_;
    return columns;
}

void PointFile::refuse(std::int64_t rod, std::int64_t point, const std::string& what) const {
    const std::lock_guard lock(refusing_);
    throw InputError(fmt::format("{}: {}", place(rod, point), what));
}
void PointFile::refuse(const std::string& what) const { throw InputError(fmt::format("{}: {}", path_, what)); }

void PointFile::make_room(RodPoints& points, std::span<const std::int64_t> first) const {
    const std::size_t count = to_index(first.back() - first.front());
    points.first.clear();
    for (const std::int64_t at : first) points.first.push_back(to_index(at - first.front()));
    points.points.resize(count);
    points.radii.resize(radii_ ? count : 0);
    points.normals.resize(normals_ ? count : 0);
    points.start_normals.resize(start_normals_ ? points.rods() : 0);
}

/// Checks points [begin, end), those of a rod, and gives them in m.
void PointFile::check(std::int64_t rod, RodPoints& given, std::size_t begin, std::size_t end) const {
    if (end - begin < 2) refuse(rod, end == begin ? -1 : 0, "the rod has fewer than two points");
    const auto place_of = [&](std::size_t i) { return static_cast<std::int64_t>(i - begin); };
    for (std::size_t i = begin; i < end; ++i) {
        Vec3d& point = given.points[i];
        if (!finite(point)) refuse(rod, place_of(i), "not a finite number");
        point = unit_ * point;
        if (!within(point)) refuse(rod, place_of(i), fmt::format("lies beyond {:g} m", largest_place));
        if (i > begin && !(norm(point - given.points[i - 1]) > 0))
            refuse(rod, place_of(i), "is the same point as the one before; leave one of them out");
    }
    for (std::size_t i = begin; radii_ && i < end; ++i) {
        double& radius = given.radii[i];
        if (!std::isfinite(radius)) refuse(rod, place_of(i), "the radius is not a finite number");
        if (!(radius > 0)) refuse(rod, place_of(i), fmt::format("the radius is {:g}; it must be above 0", radius));
        radius *= unit_;
        if (!(radius >= least_radius && radius <= largest_place))
            refuse(rod, place_of(i),
                   fmt::format("the radius is {:g} m; it must lie between {:g} and {:g} m", radius, least_radius,
                               largest_place));
    }
    for (std::size_t i = begin; normals_ && i < end; ++i) {
        const double size = norm(given.normals[i]);
        if (!(size > 0 && std::isfinite(size))) refuse(rod, place_of(i), "the normal has no direction");
        given.normals[i] = (1 / size) * given.normals[i];
        if (i > begin && !(dot(given.normals[i], given.normals[i - 1]) > 0))
            refuse(rod, place_of(i), "the normal turns by more than 90 degrees from the point before");
    }
}

/// Turns points into nodes. Each thread has one.
struct PointFile::Resampler {
    const PointFile& file;
    RodRows& rows;
    PointCurve curve{};
    std::vector<PointCurve::Place> places{};
    std::vector<Vec3d> nodes{};

    /// Points of one rod.
    struct Given {
        std::span<const Vec3d> points;
        std::span<const double> radii;
        std::span<const Vec3d> normals;
        const Vec3d* start_normal;
    };

    /// Fills row `row`; returns the distance from the line through the points, m.
    double take(std::int64_t rod, const Given& given, std::size_t row) {
        curve.pass_through(given.points);
        curve.cut(file.target_, places);
        nodes.clear();
        for (const PointCurve::Place& place : places) nodes.push_back(curve.at(place));
        nodes.front() = given.points.front();
        nodes.back() = given.points.back();
        check_nodes(rod);
        rows.origins[row] = nodes.front();
        std::copy(nodes.begin(), nodes.end(), &rows.nodes[row * nodes.size()]);
        put_radii(given, row);
        put_normals(rod, given, row);
        return curve.deviation(places, nodes);
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

    void put_radii(const Given& given, std::size_t row) {
        if (given.radii.empty()) return;
        double before = given.radii.front();
        for (std::size_t k = 1; k < places.size(); ++k) {
            const double radius = value_at(places[k], given.radii);
            rows.element_radii[row * file.target_ + k - 1] = 0.5 * (before + radius);
            before = radius;
        }
    }

    void put_normals(std::int64_t rod, const Given& given, std::size_t row) {
        const auto refuse_along = [&](std::size_t k) {
            file.refuse(rod, static_cast<std::int64_t>(places[k].piece),
                        fmt::format("the normal is not across element {} of the rod", k));
        };
        if (given.start_normal) {
            if (nearly_along(nodes[1] - nodes[0], *given.start_normal)) refuse_along(0);
            rows.normals[row] = *given.start_normal;
        }
        if (given.normals.empty()) return;
        Vec3d before = given.normals.front();
        for (std::size_t k = 0; k + 1 < places.size(); ++k) {
            const Vec3d after = value_at(places[k + 1], given.normals), middle = 0.5 * (before + after);
            rows.element_normals[row * file.target_ + k] = middle;
            if (nearly_along(nodes[k + 1] - nodes[k], middle)) refuse_along(k);
            before = after;
        }
    }
};

RodRows PointFile::read(std::int64_t begin, std::int64_t end, const Threads* threads) const {
    constexpr std::size_t piece = 128;
    struct Farthest {
        double distance = -1;
        std::int64_t rod = 0, fewest = 0, most = 0;
    };
    RodRows rows;
    const std::size_t rods = to_index(end - begin);
    rows.origins.resize(rods);
    rows.nodes.resize(rods * (target_ + 1));
    rows.element_radii.resize(radii_ ? rods * target_ : 0);
    rows.normals.resize(start_normals_ ? rods : 0);
    rows.element_normals.resize(normals_ ? rods * target_ : 0);
    std::vector<Resampler> resamplers(threads_in(threads), Resampler{*this, rows});
    std::vector<Farthest> farthest;
    read_points(begin, end, threads, [&](std::int64_t first_rod, RodPoints& given) {
        const std::size_t before = farthest.size();
        farthest.resize(before + (given.rods() + piece - 1) / piece);
        in_pieces(threads, given.rods(), piece,
                  [&](std::size_t first, std::size_t past, std::size_t thread, std::size_t number) {
                      Farthest& found = farthest[before + number];
                      for (std::size_t r = first; r < past; ++r) {
                          const std::int64_t rod = first_rod + static_cast<std::int64_t>(r);
                          const std::size_t at = given.first[r], points = given.first[r + 1] - at;
                          check(rod, given, at, at + points);
                          const double distance = resamplers[thread].take(
                              rod,
                              {std::span(given.points).subspan(at, points),
                               radii_ ? std::span(given.radii).subspan(at, points) : std::span<const double>(),
                               normals_ ? std::span(given.normals).subspan(at, points) : std::span<const Vec3d>(),
                               start_normals_ ? &given.start_normals[r] : nullptr},
                              to_index(rod - begin));
                          const auto count = static_cast<std::int64_t>(points);
                          if (distance > found.distance) std::tie(found.distance, found.rod) = std::pair(distance, rod);
                          found.fewest = r == first ? count : std::min(found.fewest, count);
                          found.most = std::max(found.most, count);
                      }
                  });
    });
    Farthest all;
    for (const Farthest& found : farthest) {
        if (found.distance > all.distance) std::tie(all.distance, all.rod) = std::pair(found.distance, found.rod);
        all.fewest = all.most == 0 ? found.fewest : std::min(all.fewest, found.fewest);
        all.most = std::max(all.most, found.most);
    }
    if (!farthest.empty()) rows.deviation = {all.distance, name(all.rod), all.fewest, all.most};
    return rows;
}

} // namespace skein
