// Candidates are those of a search through all pairs: always, and for any number of threads.
#include "contact/broad_phase.hpp"

#include "core/closest_points.hpp"
#include "support/beds.hpp"

#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

using test::BodiesByHand;

/// Rods that wander at random: `sizes` of element length and radius spread over a factor, in a box, or parallel in a
/// bundle.
BodiesByHand random_rods(unsigned seed, int rods, double spread, bool bundle) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const auto vector = [&](double size) {
        return Vec3d{size * normal(random), size * normal(random), size * normal(random)};
    };
    BodiesByHand bodies;
    for (int r = 0; r < rods; ++r) {
        const double size = std::pow(spread, uniform(random)), length = 0.1 * size,
                     radius = (0.01 + 0.03 * uniform(random)) * size;
        const int elements = 1 + static_cast<int>(12 * uniform(random));
        Vec3d x = bundle ? Vec3d{0.05 * r, 0.01 * normal(random), 0}
                         : Vec3d{uniform(random), uniform(random), uniform(random)} + vector(0.3);
        Vec3d along = bundle ? Vec3d{0, 1e-9 * normal(random), 1} : vector(1);
        std::vector<Vec3d> nodes;
        for (int k = 0; k <= elements; ++k) {
            nodes.push_back(x);
            if (!bundle) along += vector(0.5);
            x += (length / norm(along)) * along;
        }
        bodies.add(nodes, radius, r % 3 - 1);
    }
    return bodies;
}

TEST(BroadPhase, FindsWhatASearchThroughAllPairsFinds) {
    const Threads one(1), three(3);
    std::size_t pairs = 0;
    int grids = 0;
    for (unsigned seed = 0; seed < 200; ++seed) {
        const int rods = 10 + static_cast<int>(seed % 40);
        const BodiesByHand bodies = random_rods(seed, rods, seed % 2 ? 20 : 1, seed % 5 == 0);
        std::vector<std::uint8_t> own;
        for (int r = 0; seed % 4 == 3 && r < rods; ++r) own.push_back(r % 3 == 0);
        Exposure c = bodies.exposure(own);
        std::mt19937 random(seed);
        for (float& pace : c.pace)
            if (seed % 2 == 0) pace = std::uniform_real_distribution<float>(0.25f, 1)(random);
        const double skin = seed % 3 ? 0.02 : 0;
        BroadPhase search(one), parallel(three);
        Candidates found, by_three, all;
        search.build(c, bodies.rules, skin, found);
        parallel.build(c, bodies.rules, skin, by_three);
        BroadPhase::build_exhaustively(c, bodies.rules, skin, all);
        ASSERT_EQ(found.first, all.first) << seed;
        ASSERT_EQ(found.partner, all.partner) << seed;
        ASSERT_EQ(by_three.first, all.first) << seed;
        ASSERT_EQ(by_three.partner, all.partner) << seed;
        ASSERT_EQ(found.inactive, all.inactive) << seed;
        pairs += found.count();
        grids = std::max(grids, search.grids());
    }
    EXPECT_GT(pairs, 10000u);
    EXPECT_GE(grids, 4);
}

/// Far from the origin as near it, and in any unit of length, as single precision comes first.
TEST(BroadPhase, MissesNoPairInTenBeds) {
    const Threads one(1);
    for (const std::string_view name : test::bed_names)
        for (const Vec3d& origin : {Vec3d{0, 0, 0}, Vec3d{3e5, -2e5, 1e5}})
            for (const double unit : {1.0, std::ldexp(1.0, -20), std::ldexp(1.0, 20)}) {
                const test::Bed bed(name, 60);
                Exposure c = bed.exposure();
                for (ExposedNode& n : c.node) n = {unit * (n.position + origin), unit * n.radius};
                for (const double skin : {0.25, 1.0}) {
                    BroadPhase search(one);
                    Candidates found, all;
                    search.build(c, bed.rules(), unit * skin, found);
                    BroadPhase::build_exhaustively(c, bed.rules(), unit * skin, all);
                    ASSERT_EQ(found.first, all.first) << name << " skin " << skin << " unit " << unit;
                    ASSERT_EQ(found.partner, all.partner) << name << " skin " << skin << " unit " << unit;
                    EXPECT_GE(found.count(), name == "dilute" || name == "column" ? 0u : 20u) << name;
                    EXPECT_GE(search.tested(), static_cast<std::int64_t>(found.count()));
                    EXPECT_LE(search.tested(), 2 * static_cast<std::int64_t>(found.count()) + 50) << name;
                }
            }
}

TEST(BroadPhase, NeedsNoBounds) {
    const Threads one(1);
    const BodiesByHand bodies = random_rods(3, 30, 5, false);
    Exposure c = bodies.exposure();
    BroadPhase search(one);
    Candidates near, far;
    search.build(c, bodies.rules, 0.02, near);
    for (const Window& w : c.window)
        if (c.node[w.first_slot].position.x > 0.5)
            for (std::uint32_t s = w.first_slot; s < w.first_slot + w.slots; ++s)
                c.node[s].position.x += 4096; // cells wrap round on the way
    search.build(c, bodies.rules, 0.02, far);
    Candidates all;
    BroadPhase::build_exhaustively(c, bodies.rules, 0.02, all);
    EXPECT_EQ(far.partner, all.partner);
    EXPECT_LT(far.count(), near.count());
}

/// Nodes that have become invalid cost no time and hide no pair of others, in the first search and after one.
TEST(BroadPhase, LeavesOutInvalidElements) {
    const Threads one(1);
    const BodiesByHand bodies = random_rods(5, 30, 5, false);
    for (const double lost : {std::nan(""), HUGE_VAL, 1e300, 1e150, 1e39, 1e25, 1e12})
        for (const int axes : {1, 2, 4, 7})
            for (const bool first : {true, false})
                for (const std::uint32_t wrong : {0u, 7u, 8u}) {
                    Exposure c = bodies.exposure();
                    BroadPhase search(one);
                    Candidates found, all;
                    if (!first) search.build(c, bodies.rules, 0.02, found);
                    Vec3d& x = c.node[wrong].position;
                    if (axes & 1) x.x = lost;
                    if (axes & 2) x.y = -lost;
                    if (axes & 4) x.z = lost;
                    search.build(c, bodies.rules, 0.02, found);
                    BroadPhase::build_exhaustively(c, bodies.rules, 0.02, all);
                    const auto valid = [&](const Candidates& candidates) {
                        std::vector<Pair> pairs;
                        for (std::uint32_t a = 0; a < c.slots(); ++a)
                            for (std::uint32_t i = candidates.first[a]; i < candidates.first[a + 1]; ++i)
                                if (const std::uint32_t b = candidates.partner[i]; a != wrong && a + 1 != wrong)
                                    if (b != wrong && b + 1 != wrong) pairs.push_back({a, b});
                        return pairs;
                    };
                    ASSERT_EQ(valid(found), valid(all)) << lost << " along " << axes;
                    ASSERT_GT(valid(found).size(), 20u);
                }
}

/// The least distance by looking: the square of it is convex in s for the best t.
double distance_by_search(const Vec3d& p1, const Vec3d& d1, const Vec3d& p2, const Vec3d& d2) {
    const auto from_s = [&](double s) {
        const Vec3d x = p1 + s * d1 - p2;
        const double e = dot(d2, d2), t = e > 0 ? std::clamp(dot(x, d2) / e, 0.0, 1.0) : 0.0;
        return norm(x - t * d2);
    };
    double low = 0, high = 1;
    for (int i = 0; i < 200; ++i) {
        const double a = low + (high - low) / 3, b = high - (high - low) / 3;
        (from_s(a) < from_s(b) ? high : low) = from_s(a) < from_s(b) ? b : a;
    }
    return from_s(0.5 * (low + high));
}

TEST(ClosestPoints, AreTheNearest) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto vector = [&] { return Vec3d{normal(random), normal(random), normal(random)}; };
    for (int i = 0; i < 3000; ++i) {
        const Vec3d p1 = vector(), d1 = vector();
        Vec3d p2 = vector(), d2 = vector();
        switch (i % 8) { // general, crossing, parallel, nearly so, in line, end to end, points
        case 1:
            p2 = p1 + 0.3 * d1 - 0.6 * d2;
            break;
        case 2:
            d2 = -0.7 * d1;
            break;
        case 3:
            d2 = d1 + 1e-9 * vector();
            break;
        case 4:
            d2 = d1, p2 = p1 + 1.5 * d1;
            break;
        case 5:
            p2 = p1 + d1;
            break;
        case 6:
            d2 = {0, 0, 0};
            break;
        default:
            break;
        }
        const auto c = closest_points(broadcast<1>(p1), broadcast<1>(d1), broadcast<1>(p2), broadcast<1>(d2));
        const Vec3d apart = lane(c.apart, 0), expected = p2 + c.t[0] * d2 - (p1 + c.s[0] * d1);
        EXPECT_NEAR(norm(apart), distance_by_search(p1, d1, p2, d2), 1e-7) << i;
        EXPECT_NEAR(norm(apart - expected), 0, 1e-14 * 10);
        for (const double share : {c.s[0], c.t[0]}) {
            EXPECT_GE(share, 0);
            EXPECT_LE(share, 1);
        }
    }
}

TEST(ClosestPoints, OfParallelSegmentsAreInTheMiddleOfTheirOverlap) {
    const auto s = [](double shift, double length) {
        return closest_points(broadcast<1>(Vec3d{0, 0, 0}), broadcast<1>(Vec3d{0, 0, 1}),
                              broadcast<1>(Vec3d{0.1, 0, shift}), broadcast<1>(Vec3d{0, 0, length}))
            .s[0];
    };
    EXPECT_DOUBLE_EQ(s(0, 1), 0.5);
    EXPECT_DOUBLE_EQ(s(0.5, 1), 0.75);
    EXPECT_DOUBLE_EQ(s(-0.5, 1), 0.25);
    EXPECT_DOUBLE_EQ(s(0.8, -0.6), 0.5);
    EXPECT_DOUBLE_EQ(s(2, 1), 1);
}

} // namespace
} // namespace skein
