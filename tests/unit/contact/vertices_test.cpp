// Contacts do not know the mesh: neighbouring elements share a contact near their vertex, so that its force does not
// depend on where along a rod it is, nor on how many elements the rod has.
#include "contact/contacts.hpp"
#include "support/exposed_bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace skein {
namespace {

constexpr double length = 75.74e-3, radius = 1.2075e-3, diameter = 2 * radius; // of the nest's rods
constexpr double stiffness = 3.1623e6;

/// A rod bent in a plane by an angle at each vertex: the middle at 0, along x there, its ends upwards where that is
/// above 0.
std::vector<Vec3d> arc(int elements, double angle) {
    std::vector<Vec3d> nodes{{0, 0, 0}};
    for (int k = 0; k < elements; ++k) {
        const double direction = (k - 0.5 * (elements - 1)) * angle;
        nodes.push_back(nodes.back() + (length / elements) * Vec3d{std::cos(direction), 0, std::sin(direction)});
    }
    const auto half = static_cast<std::size_t>(elements / 2);
    const Vec3d middle = elements % 2 ? 0.5 * (nodes[half] + nodes[half + 1]) : nodes[half];
    for (Vec3d& x : nodes) x = x - middle;
    return nodes;
}
Vec3d at(const std::vector<Vec3d>& nodes, double place) { // in elements
    const auto k = std::min(static_cast<std::size_t>(place), nodes.size() - 2);
    return nodes[k] + (place - static_cast<double>(k)) * (nodes[k + 1] - nodes[k]);
}
std::vector<Vec3d> turned_about_z(std::vector<Vec3d> nodes, double angle) {
    for (Vec3d& x : nodes)
        x = {std::cos(angle) * x.x - std::sin(angle) * x.y, std::sin(angle) * x.x + std::cos(angle) * x.y, x.z};
    return nodes;
}
std::vector<Vec3d> moved(std::vector<Vec3d> nodes, const Vec3d& by) {
    for (Vec3d& x : nodes) x += by;
    return nodes;
}
Vec3d nearest_between(const Vec3d& p, const Vec3d& d, const Vec3d& q, const Vec3d& e) {
    return lane(closest_points(broadcast<1>(p), broadcast<1>(d), broadcast<1>(q), broadcast<1>(e)).apart, 0);
}
double distance_between(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double least = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < a.size(); ++i)
        for (std::size_t j = 0; j + 1 < b.size(); ++j)
            least = std::min(least, norm(nearest_between(a[i], a[i + 1] - a[i], b[j], b[j + 1] - b[j])));
    return least;
}

struct Found {
    Vec3d force{0, 0, 0}; ///< on the second
    double weight = 0, energy = 0;
    AlignedVector<ExertedLoad> load; ///< by slot
};
Found push(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b, ContactNormal normal = ContactNormal::hertz,
           double damping = 0) {
    static const Threads one(1);
    test::BodiesByHand rods;
    rods.add(a, radius);
    rods.add(b, radius);
    Contacts contacts(rods.scene(ContactLaw{.normal = normal, .stiffness = stiffness, .damping = damping}), one);
    SlotLoads loads;
    contacts.evaluate(rods.exposure(), 0, 1e-6, loads);
    Found found;
    found.load = loads.load;
    for (std::size_t i = a.size(); i < a.size() + b.size(); ++i) found.force += found.load[i].force;
    found.weight = contacts.figures().weight;
    found.energy = contacts.figures().elastic_energy.value();
    return found;
}

struct Range {
    double least = HUGE_VAL, most = -HUGE_VAL;
    void take(double x) {
        least = std::min(least, x);
        most = std::max(most, x);
    }
};

/// Force of two rods that cross at places of either, over that of one contact with their largest overlap.
Range force_over_place(int elements, double bend_1, double bend_2, double angle, double overlap) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const std::vector<Vec3d> a = arc(elements, bend_1), turned = turned_about_z(arc(elements, -bend_2), angle);
    Range range;
    for (int trial = 0; trial < 60; ++trial) {
        const auto near = [&](int every) { // a vertex, or anywhere
            const double far = trial % every ? 0.5 : 0.08;
            return elements / 2 + far * uniform(random);
        };
        const std::vector<Vec3d> b = moved(turned, at(a, near(2)) - at(turned, near(3)));
        double low = 0.3 * diameter, high = 1.5 * diameter;
        for (int i = 0; i < 50; ++i) {
            const double middle = 0.5 * (low + high);
            (distance_between(a, moved(b, {0, 0, middle})) > (1 - overlap) * diameter ? high : low) = middle;
        }
        const Found found = push(a, moved(b, {0, 0, low}));
        range.take(norm(found.force) / (stiffness * std::pow(overlap * diameter, 1.5)));
    }
    return range;
}

TEST(Vertices, DoNotShowInTheForceOfStraightRods) {
    for (const int elements : {4, 8, 16, 32})
        for (const double overlap : {0.02, 0.1, 0.2})
            for (const double angle : {1.5707963267948966, 0.8, 0.3}) {
                const Range found = force_over_place(elements, 0, 0, angle, overlap);
                EXPECT_GT(found.least, 1 - 1e-7) << elements << " " << overlap << " " << angle;
                EXPECT_LT(found.most, 1 + 1e-7) << elements << " " << overlap << " " << angle;
            }
}

// Of one curvature whatever the number of elements: 0.02 rad at a vertex of eight.
TEST(Vertices, HardlyShowInTheForceOfBentRods) {
    for (const int elements : {8, 16, 32})
        for (const double sign : {1.0, -1.0})
            for (const double overlap : {0.02, 0.1, 0.2})
                for (const double angle : {1.5707963267948966, 0.8}) {
                    const double bend = sign * 0.16 / elements;
                    const Range one = force_over_place(elements, bend, 0, angle, overlap),
                                both = force_over_place(elements, bend, bend, angle, overlap);
                    const auto text = ::testing::Message()
                                      << elements << " " << sign << " " << overlap << " " << angle << ": " << one.least
                                      << " to " << one.most << ", both " << both.least << " to " << both.most;
                    EXPECT_GT(one.least, 0.97) << text;
                    EXPECT_LT(one.most, 1.03) << text;
                    EXPECT_GT(both.least, 0.955) << text;
                    EXPECT_LT(both.most, 1.055) << text;
                }
}

// A corner that the other rod touches from outside is a contact, of one or of both elements.
TEST(Vertices, PushAtCorners) {
    for (const double bend : {0.2, 0.55, 1.0}) {
        const std::vector<Vec3d> a = arc(2, -bend); // its middle node above its ends
        const double overlap = 0.1 * diameter;
        const std::vector<Vec3d> along = moved(arc(8, 0), {0.003, 0, diameter - overlap});
        const Found found = push(a, along);
        const double one = stiffness * std::pow(overlap, 1.5);
        EXPECT_NEAR(norm(found.force), found.weight * one, 0.03 * one) << bend;
        EXPECT_GT(found.weight, 0.97) << bend;
        EXPECT_LT(found.weight, 2.03) << bend;
    }
}

TEST(Vertices, CountAContactOnce) {
    for (const int elements : {8, 32})
        for (const double shift : {0.0, 0.1, 0.25, 0.5}) {
            const double l = length / elements;
            const Found found =
                push(arc(elements, 0), moved(turned_about_z(arc(elements, 0), 1.2), {shift * l, 0, 0.9 * diameter}));
            EXPECT_NEAR(found.weight, 1, 1e-5);
        }
}

// Rods side by side push with as many contacts as elements lie beside each other, wherever their vertices are.
TEST(Vertices, DoNotShowWhereRodsSlideAlongEachOther) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const double turn : {1.0, -1.0}) { // the second leads the same way, or the other
            const double l = length / 8,
                         one = push(arc(8, 0), moved(arc(8, 0), {0, 0, 0.9 * diameter}), normal).force.z;
            for (double shift = 0; shift < 3; shift += 0.05) {
                std::vector<Vec3d> other = arc(8, 0);
                for (Vec3d& x : other) x.x *= turn;
                const Found found = push(arc(8, 0), moved(other, {shift * l, 0, 0.9 * diameter}), normal);
                EXPECT_NEAR(found.force.z, (8 - shift) / 8 * one, 1e-9 * one) << shift;
                EXPECT_NEAR(found.weight, 8 - shift, 1e-5) << shift;
            }
        }
}

/// Most of a turn of a coil about z, from `start` on; `l`: length of its elements.
std::vector<Vec3d> coil(double l, double angle, double start) {
    std::vector<Vec3d> nodes;
    const double coil_radius = 0.5 * l / std::sin(0.5 * angle);
    for (double turn = start; turn < start + 5; turn += angle)
        nodes.push_back(coil_radius * Vec3d{std::cos(turn), std::sin(turn), 0});
    return nodes;
}

// Coils that lie on each other turn together, so each element pushes, wherever its vertices are beside those of the
// other coil.
TEST(Vertices, LeaveNoCoilsSoftSideBySide) {
    for (const double overlap : {0.02, 0.1})
        for (const double l : {0.25 * diameter, 0.5 * diameter, 2 * diameter})
            for (const double angle : {0.1, 0.2, 0.35, 0.5, 0.8}) {
                Range found;
                const std::vector<Vec3d> below = coil(l, angle, 0);
                const double one =
                    stiffness * std::pow(overlap * diameter, 1.5) * static_cast<double>(below.size() - 1);
                for (double phase = 0; phase < 1; phase += 0.05)
                    found.take(
                        push(below, moved(coil(l, angle, phase * angle), {0, 0, (1 - overlap) * diameter})).force.z /
                        one);
                EXPECT_GT(found.least, 0.99) << overlap << " " << l << " " << angle;
                EXPECT_LT(found.most, 3) << overlap << " " << l << " " << angle;
            }
}

/// A crooked rod about its middle, with a turn of up to `bend` at each vertex.
std::vector<Vec3d> crooked(int elements, double bend, double turn, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    Vec3d way{std::cos(turn), std::sin(turn), 0};
    std::vector<Vec3d> nodes{{0, 0, 0}};
    for (int k = 0; k < elements; ++k) {
        nodes.push_back(nodes.back() + (length / elements) * way);
        const Vec3d next = way + bend * Vec3d{uniform(random), uniform(random), uniform(random)};
        way = (1 / norm(next)) * next;
    }
    return moved(nodes, -nodes[nodes.size() / 2]);
}

// Of rods that are straight or crooked, of like radii and of unlike ones, crossing, at shallow angles and side by side:
// the force on every node is minus the slope of the energy that is in the contacts, which is found from places alone.
TEST(Vertices, LeaveForcesMinusTheGradientOfTheEnergy) {
    static const Threads one(1);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    int near_parallel = 0, bent = 0, compared = 0, at_kinks = 0;
    for (int trial = 0; trial < 240; ++trial) {
        const double ratios[] = {1, 10, 33, 100}, ratio = ratios[trial % 4], thick = ratio * radius, l = length / 5,
                     angles[] = {1.4, 0.3, 0},
                     angle = (trial / 4 % 3 == 2 ? 0.06 : 0.15) * uniform(random) + angles[trial / 4 % 3],
                     bend = trial % 5 == 0  ? 0
                            : trial % 5 < 3 ? 0.03
                                            : 0.3;
        std::vector<Vec3d> a = crooked(5, bend, 0, random), b = crooked(4, 0.2 * bend, angle, random);
        for (Vec3d& x : b) x = std::sqrt(ratio) * x;
        a = moved(a, {l * uniform(random), l * uniform(random), 0.97 * (radius + thick)});
        test::BodiesByHand rods;
        rods.add(a, radius);
        rods.add(b, thick);
        Contacts contacts(rods.scene(ContactLaw{.normal = trial % 2 ? ContactNormal::hertz : ContactNormal::linear,
                                                .stiffness = stiffness}),
                          one);
        SlotLoads loads;
        Exposure bodies = rods.exposure();
        contacts.evaluate(bodies, 0, 1e-6, loads);
        const auto energy = [&] {
            double sum = 0;
            for (const double one_of_them : contacts.normal_energies(bodies)) sum += one_of_them;
            return sum;
        };
        const double here = energy();
        if (here == 0) continue;
        near_parallel += std::abs(std::sin(angle))<0.05, bent += bend> 0;
        ++compared;
        double size = 0, worst = 0;
        for (std::size_t i = 0; i < bodies.slots(); ++i) size = std::max(size, norm(loads.load[i].force));
        for (std::size_t i = 0; i < bodies.slots(); ++i)
            for (double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
                const double step = 2e-7 * diameter, was = bodies.node[i].position.*axis;
                const auto at = [&](double x) {
                    bodies.node[i].position.*axis = x;
                    return energy();
                };
                const double slope = (at(was + step) - at(was - step)) / (2 * step);
                bodies.node[i].position.*axis = was;
                worst = std::max(worst, std::abs(loads.load[i].force.*axis + slope));
            }
        if (worst > 2e-4 * size) ++at_kinks; // forces there have a kink, or a jump within the step
        EXPECT_LT(worst, 0.05 * size) << trial << ", ratio " << ratio << ", angle " << angle;
    }
    EXPECT_GT(compared, 150);
    EXPECT_GT(near_parallel, 30);
    EXPECT_GT(bent, 100);
    EXPECT_LE(at_kinks, 5);
}

// The energy of crooked rods has no jump on any way.
TEST(Vertices, LeaveNoJumps) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    int jumps = 0;
    for (int trial = 0; trial < 150; ++trial) {
        const int elements = trial % 2 ? 8 : 32;
        const double bend = (trial % 5 ? 0.4 : 2.0) / elements, angles[] = {1.5, 0.15, 0.05, 0.05},
                     angle = angles[trial % 4] * uniform(random) + (trial % 4 == 2 ? 3.14159265 : 0);
        const std::vector<Vec3d> a = crooked(elements, bend, 0, random), b = crooked(elements, bend, angle, random);
        const Vec3d from{length * uniform(random), 0.05 * length * uniform(random),
                         (0.65 + 0.35 * uniform(random)) * diameter},
            way = 0.2 * length * Vec3d{uniform(random), uniform(random), 0.05 * uniform(random)};
        const auto at_place = [&](double x) { return push(a, turned_about_z(moved(b, from + x * way), 0.1 * x)); };
        double before = at_place(0).energy;
        constexpr int steps = 400;
        for (int i = 1; i <= steps; ++i) {
            const double now = at_place(static_cast<double>(i) / steps).energy;
            double low = static_cast<double>(i - 1) / steps, high = static_cast<double>(i) / steps, e_low = before,
                   e_high = now;
            before = now;
            while (std::abs(e_high - e_low) > 1e-4 * std::max(e_high, e_low) &&
                   high - low > 1e-10) { // the half that changes more
                const double middle = 0.5 * (low + high), e = at_place(middle).energy;
                if (std::abs(e - e_low) > std::abs(e_high - e)) {
                    high = middle;
                    e_high = e;
                } else {
                    low = middle;
                    e_low = e;
                }
            }
            jumps += high - low <= 1e-10;
        }
    }
    EXPECT_EQ(jumps, 0);
}

// Pressed by a constant force and drawn without friction over another rod, a rod stays at its height.
TEST(Vertices, AreNoBumpsOnTheWay) {
    for (const int elements : {8, 32}) {
        const std::vector<Vec3d> a = arc(elements, 0), b = turned_about_z(arc(elements, 0), 1.3);
        const double l = length / elements, force = stiffness * std::pow(0.1 * diameter, 1.5);
        double before = 0, steepest = 0;
        const double step = 0.01 * l;
        for (double x = 0; x < 1.2 * l; x += step) {
            double low = 0.5 * diameter, high = diameter;
            for (int i = 0; i < 40; ++i) {
                const double middle = 0.5 * (low + high);
                (push(a, moved(b, {x, 0.3 * x, middle})).force.z > force ? low : high) = middle;
            }
            if (x > 0) steepest = std::max(steepest, std::abs(low - before) / step);
            before = low;
        }
        EXPECT_LT(steepest, 1e-8);
    }
}

} // namespace
} // namespace skein
