// Rigid bodies alone: masses, inertia and axes against integrals, free tops against closed forms, and what a force
// does.
#include "core/principal_axes.hpp"
#include "diagnostics/observables.hpp"
#include "mechanics/body.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/kick.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "support/free_top.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

/// Mass, centre and tensor about the origin.
struct Integrals {
    double mass = 0;
    Vec3d first{0, 0, 0};
    SymmetricMatrix second;
    void add(double m, const Vec3d& x) {
        mass += m;
        first += m * x;
        const double squared = dot(x, x);
        second += {m * (squared - x.x * x.x),
                   m * (squared - x.y * x.y),
                   m * (squared - x.z * x.z),
                   -m * x.x * x.y,
                   -m * x.x * x.z,
                   -m * x.y * x.z};
    }
    /// Of the solid about the axis from a to b, by Gauss's points along it and across: sections are circles of
    /// radius(z), z from a.
    void add_round(const Vec3d& a, const Vec3d& b, double from, double to, double density,
                   const std::function<double(double)>& radius) {
        const Vec3d axis = unit(b - a);
        const auto [u, v] = directions_across(axis);
        constexpr int n = 2000, around = 8;
        for (int i = 0; i < n; ++i) {
            const double dz = (to - from) / n, z = from + (i + 0.5) * dz, r = radius(z),
                         ring = std::sqrt(0.5) * r; // of gyration
            for (int k = 0; k < around; ++k) {
                const double angle = 2 * pi * k / around;
                add(density * pi * r * r * dz / around,
                    a + z * axis + (ring * std::cos(angle)) * u + (ring * std::sin(angle)) * v);
            }
        }
    }
    void add_capsule(const Vec3d& a, const Vec3d& b, double r, double density) {
        const bool ball = norm(b - a) == 0;
        const Vec3d end = ball ? a + Vec3d{0, 0, 1} : b;
        const double l = ball ? 0 : norm(b - a);
        if (!ball) add_round(a, end, 0, l, density, [r](double) { return r; });
        add_round(a, end, -r, 0, density, [r](double z) { return std::sqrt(r * r - z * z); });
        add_round(a, end, l, l + r, density, [=](double z) { return std::sqrt(r * r - (z - l) * (z - l)); });
    }
};

Integrals integrals_of(const RodSpec& spec) {
    Integrals all;
    const BodySpec& body = *spec.body;
    for (std::size_t i = 0; i < body.spheres.radii.size(); ++i) {
        const Vec3d at = body.spheres.centres.empty() ? Vec3d{0, 0, 0} : body.spheres.centres[i];
        all.add_capsule(at, at, body.spheres.radii[i], spec.material.density);
    }
    for (std::size_t i = 0; i < body.capsules.radii.size(); ++i)
        all.add_capsule(body.capsules.from[i], body.capsules.to[i], body.capsules.radii[i], spec.material.density);
    return all;
}

/// J w about the centre, in the frame of the parts.
Vec3d inertia_times(const BodyShape& shape, const Vec3d& w) {
    return transpose_times(shape.axes, scale(shape.inertia, shape.axes * w));
}

TEST(BodyShape, HasTheMassCentreAndInertiaOfItsParts) {
    RodSpec capsules = test::rigid_body(0.3, 0.1);
    capsules.body->capsules.from[0] = {0.1, 0.2, -0.3};
    for (const RodSpec& spec : {test::rigid_body(0, 0.1), test::rigid_body(0.01, 0.1), test::rigid_body(2, 0.1),
                                capsules, test::crooked_body()}) {
        const BodyShape shape(spec);
        const Integrals exact = integrals_of(spec);
        const Vec3d centre = (1 / exact.mass) * exact.first;
        EXPECT_NEAR(shape.mass, exact.mass, 1e-6 * exact.mass);
        EXPECT_LT(norm(shape.centre - centre), 1e-7);
        for (const Vec3d& w : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
            const Vec3d of_centre = exact.mass * (dot(centre, centre) * w - dot(centre, w) * centre);
            const Vec3d expected = exact.second * w - of_centre;
            EXPECT_LT(norm(inertia_times(shape, w) - expected), 1e-6 * norm(expected));
        }
    }
    const BodyShape ball(test::rigid_body(0, 0.1));
    EXPECT_NEAR(ball.inertia.x, 0.4 * ball.mass * 0.01, 1e-15);
    EXPECT_EQ(ball.inertia.x, ball.inertia.y);
    EXPECT_NEAR(ball.inertia.x, ball.inertia.z, 1e-15);
}

// Of a box with rounded edges, column by column; and of one with sharp edges.
TEST(BodyShape, HasTheMassAndInertiaOfABox) {
    const Vec3d size{0.1, 0.06, 0.04};
    RodSpec spec = test::box_body(size);
    spec.body->boxes.centres = {{0.3, -0.1, 0.2}};
    const double r = spec.body->boxes.radii[0] = 0.015;
    const BodyShape shape(spec);
    const Vec3d half = 0.5 * size - Vec3d{r, r, r};
    Integrals counted;
    constexpr int n = 500;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double x = size.x * ((i + 0.5) / n - 0.5), y = size.y * ((j + 0.5) / n - 0.5);
            const double out_x = std::max(0.0, std::abs(x) - half.x), out_y = std::max(0.0, std::abs(y) - half.y),
                         left = r * r - out_x * out_x - out_y * out_y;
            if (left < 0) continue;
            const double height = half.z + std::sqrt(left), of_half = 1000 * height * size.x * size.y / (double(n) * n);
            for (const double side : {-1.0, 1.0}) counted.add(of_half, {x, y, side * height / std::sqrt(3.0)});
        }
    EXPECT_NEAR(shape.mass, counted.mass, 1e-4 * counted.mass);
    EXPECT_LT(norm(shape.centre - Vec3d{0.3, -0.1, 0.2}), 1e-15);
    for (const Vec3d& w : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
        const Vec3d expected = counted.second * w;
        EXPECT_LT(norm(inertia_times(shape, w) - expected), 2e-4 * norm(expected));
    }
    EXPECT_EQ(shape.point.size(), 8u);
    EXPECT_EQ(shape.line.size(), 12u);
    spec.body->boxes.radii = {1e-9};
    const BodyShape sharp(spec);
    const double m = 1000 * size.x * size.y * size.z;
    EXPECT_NEAR(sharp.mass, m, 1e-6 * m);
    const Vec3d exact = (m / 12) * Vec3d{size.y * size.y + size.z * size.z, size.x * size.x + size.z * size.z,
                                         size.x * size.x + size.y * size.y};
    EXPECT_LT(norm(inertia_times(sharp, {1, 1, 1}) - exact), 1e-6 * norm(exact));
}

TEST(BodyShape, TakesMassCentreAndInertiaThatAreGiven) {
    RodSpec spec = test::rigid_body(0.3, 0.1);
    spec.material.density = 0;
    spec.body->mass = 3;
    spec.body->centre = Vec3d{0.1, 0, 0.2};
    spec.body->inertia = {2, 3, 4, 0.5, -0.3, 0.2};
    const BodyShape shape(spec);
    EXPECT_EQ(shape.mass, 3);
    EXPECT_EQ(shape.centre.x, 0.1);
    const SymmetricMatrix j{2, 3, 4, 0.5, -0.3, 0.2};
    for (const Vec3d& w : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
        EXPECT_LT(norm(inertia_times(shape, w) - j * w), 1e-14);
    for (const std::vector<double>& bad : {std::vector<double>{1, 1, 3}, {1, 1, -1}, {1, 1, 1, 2, 0, 0}}) {
        spec.body->inertia = bad;
        EXPECT_THROW(BodyShape{spec}, InputError);
    }
}

TEST(PrincipalAxes, AreThoseOfTheMatrix) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int trial = 0; trial < 200; ++trial) {
        SymmetricMatrix a{normal(random), normal(random), normal(random),
                          normal(random), normal(random), normal(random)};
        if (trial % 4 == 0) a.xy = a.xz = 0;
        if (trial % 4 == 1) a = {2, 2, 2, 1e-9 * a.xy, a.xz * 1e-12, 0};
        const PrincipalAxes p = principal_axes(a);
        const double values[] = {p.value.x, p.value.y, p.value.z};
        const Vec3d rows[] = {p.axes.d1, p.axes.d2, p.axes.d3};
        for (int i = 0; i < 3; ++i) {
            EXPECT_LT(norm(a * rows[i] - values[i] * rows[i]),
                      3e-15 * (1 + std::abs(a.xx) + std::abs(a.yy) + std::abs(a.zz) + 4));
            EXPECT_NEAR(dot(rows[i], rows[i]), 1, 1e-14);
        }
        EXPECT_NEAR(dot(cross(rows[0], rows[1]), rows[2]), 1, 1e-14);
    }
}

// Wherever the parts lie in their frame, the body that is placed against it is the same.
TEST(BodyShape, DoesNotDependOnTheFrameOfItsParts) {
    const RodSpec plain = test::crooked_body();
    const RodGroup one(plain, 0, 0, "");
    const Quaterniond turn = rotation(Vec3d{0.7, -1.9, 0.4});
    RodSpec turned = plain;
    const auto move = [&](Vec3d& x) { x = turn * (x - Vec3d{0.3, 0.1, -0.2}); };
    for (Vec3d& x : turned.body->spheres.centres) move(x);
    for (auto* list : {&turned.body->capsules.from, &turned.body->capsules.to})
        for (Vec3d& x : *list) move(x);
    const Mat3d axes = matrix(turn);
    turned.placement.origin = {0.3, 0.1, -0.2};
    turned.placement.tangent = axes.d3;
    turned.placement.normal = axes.d1;
    const RodGroup other(turned, 0, 0, "");
    std::vector<Slot<1>> a(1), b(1);
    one.start_state(0, a);
    other.start_state(0, b);
    EXPECT_LT(norm(lane(a[0].position, 0) - lane(b[0].position, 0)), 1e-15);
    const auto tensor = [](const RodGroup& g, const Slot<1>& s, const Vec3d& w) {
        return transpose_times(lane(s.director, 0), scale(g.element[0].inertia, lane(s.director, 0) * w));
    };
    for (const Vec3d& w : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
        EXPECT_LT(norm(tensor(one, a[0], w) - tensor(other, b[0], w)), 1e-14 * norm(tensor(one, a[0], w)));
}

/// One body, stepped by the passes of its program.
struct Alone {
    RodGroup group;
    std::vector<Slot<1>> state;
    explicit Alone(const RodSpec& spec) : group(spec, 0, 0, ""), state(1) { group.start_state(0, state); }

    void advance(int steps, double h) {
        const RodTile<1> tile = tile_of(group, state);
        const UnstrainedPass<1> unstrained;
        const OrthonormalisePass<1> orthonormalise;
        const KickPass<KickKind::undamped, 1> kick(KicksOfGroup{KickConstants(group, {}, h)});
        std::vector<SlotLoad<1>> load(2);
        with_gyration(gyration_of(group), [&]<class Top>(Top) {
            const DriftPass<Top, 1> drift_pass;
            for (int i = 1; i <= steps; ++i) {
                const Step step{.index = i,
                                .dt = h,
                                .drift = h,
                                .kick = h,
                                .time = i * h,
                                .kick_length = 0,
                                .slot = 0,
                                .completes = true,
                                .last = false};
                drift_pass.run(tile, load.data(), step);
                orthonormalise.run(tile, load.data(), step);
                unstrained.run(tile, load.data(), step);
                kick.run(tile, load.data(), step);
            }
        });
    }
    Vec3d spin_momentum() const {
        return transpose_times(lane(state[0].director, 0), scale(group.element[0].inertia, lane(state[0].spin, 0)));
    }
};

// d3 goes round the angular momentum L at |L|/J1, and w about d3 at (1 - J3/J1) w3.
TEST(Body, TurnsAsAFreeSymmetricTop) {
    RodSpec spec = test::rigid_body(0.3, 0.05);
    spec.shape.velocity = {0.3, -0.2, 0.1};
    spec.placement.origin = {1, 2, -1};
    spec.placement.tangent = {1, 0.5, 0.3};
    spec.shape.angular_velocity = transpose_times(RodGroup(spec, 0, 0, "").frame(), Vec3d{3, -1, 7});
    Alone body(spec);
    EXPECT_EQ(gyration_of(body.group), Gyration::circular);
    const ExtraFigures before = extra_figures(body.group, body.state, {.angular_momentum = true});
    const RodEnergy start = rod_energy(body.group, body.state);
    const Vec3d d3 = frame(body.state[0]).d3, spin = body.spin_momentum();
    const Vec3d origin = lane(body.state[0].position, 0);
    EXPECT_LT(norm(origin - (Vec3d{1, 2, -1} + 0.15 * d3)), 1e-15);

    const double h = 1e-3;
    constexpr int steps = 100000;
    body.advance(steps, h);
    const RodEnergy end = rod_energy(body.group, body.state);
    EXPECT_NEAR(end.translation, start.translation, 1e-11 * start.translation);
    EXPECT_NEAR(end.rotation, start.rotation, 1e-11 * start.rotation);
    EXPECT_EQ(end.elastic(), 0);
    const ExtraFigures after = extra_figures(body.group, body.state, {.angular_momentum = true});
    const double speed = norm(spec.shape.velocity),
                 orbital = body.group.node_mass[0] * (speed * h * steps) * speed; // kg m^2/s
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(after.sum[i], before.sum[i], 1e-12 * (orbital + norm(spin))) << i;

    const double angle = norm(spin) / body.group.element[0].inertia.x * (h * steps); // 52 turns
    EXPECT_GT(angle, 300);
    const Vec3d axis = (1 / norm(spin)) * spin, along = dot(d3, axis) * axis, across = d3 - along;
    const Vec3d exact = along + std::cos(angle) * across + std::sin(angle) * cross(axis, across);
    EXPECT_LT(norm(frame(body.state[0]).d3 - exact), 1e-9);
    EXPECT_LT(norm(lane(body.state[0].position, 0) - origin - (h * steps) * spec.shape.velocity), 1e-9);
}

// Euler's free top in closed form, with the axis of the smallest moment along each of the first two directors.
TEST(Body, TurnsAsAFreeAsymmetricTopToSecondOrder) {
    for (const bool first_small : {true, false}) {
        RodSpec spec = test::rigid_body(0, 0.05);
        spec.body->inertia =
            first_small ? std::vector<double>{0.010, 0.012, 0.019} : std::vector<double>{0.012, 0.010, 0.019};
        const double small_rate = 2, w3 = 5, time = 4;
        spec.shape.angular_velocity = first_small ? Vec3d{small_rate, 0, w3} : Vec3d{0, small_rate, w3};
        const Vec3d j{spec.body->inertia[0], spec.body->inertia[1], spec.body->inertia[2]};
        std::vector<double> errors;
        for (const int steps : {400, 800, 1600}) {
            Alone body(spec);
            EXPECT_EQ(gyration_of(body.group), first_small ? Gyration::elliptic_d1 : Gyration::elliptic_d2);
            const Quaterniond start = lane(body.state[0].director, 0);
            const Vec3d momentum = body.spin_momentum();
            const double energy = rod_energy(body.group, body.state).rotation;
            body.advance(steps, time / steps);
            EXPECT_LT(norm(body.spin_momentum() - momentum), 1e-13 * norm(momentum));
            EXPECT_NEAR(rod_energy(body.group, body.state).rotation, energy,
                        1e-3 * energy * (400.0 / steps) * (400.0 / steps));
            const Mat3d exact = test::free_top_directors(j, small_rate, w3, time, start), now = frame(body.state[0]);
            errors.push_back(norm(now.d1 - exact.d1) + norm(now.d2 - exact.d2) + norm(now.d3 - exact.d3));
        }
        EXPECT_LT(errors[2], 2e-3);
        for (int i = 0; i < 2; ++i)
            EXPECT_NEAR(std::log2(nth(errors, i) / errors[static_cast<std::size_t>(i) + 1]), 2, 0.05);
    }
}

TEST(Body, ChoosesTheAxisThatSplitsTheTopBest) {
    RodSpec spec = test::rigid_body(0, 0.05);
    for (const auto& [given, third] : {std::pair{std::vector<double>{1, 1.1, 2}, 2.0},
                                       {{2, 1.1, 1}, 2.0},
                                       {{1, 1, 0.1}, 0.1},
                                       {{0.1, 1, 1}, 0.1},
                                       {{1, 0.1, 1}, 0.1}}) {
        spec.body->inertia = given;
        const BodyShape shape(spec);
        EXPECT_EQ(shape.inertia.z, third);
        EXPECT_NEAR(norm(inertia_times(shape, {1, 0, 0}) - Vec3d{given[0], 0, 0}), 0, 1e-15)
            << "axes go with their moments";
        const RodGroup group(spec, 0, 0, "");
        EXPECT_EQ(gyration_of(group) == Gyration::circular, given[0] != 1 || given[1] != 1.1 ? third == 0.1 : false);
    }
}

TEST(Body, TakesForceAndCoupleAtItsCentre) {
    RodSpec spec = test::crooked_body();
    const RodGroup group(spec, 0, 0, "");
    std::vector<Slot<1>> state(1);
    group.start_state(0, state);
    const double h = 1e-3, rate = 3;
    const DampingRates rates{.node = {rate}, .element = {{rate, rate, rate}}, .element_stretched = {}};
    std::vector<SlotLoad<1>> load(2);
    UnstrainedPass<1>().run(tile_of(group, state), load.data(), Step{});
    const Vec3d force{1, 2, 3}, couple{0.1, -0.2, 0.3};
    load[0].force = broadcast<1>(force);
    load[0].couple = broadcast<1>(couple);
    KickPass<KickKind::constant_rates, 1>(KicksOfGroup{KickConstants(group, rates, h)})
        .run(tile_of(group, state), load.data(), Step{.kick_length = 0});
    const double mean = 2 / (2 + rate * h);
    const Vec3d j = group.element[0].inertia, w = lane(state[0].spin, 0);
    EXPECT_LT(norm(lane(state[0].velocity, 0) - (h * mean / group.node_mass[0]) * force), 1e-14);
    EXPECT_NEAR(w.x, h * mean / j.x * couple.x, 1e-13);
    EXPECT_NEAR(w.y, h * mean / j.y * couple.y, 1e-13);
    EXPECT_NEAR(w.z, h * mean / j.z * couple.z, 1e-13);
}

} // namespace
} // namespace skein
