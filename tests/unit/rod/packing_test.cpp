// Packed rods: apart, inside, straight, alike for a seed, and pointing as their law says.
#include "placement/packing.hpp"

#include "core/rotation.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace skein {
namespace {

constexpr double length = 0.07574, radius = 0.0012075; // aspect 31

Packing box(long count, const Vec3d& size) { return {.count = count, .upper = size}; }
Packing cylinder(long count, double r, double height) {
    return {
        .count = count, .region = PackingRegion::cylinder, .point = {0.1, -0.2, 0.3}, .radius = r, .height = height};
}

std::vector<Capsule> packed(const Packing& p, std::vector<Capsule> occupied = {}) {
    pack(p, length, radius, occupied, "here");
    return occupied;
}

/// Least distance of two axes by their sampled points: slower than any grid, and simpler than any formula.
double sampled_distance(const Capsule& a, const Capsule& b) {
    double least = INFINITY;
    for (int i = 0; i <= 60; ++i)
        for (int j = 0; j <= 60; ++j)
            least = std::min(least,
                             norm(a.start + (i / 60.0) * (a.end - a.start) - b.start - (j / 60.0) * (b.end - b.start)));
    return least;
}

void expect_apart(const std::vector<Capsule>& rods, double gap) {
    for (std::size_t i = 0; i < rods.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            if (norm(0.5 * (rods[i].start + rods[i].end - rods[j].start - rods[j].end)) >
                norm(rods[i].end - rods[i].start) + 0.02)
                continue;
            ASSERT_FALSE(closer(rods[i], rods[j], rods[i].radius + rods[j].radius + 0.999 * gap)) << i << " and " << j;
        }
}

TEST(Packing, CloserIsWhatSamplingSays) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> even(-1, 1);
    const auto point = [&] { return Vec3d{even(random), even(random), even(random)}; };
    for (int i = 0; i < 400; ++i) {
        Capsule a{point(), point(), 0}, b{point(), point(), 0};
        if (i % 4 == 1) b = {b.start, b.start + (0.5 + even(random)) * (a.end - a.start), 0}; // parallel
        if (i % 4 == 2) b = {0.5 * (a.start + a.end) + Vec3d{1e-3, 0, 0}, b.end, 0}; // an end near the other's middle
        if (i % 4 == 3) b.end = b.start;                                             // a point
        const double sampled = sampled_distance(a, b); // too large by the spacing of the points at most
        EXPECT_FALSE(closer(a, b, std::max(0.0, sampled - 0.06))) << i;
        EXPECT_TRUE(closer(a, b, sampled + 1e-12)) << i;
    }
}

TEST(Packing, KeepsRodsApartAndInsideABox) {
    const Vec3d size{0.2, 0.15, 0.12};
    const auto rods = packed(box(400, size));
    ASSERT_EQ(rods.size(), 400u);
    expect_apart(rods, 0.05 * radius);
    for (const Capsule& c : rods)
        for (const Vec3d& end : {c.start, c.end})
            for (const double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
                EXPECT_GE(end.*axis, radius - 1e-15);
                EXPECT_LE(end.*axis, size.*axis - radius + 1e-15);
            }
}

TEST(Packing, KeepsRodsApartAndInsideACylinder) {
    const Packing p = cylinder(200, 0.07, 0.15);
    const auto rods = packed(p);
    expect_apart(rods, 0.05 * radius);
    for (const Capsule& c : rods)
        for (const Vec3d& end : {c.start, c.end}) {
            EXPECT_LE(std::hypot(end.x - p.point.x, end.y - p.point.y), p.radius - radius + 1e-15);
            EXPECT_GE(end.z, p.point.z + radius - 1e-15);
            EXPECT_LE(end.z, p.point.z + p.height - radius + 1e-15);
        }
}

TEST(Packing, OfASlabGrowsAsItMust) {
    Packing p = box(600, {0.12, 0.12, 0});
    p.lower.z = -1;
    p.region = PackingRegion::slab;
    std::vector<Capsule> rods;
    const PackedRods result = pack(p, length, radius, rods, "here");
    expect_apart(rods, 0.05 * radius);
    double highest = -1;
    for (const Capsule& c : rods) {
        EXPECT_GE(std::min(c.start.z, c.end.z), -1 + radius - 1e-15);
        highest = std::max({highest, c.start.z, c.end.z});
    }
    EXPECT_LE(highest, result.top - radius + 1e-15);
    EXPECT_GT(highest, result.top - 0.02);
    EXPECT_GT(result.fill, 0.05);
    EXPECT_NEAR(result.fill,
                600 * std::numbers::pi * radius * radius * (length + 4.0 / 3 * radius) /
                    (0.12 * 0.12 * (result.top + 1)),
                1e-12);
}

TEST(Packing, KeepsClearOfWhatIsThere) {
    // Thick bars and far, thin ones of another group.
    std::vector<Capsule> there{{{0, 0.06, 0.06}, {0.12, 0.06, 0.06}, 0.01},
                               {{0.03, 0, 0.03}, {0.03, 0.12, 0.03}, 0.002},
                               {{5, 5, 5}, {6, 5, 5}, 0.1}};
    Packing p = box(100, {0.12, 0.12, 0.12});
    const auto both = packed(p, there);
    ASSERT_EQ(both.size(), 103u);
    expect_apart(both, 0.05 * radius);
    p.seed = 2;
    p.count = 40;
    expect_apart(packed(p, both), 0.05 * radius);
}

TEST(Packing, DependsOnTheSeedAlone) {
    Packing p = box(200, {0.15, 0.15, 0.15});
    const auto same = [](const std::vector<Capsule>& a, const std::vector<Capsule>& b) {
        bool all = a.size() == b.size();
        for (std::size_t i = 0; all && i < a.size(); ++i)
            for (const double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z})
                all = all && a[i].start.*axis == b[i].start.*axis && a[i].end.*axis == b[i].end.*axis;
        return all;
    };
    const auto first = packed(p);
    EXPECT_TRUE(same(first, packed(p)));
    p.seed = 2;
    EXPECT_FALSE(same(first, packed(p)));
}

/// Chi-square of values in [low, high] against an even law, 20 bins: 43.8 is passed once in a thousand.
double chi_square(const std::vector<double>& values, double low, double high) {
    std::vector<double> bins(20, 0.0);
    for (const double v : values)
        ++bins[static_cast<std::size_t>(std::clamp(20 * (v - low) / (high - low), 0.0, 19.0))];
    const double expected = static_cast<double>(values.size()) / 20;
    double sum = 0;
    for (const double n : bins) sum += (n - expected) * (n - expected) / expected;
    return sum;
}

TEST(Packing, DirectionsFollowTheirLaw) {
    using std::numbers::pi;
    const auto directions = [](Packing p) {
        std::vector<Vec3d> all;
        for (const Capsule& c : packed(p)) all.push_back((1 / length) * (c.end - c.start));
        return all;
    };
    Packing p = box(4000, {0.4, 0.4, 0.25}); // 5 % of the volume
    std::vector<double> sines, azimuths;
    Vec3d squares{0, 0, 0};
    for (const Vec3d& d : directions(p)) {
        sines.push_back(d.z);
        azimuths.push_back(std::atan2(d.y, d.x));
        squares += Vec3d{d.x * d.x, d.y * d.y, d.z * d.z};
    }
    EXPECT_LT(chi_square(sines, -1, 1), 43.8);
    EXPECT_LT(chi_square(azimuths, -pi, pi), 43.8);
    for (const double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z})
        EXPECT_NEAR(squares.*axis / 4000, 1.0 / 3, 4 * std::sqrt(4.0 / 45 / 4000));

    p.elevation = {-10, 30};
    p.azimuth = {20, 50};
    sines.clear();
    azimuths.clear();
    for (const Vec3d& d : directions(p)) {
        sines.push_back(d.z);
        azimuths.push_back(std::atan2(d.y, d.x));
    }
    EXPECT_LT(chi_square(sines, std::sin(-pi / 18), 0.5), 43.8);
    EXPECT_LT(chi_square(azimuths, pi / 9, pi / 3.6), 43.8);
    const auto [least, largest] = std::minmax_element(sines.begin(), sines.end());
    EXPECT_GE(*least, std::sin(-pi / 18) - 1e-12);
    EXPECT_LE(*largest, 0.5 + 1e-12);

    p.elevation_law = ElevationLaw::uniform;
    std::vector<double> elevations;
    for (const Vec3d& d : directions(p)) elevations.push_back(std::asin(d.z));
    EXPECT_LT(chi_square(elevations, -pi / 18, pi / 6), 43.8);
}

std::string refusal(const Packing& p) {
    try {
        packed(p);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(Packing, SaysHowManyFitted) {
    const std::string full = refusal(box(2000, {0.1, 0.1, 0.1}));
    EXPECT_NE(full.find("here: "), std::string::npos);
    EXPECT_NE(full.find(" of 2000 rods could be packed"), std::string::npos) << full;
    EXPECT_NE(full.find("enlarge the region"), std::string::npos) << full;
}

TEST(Packing, SaysWhatNeverFits) {
    EXPECT_NE(refusal(box(100, {0.05, 0.05, 0.02})).find("fit into the empty region"), std::string::npos);
    EXPECT_NE(refusal(cylinder(1, 0.01, 0.05)).find("fit into the empty region"), std::string::npos);
}

TEST(Packing, DrawsDirectionsUntilOneFits) {
    // Half as wide as rods are long: those within 30 degrees of x fit at most.
    Packing p = box(40, {2 * length, 0.5 * length, 1});
    p.elevation = {0, 0};
    const auto rods = packed(p);
    ASSERT_EQ(rods.size(), 40u);
    for (const Capsule& rod : rods) EXPECT_LT(std::abs(rod.end.y - rod.start.y), 0.5 * length);
}

/// A thick rod above a bed of thin ones: where it drew a direction in which it lies, no centre is clear. It stands
/// then.
TEST(Packing, DrawsAnotherDirectionWhereTheFirstHasNoPlace) {
    int stood = 0;
    for (long seed = 1; seed <= 65; ++seed) {
        Packing bed{.count = 60, .seed = 4710 + seed, .lower = {0, 0, 0.02}, .upper = {0.2, 0.2, 0.35}}, thick = bed;
        thick.count = 1;
        thick.seed += 1;
        thick.upper.z = 0.4;
        thick.attempts = 20000;
        std::vector<Capsule> rods;
        pack(bed, 0.12, 0.006, rods, "here");
        ASSERT_NO_THROW(pack(thick, 0.16, 0.012, rods, "here")) << seed;
        expect_apart(rods, 0.05 * 0.006);
        stood += std::abs(rods.back().end.z - rods.back().start.z) > 0.08;
    }
    EXPECT_LT(stood, 65);
}

TEST(Packing, GroupsStartStraightInFramesOfTheirOwn) {
    RodSpec spec = test::simple_rod(12);
    spec.section = {.radius = 0.02, .taper = 0.5};
    spec.placement.kind = PlacementKind::packing;
    spec.placement.packing = box(60, {3, 3, 2});
    spec.shape.length_profile = {1, 2, 1, 2, 1, 1, 1, 3, 1, 1, 2, 1};
    std::vector<Capsule> occupied;
    const RodGroup group(spec, 0, 0, "", &occupied);
    ASSERT_EQ(group.count(), 60);
    ASSERT_EQ(occupied.size(), 60u);
    std::vector<Slot<1>> state(13);
    std::vector<Capsule> elements;
    for (std::int64_t i = 0; i < 60; ++i) {
        group.start_state(i, state);
        Vec3d sum{0, 0, 0};
        for (std::size_t k = 0; k < 12; ++k) {
            const Quaterniond q = lane(state[k].director, 0);
            EXPECT_NEAR(dot(q, q), 1, 1e-15);
            const Vec3d strain =
                group.element[k].inv_rest_length * (q * (lane(state[k + 1].position, 0) - lane(state[k].position, 0)));
            EXPECT_LT(norm(strain - Vec3d{0, 0, 1}), 1e-13);
            EXPECT_LT(std::abs(frame(state[k]).d1.z), 1e-15) << "d1 is horizontal";
            EXPECT_LT(norm(relative_rotation(q, lane(state[0].director, 0))), 1e-16) << "neither bent nor twisted";
        }
        for (const Slot<1>& s : state) sum += lane(s.position, 0);
        EXPECT_LT(norm((1.0 / 13) * sum - group.centre(i)), 1e-14);
        group.append_capsules(i, elements);
    }
    // Elements of different rods, against each other.
    for (std::size_t a = 0; a < elements.size(); ++a)
        for (std::size_t b = 0; b < a / 12 * 12; ++b)
            ASSERT_FALSE(closer(elements[a], elements[b], elements[a].radius + elements[b].radius));
}

TEST(Packing, NumbersNeighboursAlike) {
    std::vector<Capsule> rods;
    const PackedRods result = pack(box(1000, {0.3, 0.3, 0.3}), length, radius, rods, "here");
    const auto mean_step = [](const std::vector<Vec3d>& at) {
        double sum = 0;
        for (std::size_t i = 1; i < at.size(); ++i) sum += norm(at[i] - at[i - 1]);
        return sum / static_cast<double>(at.size() - 1);
    };
    std::vector<Vec3d> centres, drawn;
    for (std::size_t i = 0; i < 1000; ++i)
        centres.push_back(result.origins[i] + 0.5 * length * third_director(result.frames[i]));
    for (const Capsule& c : rods) drawn.push_back(0.5 * (c.start + c.end));
    EXPECT_LT(mean_step(centres), 0.3 * mean_step(drawn));
}

} // namespace
} // namespace skein
