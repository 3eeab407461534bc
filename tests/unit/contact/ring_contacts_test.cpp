// Rings that touch themselves: elements are neighbours where the ring closes as everywhere else, and where its numbers
// begin does not matter.
#include "contact/contacts.hpp"
#include "core/closest_points.hpp"
#include "skein/core/index.hpp"
#include "support/exposed_bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <set>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

/// A smooth closed curve of three harmonics, about 1 m wide.
struct Loop {
    Vec3d cosine[3], sine[3];

    explicit Loop(unsigned seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        for (int m = 0; m < 3; ++m)
            for (Vec3d* of : {&cosine[m], &sine[m]})
                *of = (0.5 / (m + 1)) * Vec3d{normal(random), normal(random), 0.3 * normal(random)};
    }
    /// A figure of eight whose strands are `apart` where they cross.
    static Loop eight(double apart) {
        Loop loop(0);
        for (int m = 0; m < 3; ++m) loop.cosine[m] = loop.sine[m] = {0, 0, 0};
        loop.sine[0] = {1, 0, 0.5 * apart}; // crosses itself at 0 and pi
        loop.cosine[0] = {0, 0, 0.5 * apart};
        loop.sine[1] = {0, 0.7, 0};
        return loop;
    }
    Vec3d at(double angle) const {
        Vec3d x{0, 0, 0};
        for (int m = 0; m < 3; ++m) x += std::cos((m + 1) * angle) * cosine[m] + std::sin((m + 1) * angle) * sine[m];
        return x;
    }
    Vec3d rate(double angle) const {
        Vec3d v{0, 0, 0};
        for (int m = 0; m < 3; ++m)
            v += (m + 1) * (std::cos((m + 1) * angle) * sine[m] - std::sin((m + 1) * angle) * cosine[m]);
        return v;
    }
};

/// Nodes of a ring and a rod beside it. `first`: the node at which the ring's numbers begin.
struct RingAndRod {
    std::vector<Vec3d> ring, velocity, spin, rod;
    double radius;
    std::int32_t gap;

    RingAndRod(const Loop& loop, int n, double shift, double speed, double radius_, std::int32_t gap_)
        : radius(radius_), gap(gap_) {
        for (int i = 0; i < n; ++i) {
            const double angle = 2 * pi * i / n + shift;
            ring.push_back(loop.at(angle));
            velocity.push_back(speed * loop.rate(angle));
            spin.push_back({std::sin(3 * angle), std::cos(angle), 0.2});
        }
        for (const double s : {-0.7, -0.1, 0.4, 1.1}) rod.push_back(ring[0] + Vec3d{s, 0.1 * s, radius + 0.3 * s});
    }
    std::size_t n() const { return ring.size(); }
    test::BodiesByHand bodies(std::size_t first) const {
        test::BodiesByHand all;
        std::vector<Vec3d> nodes;
        for (std::size_t i = 0; i <= n(); ++i) nodes.push_back(ring[(first + i) % n()]);
        all.add(nodes, radius, gap, true);
        all.add(rod, radius);
        return all;
    }
    Exposure exposure(std::size_t first) const {
        Exposure shown = bodies(first).exposure();
        for (std::size_t i = 0; i <= n(); ++i) {
            shown.motion[i].velocity = velocity[(first + i) % n()];
            if (i < n()) shown.motion[i].spin = spin[(first + i) % n()];
        }
        return shown;
    }
};

struct FoldedLoads {
    std::vector<Vec3d> force, couple; ///< of the ring's nodes and elements in their own order, then of the rod's slots
};

/// What the passes make of the loads: the last slot of a ring hands its force to the first.
FoldedLoads folded(const RingAndRod& from, std::size_t first, const SlotLoads& loads) {
    const std::size_t n = from.n();
    FoldedLoads all{std::vector<Vec3d>(n, Vec3d{0, 0, 0}), std::vector<Vec3d>(n, Vec3d{0, 0, 0})};
    if (loads.touched[0])
        for (std::size_t i = 0; i <= n; ++i) {
            all.force[(first + i) % n] += loads.load[i].force;
            all.couple[(first + i) % n] += loads.load[i].couple;
        }
    for (std::size_t i = n + 1; i < loads.load.size(); ++i) {
        all.force.push_back(loads.touched[1] ? loads.load[i].force : Vec3d{0, 0, 0});
        all.couple.push_back(loads.touched[1] ? loads.load[i].couple : Vec3d{0, 0, 0});
    }
    return all;
}

/// The rule by itself, over all pairs: nearer than that both ways round the ring, elements do not touch.
std::set<std::pair<int, int>> pairs_by_looking(const std::vector<Vec3d>& ring, double radius, int gap, double skin) {
    std::set<std::pair<int, int>> near;
    const int n = static_cast<int>(ring.size());
    const auto node = [&](int i) { return nth(ring, i % n); };
    for (int i = 0; i < n; ++i)
        for (int j = i + 1; j < n; ++j) {
            if (std::min(j - i, n - (j - i)) <= gap) continue;
            const auto closest = closest_points(broadcast<1>(node(i)), broadcast<1>(node(i + 1) - node(i)),
                                                broadcast<1>(node(j)), broadcast<1>(node(j + 1) - node(j)));
            if (norm(lane(closest.apart, 0)) < 2 * radius + skin) near.emplace(i, j);
        }
    return near;
}

TEST(RingContacts, AreOfElementsThatAreNoNeighboursEitherWayRound) {
    const Threads one(1), three(3);
    std::size_t over_the_vertex = 0, pairs = 0;
    for (unsigned seed = 0; seed < 300; ++seed) {
        const int n = 8 + static_cast<int>(seed % 33);
        const Loop loop(seed);
        std::vector<Vec3d> ring;
        for (int i = 0; i < n; ++i) ring.push_back(loop.at(2 * pi * i / n));
        for (const double radius : {0.02, 0.1, 0.3})
            for (const int gap : {0, 1, 2, n / 4, n / 2}) {
                test::BodiesByHand bodies;
                std::vector<Vec3d> nodes = ring;
                nodes.push_back(ring[0]);
                bodies.add(nodes, radius, gap, true);
                const auto expected = pairs_by_looking(ring, radius, gap, 0.05);
                for (const Threads* threads : {&one, &three}) {
                    BroadPhase search(*threads);
                    Candidates found;
                    search.build(bodies.exposure(), bodies.rules, 0.05, found);
                    std::set<std::pair<int, int>> got;
                    for (std::uint32_t a = 0; a + 1 < found.first.size(); ++a)
                        for (std::uint32_t k = found.first[a]; k < found.first[a + 1]; ++k)
                            got.emplace(static_cast<int>(a), static_cast<int>(found.partner[k]));
                    ASSERT_EQ(got, expected) << seed << ", radius " << radius << ", gap " << gap;
                }
                Candidates all;
                BroadPhase::build_exhaustively(bodies.exposure(), bodies.rules, 0.05, all);
                ASSERT_EQ(all.count(), expected.size());
                pairs += expected.size();
                for (const auto& [i, j] : expected) over_the_vertex += n - (j - i) < j - i;
            }
    }
    EXPECT_GT(pairs, 100000u);
    EXPECT_GT(over_the_vertex, pairs / 10) << "nearest round by way of the vertex";
}

/// Near-parallel elements meet at the ends of their overlap along the first of them: with the other first it is a
/// little different.
bool crosses_steeply(const Contacts& contacts, const Exposure& bodies) {
    for (const Contact& c : contacts.active(bodies)) {
        const auto edge = [&](std::uint32_t slot) {
            return bodies.node[slot + 1].position - bodies.node[slot].position;
        };
        const Vec3d a = edge(c.pair.a), b = edge(c.pair.b);
        if (norm(cross(a, b)) < 0.06 * norm(a) * norm(b)) return false;
    }
    return true;
}

TEST(RingContacts, DoNotDependOnWhereTheRingBegins) {
    const Threads one(1);
    int rings = 0;
    for (const ContactFriction friction : {ContactFriction::none, ContactFriction::regularised})
        for (unsigned seed = 0; seed < 60; ++seed) {
            const int n = 8 + static_cast<int>(seed % 33);
            const RingAndRod from(Loop(seed), n, 0, 0.3, 0.05, 1 + static_cast<int>(seed % 3));
            FoldedLoads expected;
            double size = 0;
            for (std::size_t first = 0; first < static_cast<std::size_t>(n); ++first) {
                const Exposure shown = from.exposure(first);
                Contacts contacts(from.bodies(first).scene(test::some_law(ContactNormal::hertz, friction)), one);
                SlotLoads out;
                contacts.evaluate(shown, 0, 1e-4, out);
                const FoldedLoads loads = folded(from, first, out);
                if (first == 0) {
                    if (contacts.figures().active == 0 || !crosses_steeply(contacts, shown)) break;
                    expected = loads;
                    for (const Vec3d& f : loads.force) size = std::max(size, norm(f));
                    ++rings;
                    continue;
                }
                for (std::size_t i = 0; i < loads.force.size(); ++i) {
                    ASSERT_LT(norm(loads.force[i] - expected.force[i]), 1e-10 * size)
                        << seed << ": " << first << ", slot " << i;
                    ASSERT_LT(norm(loads.couple[i] - expected.couple[i]), 1e-10 * size)
                        << seed << ": " << first << ", slot " << i;
                }
            }
        }
    EXPECT_GT(rings, 40);
}

// A ring that slides along itself: where it crosses itself, contacts go from element to element, with their springs,
// and where it closes as well.
TEST(RingContacts, KeepTheirSpringsWhereTheRingCloses) {
    const Threads one(1);
    constexpr int n = 25, steps = 240; // odd: the two strands pass their vertices at different times
    constexpr double radius = 0.05, h = 1e-4, element = 2 * pi / n;
    const Loop loop = Loop::eight(1.9 * radius);
    const ContactLaw law{.normal = ContactNormal::linear,
                         .stiffness = 1e5,
                         .friction = ContactFriction::memory,
                         .static_friction = 1e3,
                         .kinetic_friction = 1e3}; // never slides
    std::vector<FoldedLoads> expected;
    double size = 0;
    for (const std::size_t first :
         {6, 24, 23, 12, 11}) { // 6: closes far from the crossing all the way; the others pass it
        SlotLoads out;
        std::optional<Contacts> contacts;
        for (int step = 0; step < steps; ++step) {
            // Over two and a half elements; what moves relatively is told apart from the way, so that springs stay
            // short.
            const double shift = 0.3 * element + 2.5 * element * step / steps;
            const RingAndRod from(loop, n, shift, step < 20 ? 0.01 : 0, radius, 2);
            if (!contacts) contacts.emplace(from.bodies(first).scene(law), one);
            contacts->evaluate(from.exposure(first), 0, h, out);
            FoldedLoads loads = folded(from, first, out);
            if (first == 6) {
                for (std::size_t i = 0; i < n; ++i) size = std::max(size, norm(loads.force[i]));
                expected.push_back(std::move(loads));
                continue;
            }
            for (std::size_t i = 0; i < loads.force.size(); ++i)
                ASSERT_LT(norm(loads.force[i] - nth(expected, step).force[i]), 1e-9 * size)
                    << "begins at " << first << ", step " << step << ", slot " << i;
        }
        EXPECT_GT(contacts->figures().elastic_energy.value(), 0);
    }
}

TEST(RingContacts, AreBalanced) {
    const Threads one(1);
    for (const ContactFriction friction :
         {ContactFriction::none, ContactFriction::memory, ContactFriction::regularised})
        for (unsigned seed = 0; seed < 60; ++seed) {
            const RingAndRod from(Loop(seed), 8 + static_cast<int>(seed % 33), 0, 0.3, 0.1, 1);
            const Exposure shown = from.exposure(0);
            Contacts contacts(from.bodies(0).scene(test::some_law(ContactNormal::hertz, friction)), one);
            SlotLoads out;
            for (int step = 0; step < 3; ++step) contacts.evaluate(shown, 0, 1e-4, out);
            if (contacts.figures().active == 0) continue;
            const FoldedLoads loads = folded(from, 0, out);
            Vec3d force{0, 0, 0}, moment{0, 0, 0};
            double size = 0;
            for (std::size_t i = 0; i < loads.force.size(); ++i) {
                const Vec3d at = i < from.n() ? from.ring[i] : from.rod[i - from.n()];
                force += loads.force[i];
                moment += cross(at, loads.force[i]) + loads.couple[i];
                size += norm(loads.force[i]);
            }
            EXPECT_LT(norm(force), 1e-12 * size) << seed;
            EXPECT_LT(norm(moment), 1e-11 * size) << seed;
        }
}

} // namespace
} // namespace skein
