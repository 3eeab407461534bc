// Contacts push, are balanced, remember, and change with places without jumps.
#include "contact/contacts.hpp"
#include "support/exposed_bodies.hpp"

#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

/// Straight rods of equal elements between two points each.
test::BodiesByHand rods_between(const std::vector<std::pair<Vec3d, Vec3d>>& ends, int elements, double radius) {
    test::BodiesByHand bodies;
    for (const auto& [from, to] : ends) {
        std::vector<Vec3d> nodes;
        for (int k = 0; k <= elements; ++k) nodes.push_back(from + (static_cast<double>(k) / elements) * (to - from));
        bodies.add(nodes, radius);
    }
    return bodies;
}

TEST(Contacts, AreBalanced) {
    const Threads one(1);
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    const auto vector = [&](double size) {
        return Vec3d{size * normal(random), size * normal(random), size * normal(random)};
    };
    for (const ContactNormal law : {ContactNormal::linear, ContactNormal::hertz})
        for (const ContactFriction friction :
             {ContactFriction::none, ContactFriction::memory, ContactFriction::regularised})
            for (int scene = 0; scene < 50; ++scene) {
                // Two rods at a time: crossing, or side by side but for a small angle.
                const Vec3d along = vector(1), other = scene % 2 ? along + vector(0.01) : vector(1),
                            apart = vector(0.02);
                const auto rods = rods_between({{-along, along}, {apart - other, apart + other}}, 7, 0.05);
                Exposure c = rods.exposure();
                for (ExposedMotion& m : c.motion) m = {.velocity = vector(1), .spin = vector(10)};
                Contacts contacts(rods.scene(test::some_law(law, friction)), one);
                SlotLoads out;
                AlignedVector<ExertedLoad>& loads = out.load;
                for (int step = 0; step < 3; ++step) contacts.evaluate(c, 0, 1e-4, out);
                Vec3d force{0, 0, 0}, moment{0, 0, 0};
                double size = 0;
                for (std::size_t i = 0; i < c.slots(); ++i) {
                    force += loads[i].force;
                    moment += cross(c.node[i].position, loads[i].force) + loads[i].couple;
                    size += norm(loads[i].force);
                }
                ASSERT_GT(size, 0);
                EXPECT_LT(norm(force), 1e-12 * size);
                EXPECT_LT(norm(moment), 1e-12 * size * norm(along));
            }
}

TEST(Contacts, NeverPull) {
    const Threads one(1);
    for (const ContactNormal law : {ContactNormal::linear, ContactNormal::hertz}) {
        const auto rods = rods_between({{{-1, 0, 0}, {1, 0, 0}}, {{0.03, -1, 0.09}, {0.03, 1, 0.09}}}, 1, 0.05);
        Exposure c = rods.exposure();
        Contacts contacts(rods.scene(ContactLaw{.normal = law, .stiffness = 1e5, .damping = 1e4}), one);
        SlotLoads out;
        AlignedVector<ExertedLoad>& loads = out.load;
        for (const double speed : {-100.0, -1.0, 0.0, 1.0, 100.0}) {
            c.motion[2].velocity = c.motion[3].velocity = {0, 0, speed};
            contacts.evaluate(c, 0, 1e-4, out);
            EXPECT_GE(loads[2].force.z, 0) << speed;
            EXPECT_LE(loads[0].force.z, 0) << speed;
            if (speed <= 0) {
                EXPECT_GT(loads[2].force.z, 0) << speed;
            }
        }
    }
}

/// Without friction and dashpots what rods feel is minus the gradient of the energy that is in contacts: crossing
/// elements, near-parallel ones at any angle of the range in which their ends take a share, beside each other and end
/// over end.
TEST(Contacts, AreMinusTheGradientOfTheirEnergy) {
    const Threads one(1);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const double radius = 0.05, step = 1e-6;
    int near_parallel = 0;
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (int trial = 0; trial < 200; ++trial) {
            const double angle = trial % 4 == 0 ? 1.5 * uniform(random) : 0.06 * uniform(random);
            const Vec3d at{uniform(random), 0.02 * uniform(random), 0.09},
                along{(trial % 3 ? 0.7 : -0.7) * std::cos(angle), 0.7 * std::sin(angle), 0.01 * uniform(random)};
            const std::vector<Vec3d> nodes{{-0.5, 0, 0}, {0.5, 0, 0}, at - along, at + along};
            SlotLoads out;
            const auto energy = [&](const std::vector<Vec3d>& x) {
                test::BodiesByHand rods;
                rods.add(std::span(x).first(2), radius);
                rods.add(std::span(x).last(2), radius);
                Contacts contacts(rods.scene(ContactLaw{.normal = normal, .stiffness = 1e5}), one);
                contacts.evaluate(rods.exposure(), 0, 1e-4, out);
                return contacts.figures().elastic_energy.value();
            };
            if (energy(nodes) == 0) continue;
            near_parallel += std::abs(std::sin(angle)) < 0.05;
            std::vector<Vec3d> force;
            double size = 0;
            for (std::size_t i = 0; i < 4; ++i) {
                force.push_back(out.load[i].force);
                size = std::max(size, norm(force[i]));
            }
            for (std::size_t i = 0; i < 4; ++i)
                for (double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
                    std::vector<Vec3d> there = nodes, back = nodes;
                    there[i].*axis += step;
                    back[i].*axis -= step;
                    EXPECT_NEAR(force[i].*axis, -(energy(there) - energy(back)) / (2 * step), 1e-5 * size)
                        << trial << ", node " << i;
                }
        }
    EXPECT_GT(near_parallel, 100);
}

TEST(Contacts, OfALawKnownInClosedForm) {
    const Threads one(1);
    const auto rods = rods_between({{{-1, 0, 0}, {1, 0, 0}}, {{0.5, -1, 0.09}, {0.5, 1, 0.09}}}, 1, 0.05);
    Exposure c = rods.exposure();
    SlotLoads out;
    AlignedVector<ExertedLoad>& loads = out.load;
    Contacts linear(rods.scene(ContactLaw{.normal = ContactNormal::linear, .stiffness = 1e5}), one);
    linear.evaluate(c, 0, 1e-4, out);
    EXPECT_NEAR(loads[2].force.z + loads[3].force.z, 1e5 * 0.01, 1e-8);
    EXPECT_NEAR(loads[1].force.z, -0.75 * 1e5 * 0.01, 1e-8) << "three quarters along the first";
    Contacts hertz(rods.scene(ContactLaw{.normal = ContactNormal::hertz, .stiffness = 1e5}), one);
    hertz.evaluate(c, 0, 1e-4, out);
    EXPECT_NEAR(loads[2].force.z + loads[3].force.z, 1e5 * 0.001, 1e-9);
    EXPECT_EQ(hertz.figures().active, 1);
    EXPECT_NEAR(hertz.figures().max_overlap, 0.1, 1e-12);
}

/// Largest change of the force on the second of two rods along a path of places, over the whole change: small for a
/// smooth force.
template <class Place> double largest_jump(Place place, int steps) {
    const Threads one(1);
    double jump = 0, sum = 0;
    Vec3d before{0, 0, 0};
    for (int i = 0; i <= steps; ++i) {
        const auto rods = place(static_cast<double>(i) / steps);
        const Exposure c = rods.exposure();
        Contacts contacts(rods.scene(ContactLaw{.normal = ContactNormal::linear, .stiffness = 1e5}), one);
        SlotLoads out;
        AlignedVector<ExertedLoad>& loads = out.load;
        contacts.evaluate(c, 0, 1e-4, out);
        Vec3d force{0, 0, 0}, moment{0, 0, 0};
        for (std::size_t s = c.window[1].first_slot; s < c.slots(); ++s) {
            force += loads[s].force;
            moment += cross(c.node[s].position, loads[s].force);
        }
        const Vec3d now = force + moment;
        if (i > 0) {
            jump = std::max(jump, norm(now - before));
            sum += norm(now - before);
        }
        before = now;
    }
    EXPECT_GT(sum, 0);
    return jump / sum;
}

TEST(Contacts, ChangeWithoutJumps) {
    const auto turning = [](double x) { // about its middle, through parallel
        const double angle = 0.3 * (x - 0.5);
        const Vec3d along{std::cos(angle), std::sin(angle), 0};
        return rods_between({{{-1, 0, 0}, {1, 0, 0}}, {Vec3d{0.1, 0, 0.09} - along, Vec3d{0.1, 0, 0.09} + along}}, 4,
                            0.05);
    };
    const auto sliding = [](double x) { // nearly parallel, end over end
        const Vec3d at{4 * x - 2.0011, 0, 0.09};
        return rods_between({{{-1, 0, 0}, {1, 0, 0}}, {at - Vec3d{1, 0.001, 0}, at + Vec3d{1, 0.001, 0}}}, 4, 0.05);
    };
    const auto crossing = [](double x) { // over vertices and ends
        const double at = 2.4 * (x - 0.5);
        return rods_between({{{-1, 0, 0}, {1, 0, 0}}, {{at, -1, 0.07}, {at + 0.2, 1, 0.09}}}, 4, 0.05);
    };
    EXPECT_LT(largest_jump(turning, 4000), 0.006);
    EXPECT_LT(largest_jump(sliding, 4000), 0.006);
    EXPECT_LT(largest_jump(crossing, 4000), 0.006);
    // Jumps do not shrink with the steps; slopes do.
    EXPECT_LT(largest_jump(turning, 16000), 0.4 * largest_jump(turning, 4000));
    // What parts rods along each other, the energy over an element's length, turns round where equal ones lie abreast.
    EXPECT_LT(largest_jump(sliding, 16000), 0.003);
    EXPECT_LT(largest_jump(crossing, 16000), 0.4 * largest_jump(crossing, 4000));
}

TEST(Contacts, StickUntilTheySlide) {
    const Threads one(1);
    const auto rods = rods_between({{{-1, 0, 0}, {1, 0, 0}}, {{0, -1, 0.09}, {0, 1, 0.09}}}, 1, 0.05);
    Exposure c = rods.exposure();
    const ContactLaw law{.normal = ContactNormal::linear,
                         .stiffness = 1e5,
                         .friction = ContactFriction::memory,
                         .static_friction = 0.5,
                         .kinetic_friction = 0.4};
    Contacts contacts(rods.scene(law), one);
    SlotLoads out;
    AlignedVector<ExertedLoad>& loads = out.load;
    const double h = 1e-4, speed = 0.01, normal = 1e5 * 0.01;
    for (const std::size_t i : {2, 3}) c.motion[i].velocity = {speed, 0, 0};
    double slid = 0;
    for (int step = 1; step <= 20000; ++step) {
        contacts.evaluate(c, 0, h, out); // places stay, so that the normal force does
        slid += h * speed;
        const double drag = -(loads[2].force.x + loads[3].force.x), spring = 0.8e5 * slid;
        if (spring <= 0.5 * normal) {
            ASSERT_NEAR(drag, spring, 1e-9 * normal) << step;
        } else {
            ASSERT_GT(drag, 0.4 * normal * (1 - 1e-9)) << step;
            ASSERT_LE(drag, 0.5 * normal * (1 + 1e-9)) << step;
        }
    }
    // Turned round, the spring goes back before it slides the other way.
    for (const std::size_t i : {2, 3}) c.motion[i].velocity = {-speed, 0, 0};
    contacts.evaluate(c, 0, h, out);
    EXPECT_GT(-(loads[2].force.x + loads[3].force.x), 0.3 * normal);
}

TEST(Contacts, KeepTheirSpringsOverVertices) {
    const Threads one(1);
    const ContactLaw law{.normal = ContactNormal::linear,
                         .stiffness = 1e5,
                         .friction = ContactFriction::memory,
                         .static_friction = 0.5,
                         .kinetic_friction = 0.5};
    const auto rods = [](double x) {
        return rods_between({{{-1, 0, 0}, {1, 0, 0}}, {{x, -0.9, 0.09}, {x, 1.1, 0.09}}}, 8, 0.05);
    };
    const auto crossing = [&](double x, double speed) {
        Exposure c = rods(x).exposure();
        for (std::size_t i = 9; i < 18; ++i) c.motion[i].velocity = {speed, 0, 0};
        return c;
    };
    Contacts contacts(rods(0).scene(law), one);
    SlotLoads out;
    AlignedVector<ExertedLoad>& loads = out.load;
    const auto drag = [&] {
        double sum = 0;
        for (std::size_t i = 9; i < 18; ++i) sum -= loads[i].force.x;
        return sum;
    };
    const double h = 1e-4, loaded = 0.8e5 * 30 * h;
    for (int step = 0; step < 30; ++step)
        contacts.evaluate(crossing(-0.13, 1), 0, h, out); // in place: loads the spring
    EXPECT_NEAR(drag(), loaded, 1e-9 * loaded);
    for (const double x : {-0.08, -0.05, -0.02, -0.001, 0.001, 0.02, 0.05, 0.08, 0.13}) { // goes on without slip
        contacts.evaluate(crossing(x, 0), 0, h, out);
        contacts.evaluate(crossing(x, 0), 0, h, out);
        EXPECT_GT(drag(), 0.9 * loaded) << x;
        EXPECT_LT(drag(), 3 * loaded)
            << x; // while both elements touch: two springs, and the round end leans against the other rod
    }
    EXPECT_EQ(contacts.figures().active, 1);
    EXPECT_EQ(contacts.active(crossing(0.13, 0))[0].pair.a, 4u) << "the next element";
    EXPECT_NEAR(drag(), loaded, 0.01 * loaded);
}

TEST(Contacts, AreTheSameForAnyThreads) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform;
    std::vector<std::pair<Vec3d, Vec3d>> ends;
    const auto point = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
    for (int i = 0; i < 300; ++i) {
        const Vec3d a = point(), along = point() - point();
        ends.emplace_back(a, a + (0.4 / norm(along)) * along);
    }
    const auto rods = rods_between(ends, 6, 0.01);
    Exposure c = rods.exposure();
    for (ExposedMotion& m : c.motion) m.velocity = point() - point();
    const auto run = [&](int threads) {
        const Threads team(threads);
        Exposure moving = c;
        Contacts contacts(rods.scene(test::some_law(ContactNormal::hertz, ContactFriction::memory)), team);
        SlotLoads out;
        AlignedVector<ExertedLoad>& loads = out.load;
        for (int step = 0; step < 60; ++step) {
            for (std::size_t i = 0; i < moving.slots(); ++i)
                moving.node[i].position += 1e-4 * moving.motion[i].velocity;
            contacts.evaluate(moving, 0, 1e-4, out);
        }
        EXPECT_GT(contacts.figures().active, 100);
        EXPECT_GT(contacts.figures().rebuilds, 1);
        return loads;
    };
    const AlignedVector<ExertedLoad> one = run(1), three = run(3);
    for (std::size_t i = 0; i < one.size(); ++i) {
        ASSERT_EQ(norm(one[i].force - three[i].force), 0) << i;
        ASSERT_EQ(norm(one[i].couple - three[i].couple), 0) << i;
    }
}

} // namespace
} // namespace skein
