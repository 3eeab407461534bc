// Sharp surfaces in a fluid: exact shear flows, orders of convergence, the same bits on any ranks, momentum.
#include "fluid/make_flow.hpp"
#include "immersion/body_surface.hpp"
#include "immersion/immersion.hpp"
#include "skein/core/index.hpp"
#include "support/meshes.hpp"
#include "support/whole_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

/// One that swings across the planes that ranks share, one that moves through the sides of the box past another.
std::vector<Obstacle> moving_bodies() {
    Obstacle ball, tube, post;
    ball.name = "ball";
    ball.centre = {0.43, 1.12, 0.81};
    ball.radius = 0.31;
    ball.amplitude = {0.05, 0.02, 0.3};
    ball.frequency = 0.7;
    tube.name = "tube";
    tube.kind = ObstacleKind::cylinder;
    tube.centre = {1.5, 0.25, 0};
    tube.radius = 0.3;
    tube.second_radius = 0.2;
    tube.velocity = {0.4, -0.5, 0.1};
    post = tube;
    post.name = "post";
    post.centre = {1.47, 1.61, 0};
    post.radius = post.second_radius = 0.25;
    post.velocity = {0, 0, 0};
    Obstacle block, egg;
    block.name = "block";
    block.kind = ObstacleKind::box;
    block.centre = {0.9, 1.7, 0.2};
    block.sides = {0.5, 0.3, 0.4};
    block.axis = {1, 0.5, 0};
    block.angular_velocity = {0.7, -1.1, 2};
    egg.name = "egg";
    egg.kind = ObstacleKind::ellipsoid;
    egg.centre = {1.9, 0.9, 1.5};
    egg.half_axes = {0.25, 0.2, 0.35};
    egg.normal = Vec3d{1, 1, 0};
    egg.velocity = {0, 0.2, 0.3};
    std::vector<Obstacle> all{ball, tube, post, block, egg};
    for (Obstacle& o : all) o.surface = SurfaceKind::sharp;
    return all;
}

struct Swum {
    std::vector<double> state;
    Vec3d given{0, 0, 0}, gained{0, 0, 0};
};

Swum swum(const Communicator& comm, const Threads& threads, FlowScheme scheme, std::vector<Obstacle> obstacles,
          int across = 1) {
    FlowConstants constants{.grid = {.cells = {24, 20, 16}, .h = 0.1, .lower = {-0.3, 0.2, 0.05}},
                            .density = 2,
                            .kinematic_viscosity = 5e-3,
                            .scheme = scheme,
                            .ranks_across = across};
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
    Immersion bodies(comm, threads, constants.grid, {.sweeps = 3, .kinematic_viscosity = constants.kinematic_viscosity},
                     std::move(obstacles), nullptr, across);
    flow->set_forcing(&bodies.stage_forcing());
    bodies.begin_interval(0);
    for (int s = 0; s < 6; ++s) flow->step(0.03 * s, 0.03);
    bodies.sum_loads();
    Swum all;
    for (std::size_t o = 0; o < bodies.obstacles().size(); ++o)
        all.given += constants.density * bodies.given_by_obstacle(o);
    all.gained = figures_of(comm, *flow).momentum;
    all.state = test::state_on_all_ranks(comm, *flow);
    return all;
}

TEST(SharpSurfaces, HaveTheSameBitsOnAnyRanksAndGiveWhatTheFluidGains) {
    const Threads threads(1), team(2);
    std::vector<Obstacle> mixed = moving_bodies();
    for (const std::size_t marked : {1, 3}) mixed[marked].surface = SurfaceKind::markers;
    for (const FlowScheme scheme :
         {FlowScheme::rk3, FlowScheme::rk3_projected, FlowScheme::adams_bashforth, FlowScheme::crank_nicolson})
        for (const std::vector<Obstacle>& bodies : {moving_bodies(), mixed}) {
            const Swum here = swum(Communicator::world(), threads, scheme, bodies);
            EXPECT_EQ(here.state, swum(Communicator::alone(), threads, scheme, bodies).state);
            EXPECT_EQ(here.state, swum(Communicator::world(), team, scheme, bodies).state);
            for (const int across : {2, Communicator::world().size()}) {
                if (across == 1 || Communicator::world().size() % across != 0) continue;
                const Swum pencils = swum(Communicator::world(), team, scheme, bodies, across);
                EXPECT_EQ(here.state, pencils.state) << across << " ranks across";
                EXPECT_EQ(here.given.x, pencils.given.x);
            }
            EXPECT_GT(norm(here.gained), 1e-3);
            EXPECT_LT(norm(here.given - here.gained), 1e-13);
        }
}

/// Forces of implicit stages at nodes go with bodies from rank to rank, and to a run that goes on.
TEST(SharpSurfaces, GoOnFromForcesAtNodes) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    const FlowConstants constants{.grid = {.cells = {24, 20, 16}, .h = 0.1, .lower = {-0.3, 0.2, 0.05}},
                                  .kinematic_viscosity = 5e-3,
                                  .scheme = FlowScheme::crank_nicolson};
    std::vector<Obstacle> mixed = moving_bodies();
    mixed[2].surface = SurfaceKind::markers;
    const ForcingNumbers numbers{.kinematic_viscosity = constants.kinematic_viscosity};
    auto first = make_flow(comm, threads, constants), second = make_flow(comm, threads, constants);
    Immersion bodies(comm, threads, constants.grid, numbers, mixed),
        others(comm, threads, constants.grid, numbers, mixed);
    first->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
    first->set_forcing(&bodies.stage_forcing());
    second->set_forcing(&others.stage_forcing());
    for (int s = 0; s < 4; ++s) first->step(0.05 * s, 0.05);
    const std::vector<double> held = bodies.saved_held();
    EXPECT_GT(held.size(), HeldVectors::record * mixed[2].markers(constants.grid).size());
    const auto from = first->state(), to = second->state();
    for (std::size_t f = 0; f < from.size(); ++f) std::copy(from[f].begin(), from[f].end(), to[f].begin());
    second->refresh(first->time());
    others.restore_held(held);
    EXPECT_EQ(others.saved_held(), held);
    for (int s = 4; s < 7; ++s) {
        first->step(0.05 * s, 0.05);
        second->step(0.05 * s, 0.05);
    }
    const FieldLayout layout = first->layout();
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < layout.nz; ++k)
            for (int j = 0; j < layout.ny; ++j)
                for (int i = 0; i < layout.nx; ++i)
                    ASSERT_EQ(nth(first->velocity(c), layout.at(i, j, k)),
                              nth(second->velocity(c), layout.at(i, j, k)));
    EXPECT_EQ(bodies.saved_held(), others.saved_held());
}

/// Plate along a diagonal of a periodic square of edge 1, with faces at x + y = offset -+ thickness, m.
class DiagonalPlate final : public Surface {
public:
    DiagonalPlate(double offset, double half) : offset_(offset), half_(half) {}
    double distance(const Vec3d& place) const override {
        const double s = place.x + place.y - offset_;
        return (std::abs(s - std::round(s)) - half_) / std::numbers::sqrt2;
    }
    Vec3d extent() const override { return {unbounded, unbounded, unbounded}; }

private:
    double offset_, half_;
};

SharpBody plate(double offset, double half, double speed) {
    const Vec3d velocity = (speed / std::numbers::sqrt2) * Vec3d{1, -1, 0};
    return {.surface = std::make_unique<DiagonalPlate>(offset, half),
            .motion = [velocity](double) -> BodyMotion { return {.velocity = velocity}; }};
}

/// Forces explicit stages by surfaces alone.
class SurfacesAlone final : public StageForcing {
public:
    explicit SurfacesAlone(SharpForcing& surfaces) : surfaces_(surfaces) {}
    void add_held_forces(const FlowStage&) override {}
    void sample(const FlowStage& stage) override { surfaces_.act(stage); }
    void apply(const FlowStage&) override {}
    bool changed(int plane) const override { return surfaces_.changed(plane); }

private:
    SharpForcing& surfaces_;
};

std::vector<SharpBody> listed(SharpBody first) {
    std::vector<SharpBody> all;
    all.push_back(std::move(first));
    return all;
}

/// Velocities on faces are means over them. Linear profiles between plates that cut faces at odd places are exact, and
/// so are the forces on the plates.
TEST(SharpSurfaces, ShearBetweenSlantedPlatesIsExact) {
    const Communicator comm = Communicator::world();
    const Threads threads(1);
    for (const FlowScheme scheme : {FlowScheme::rk3, FlowScheme::rk3_projected, FlowScheme::adams_bashforth}) {
        constexpr int n = 20;
        constexpr double h = 1.0 / n, viscosity = 0.03, at_rest = 0.213, half = 0.1034, other = 0.7117, speed = 0.8;
        FlowConstants constants{
            .grid = {.cells = {n, n, 8}, .h = h}, .kinematic_viscosity = viscosity, .scheme = scheme};
        std::vector<SharpBody> plates = listed(plate(at_rest, half, 0));
        plates.push_back(plate(other, half, speed));
        SharpForcing surfaces(comm, threads, constants.grid, viscosity, std::move(plates));
        SurfacesAlone forcing(surfaces);
        auto flow = make_flow(comm, threads, constants);
        flow->set_forcing(&forcing);
        const double up = other - at_rest - 2 * half, down = 1 - 4 * half - up; // gaps along s
        const auto integral = [&](double s) {                                   // of the profile
            const auto ramp = [s](double from) { return 0.5 * std::pow(std::max(0.0, s - from), 2); };
            return speed * ((ramp(2 * half) - ramp(2 * half + up)) / up - (ramp(4 * half + up) - ramp(1)) / down);
        };
        const auto mean_on_face = [&](const Vec3d& at) {
            double s = at.x + at.y - (at_rest - half);
            s -= std::floor(s - half);
            return ((integral(s + 0.5 * h) - integral(s - 0.5 * h)) / (h * std::numbers::sqrt2)) * Vec3d{1, -1, 0};
        };
        flow->set_velocity(mean_on_face);
        double given = 0, time = 0;
        for (int s = 0; s < 10; ++s, time += 0.01) {
            surfaces.reset_given();
            flow->step(time, 0.01);
            given = dot((1 / (0.01 * std::numbers::sqrt2)) * surfaces.given()[1].linear, {1, -1, 0});
        }
        // Each face has the area sqrt(2) by the depth, and a gap along the normal is that along s over sqrt(2).
        const double depth = 8 * h, force = viscosity * speed * std::numbers::sqrt2 * depth * std::numbers::sqrt2 *
                                            (1 / up + 1 / down);
        EXPECT_NEAR(given, force, 1e-12 * force);
        const FieldLayout layout = flow->layout();
        double most = 0;
        for (int k = 0; k < layout.nz; ++k)
            for (int j = 0; j < layout.ny; ++j)
                for (int i = 0; i < layout.nx; ++i) {
                    const Vec3d face{(i + 1) * h, (flow->pencils().rows().first + j + 0.5) * h, 0};
                    most = std::max(most, std::abs(nth(flow->velocity(0), layout.at(i, j, k)) - mean_on_face(face).x));
                }
        EXPECT_LT(most, 1e-13);
    }
}

/// A flow driven along plates at rest has a quadratic profile, whose flux is exact where the plates cut faces.
TEST(SharpSurfaces, FluxBetweenSlantedPlatesIsExact) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    constexpr double viscosity = 0.1, offset = 0.213, half = 0.1534, acceleration = 0.3;
    const double gap = (1 - 2 * half) / std::numbers::sqrt2,
                 flux = acceleration * gap * gap / (12 * viscosity) * (1 - 2 * half);
    for (const int n : {9, 16, 21}) {
        FlowConstants constants{.grid = {.cells = {n, n, 1}, .h = 1.0 / n},
                                .kinematic_viscosity = viscosity,
                                .acceleration = (acceleration / std::numbers::sqrt2) * Vec3d{1, -1, 0}};
        SharpForcing surfaces(comm, threads, constants.grid, viscosity, listed(plate(offset, half, 0)));
        SurfacesAlone forcing(surfaces);
        auto flow = make_flow(comm, threads, constants);
        flow->set_forcing(&forcing);
        flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
        flow->step_within(0, 8, 1); // the slowest mode decays by e^-33
        EXPECT_NEAR(figures_of(comm, *flow).momentum.x * std::numbers::sqrt2 * n, flux, 1e-9 * flux) << n << " cells";
    }
}

/// Outside of a circle.
class Hole final : public Surface {
public:
    explicit Hole(double radius) : radius_(radius) {}
    double distance(const Vec3d& place) const override { return radius_ - std::hypot(place.x, place.y); }
    Vec3d extent() const override { return {unbounded, unbounded, unbounded}; }

private:
    double radius_;
};

/// Errors between a cylinder that spins and a hole at rest, over the cylinder's velocity.
struct BetweenCylinders {
    double largest = 0, mean = 0;

    BetweenCylinders(int n, double shift) {
        const Communicator comm = Communicator::alone();
        const Threads threads(1);
        constexpr double viscosity = 0.1, inner = 0.17, outer = 0.43, spin = 2;
        const Vec3d centre{0.5 + shift / n, 0.5 + 0.6 * shift / n, 0};
        FlowConstants constants{.grid = {.cells = {n, n, 1}, .h = 1.0 / n}, .kinematic_viscosity = viscosity};
        std::vector<SharpBody> bodies;
        bodies.push_back({.surface = std::make_unique<TubeSurface>(inner, inner), .motion = [&](double) -> BodyMotion {
                              return {.place = centre, .spin = {0, 0, spin}};
                          }});
        bodies.push_back({.surface = std::make_unique<Hole>(outer),
                          .motion = [&](double) -> BodyMotion { return {.place = centre}; }});
        SharpForcing surfaces(comm, threads, constants.grid, viscosity, std::move(bodies));
        SurfacesAlone forcing(surfaces);
        auto flow = make_flow(comm, threads, constants);
        flow->set_forcing(&forcing);
        const double b = spin * inner * inner / (1 - inner * inner / (outer * outer)), a = -b / (outer * outer);
        const auto exact = [&](const Vec3d& at) -> Vec3d {
            const Vec3d from = at - centre;
            const double r = std::hypot(from.x, from.y), turn = r < inner ? spin : r > outer ? 0 : a + b / (r * r);
            return {-turn * from.y, turn * from.x, 0};
        };
        flow->set_velocity(exact);
        flow->step_within(0, 0.5, 1); // seven times the decay of the slowest mode
        const FieldLayout layout = flow->layout();
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const double error =
                    std::abs(nth(flow->velocity(0), layout.at(i, j, 0)) - exact({(i + 1.0) / n, (j + 0.5) / n, 0}).x);
                largest = std::max(largest, error / (spin * inner));
                mean += error / (spin * inner) / (n * n);
            }
    }
};

/// Cells that a surface cuts are free of divergence as whole cells, so velocities next to it are of first order.
TEST(SharpSurfaces, FlowBetweenCylindersConverges) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    for (const double shift : {0.0, 0.3}) {
        const BetweenCylinders coarse(20, shift), fine(60, shift);

        EXPECT_LT(fine.mean, coarse.mean / 7.5);
        EXPECT_LT(fine.largest, 0.03);
    }
}

/// One body in a cube of 1 m with periods, driven by an acceleration of 0.5 m/s^2 along x.
struct Array {
    Vec3d flow, force, couple; ///< mean velocity, force and couple over what drives the fluid

    Array(int n, Obstacle body, double step, int steps) {
        const Communicator comm = Communicator::alone();
        const Threads threads(1);
        constexpr double acceleration = 0.5;
        FlowConstants constants{.grid = {.cells = {n, n, n}, .h = 1.0 / n},
                                .kinematic_viscosity = 1,
                                .acceleration = {acceleration, 0, 0},
                                .scheme = FlowScheme::crank_nicolson};
        auto flow = make_flow(comm, threads, constants);
        flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
        body.surface = SurfaceKind::sharp;
        Immersion bodies(comm, threads, constants.grid, {.kinematic_viscosity = 1}, {body});
        flow->set_forcing(&bodies.stage_forcing());
        for (int s = 0; s < steps; ++s) {
            bodies.begin_interval(step * s);
            flow->step(step * s, step);
        }
        flow_and_force(figures_of(comm, *flow).momentum, bodies, step * steps, acceleration);
    }

private:
    void flow_and_force(const Vec3d& momentum, const Immersion& bodies, double time, double acceleration) {
        flow = (1 / acceleration) * momentum;
        force = (1 / acceleration) * bodies.force_on_obstacle(0, 1, time);
        couple = (1 / acceleration) * bodies.couple_on_obstacle(0, 1, time);
    }
};

/// A sphere in it.
struct SphereArray {
    double drag_factor, force;

    SphereArray(int n, double share, double step, int steps, const Vec3d& shift) {
        Obstacle sphere;
        sphere.centre = Vec3d{0.5, 0.5, 0.5} + (1.0 / n) * shift;
        sphere.radius = std::cbrt(3 * share / (4 * std::numbers::pi));
        const Array array(n, sphere, step, steps);
        drag_factor = 1 / (6 * std::numbers::pi * sphere.radius * array.flow.x);
        force = array.force.x;
    }
};

/// Of Zick and Homsy; all that drives the fluid is a force on the sphere.
TEST(SharpSurfaces, SpheresInACubicArrayHaveTheirDrag) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    for (const auto& [share, published] : {std::pair{0.125, 4.292}, std::pair{0.216, 7.442}})
        for (const Vec3d& shift : {Vec3d{0, 0, 0}, Vec3d{0.3, 0.1, 0.45}}) {
            const SphereArray coarse(16, share, 0.04, 60, shift), fine(32, share, 0.04, 60, shift);
            EXPECT_NEAR(coarse.drag_factor, published, 0.01 * published);
            EXPECT_NEAR(fine.drag_factor, published, 0.0015 * published);
            EXPECT_NEAR(fine.force, 1, 1e-3);
        }
}

/// Resistances of an ellipsoid in slow flow along its axes over viscosity, m: 16 pi/(chi + a^2 alpha), of Oberbeck.
Vec3d resistance(const Vec3d& a) {
    constexpr int pieces = 4000;
    double chi = 0;
    Vec3d alpha{0, 0, 0};
    const Vec3d squared = scale(a, a);
    for (int p = 0; p < pieces; ++p) {
        const double s = (p + 0.5) / pieces, scaled = squared.x, l = scaled * s * s / ((1 - s) * (1 - s)),
                     width = scaled * 2 * s / ((1 - s) * (1 - s) * (1 - s)) / pieces;
        const Vec3d to = squared + Vec3d{l, l, l};
        const double term = width / std::sqrt(to.x * to.y * to.z);
        chi += term;
        alpha += Vec3d{term / to.x, term / to.y, term / to.z};
    }
    const auto of = [&](double square, double integral) { return 16 * std::numbers::pi / (chi + square * integral); };
    return {of(squared.x, alpha.x), of(squared.y, alpha.y), of(squared.z, alpha.z)};
}

/// Images slow it by 2.837/L, and by what its size takes from this.
TEST(SharpSurfaces, EllipsoidsHaveTheirDragAlongEachAxis) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    Obstacle body;
    body.kind = ObstacleKind::ellipsoid;
    body.centre = {0.51, 0.49, 0.505};
    body.half_axes = {0.2, 0.14, 0.11};
    const Vec3d alone = resistance(body.half_axes);
    EXPECT_NEAR(resistance({0.2, 0.2, 0.2}).x, 6 * std::numbers::pi * 0.2, 1e-6);
    const double square = dot(body.half_axes, body.half_axes) / 3,
                 images = 2.837297 / (6 * std::numbers::pi) - 2 * square / 9;
    // Axes as they are; its y along x; its x along the diagonal of x and y, so that it drifts sideways.
    for (const auto& [axis, normal] :
         {std::pair{Vec3d{0, 0, 1}, Vec3d{1, 0, 0}}, std::pair{Vec3d{0, 0, 1}, Vec3d{0, 1, 0}},
          std::pair{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}}, std::pair{Vec3d{0, 0, 1}, Vec3d{1, 1, 0}}}) {
        body.axis = axis;
        body.normal = normal;
        const Mat3d axes = body.axes_at(0);
        const Vec3d pull = axes * Vec3d{1, 0, 0},
                    expected = transpose_times(axes, Vec3d{pull.x / alone.x, pull.y / alone.y, pull.z / alone.z}) -
                               images * Vec3d{1, 0, 0};
        const Array array(32, body, 0.03, 50);
        EXPECT_NEAR(array.flow.x, expected.x, 0.012 * expected.x);
        EXPECT_NEAR(array.flow.y, expected.y, 0.012 * expected.x);
        EXPECT_NEAR(array.force.x, 1, 2e-3);
        EXPECT_LT(norm(array.couple), 2e-3);
    }
}

TEST(SharpSurfaces, MeshesActAsTheShapesThatTheyAre) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    const auto in_order = [](std::size_t t) { return std::to_string(t); };
    const auto mesh_of = [&](const test::Mesh& of) {
        return std::make_shared<const TriangleMesh>(of.points, of.triangles, in_order);
    };
    Obstacle box, mesh;
    box.kind = ObstacleKind::box;
    box.sides = {0.4, 0.3, 0.25};
    mesh.kind = ObstacleKind::mesh;
    box.centre = mesh.centre = {0.51, 0.49, 0.505};
    box.axis = mesh.axis = {0.3, -0.2, 1};
    mesh.mesh = mesh_of(test::box_mesh(0.5 * box.sides));
    const Array one(24, box, 0.03, 20), other(24, mesh, 0.03, 20);
    EXPECT_LT(norm(one.flow - other.flow), 1e-12 * norm(one.flow));
    EXPECT_LT(norm(one.couple - other.couple), 1e-11);
    Obstacle sphere;
    sphere.centre = mesh.centre;
    sphere.radius = 0.25;
    mesh.mesh = mesh_of(test::ball_mesh(sphere.radius, 5)); // its volume is 0.14 % less
    const Array round(24, sphere, 0.03, 20), faceted(24, mesh, 0.03, 20);
    EXPECT_NEAR(faceted.flow.x / round.flow.x, 1, 2e-3);
    EXPECT_GT(faceted.flow.x, round.flow.x);
}

/// 8 pi mu a^3 by the angular velocity, of a fluid that turns the other way by the share of the spheres.
TEST(SharpSurfaces, ASphereThatSpinsHasItsCouple) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    constexpr int n = 32;
    FlowConstants constants{.grid = {.cells = {n, n, n}, .h = 1.0 / n}, .kinematic_viscosity = 1};
    constants.scheme = FlowScheme::crank_nicolson;
    Obstacle body;
    body.centre = {0.51, 0.5, 0.497};
    body.radius = 0.16;
    body.angular_velocity = {0.2, -0.3, 0.5};
    body.surface = SurfaceKind::sharp;
    auto flow = make_flow(comm, threads, constants);
    flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
    Immersion bodies(comm, threads, constants.grid, {.kinematic_viscosity = 1}, {body});
    flow->set_forcing(&bodies.stage_forcing());
    for (int s = 0; s < 12; ++s) {
        bodies.begin_interval(0.01 * s);
        flow->step(0.01 * s, 0.01);
    }
    const double known = 8 * std::numbers::pi * std::pow(body.radius, 3) / (1 - body.solid(constants.grid).volume);
    const Vec3d couple = bodies.couple_on_obstacle(0, 1, 0.12);
    EXPECT_LT(norm(couple + known * body.angular_velocity), 0.015 * known * norm(body.angular_velocity));
}

/// A steady acceleration along each axis of an ellipsoid, in a fluid that is nearly inviscid.
TEST(SharpSurfaces, EllipsoidsHaveTheirAddedMass) {
    if (Communicator::world().size() > 1) GTEST_SKIP() << "the bits are those of one rank";
    const Communicator comm = Communicator::alone();
    const Threads threads(1);
    constexpr int n = 40;
    Obstacle shape;
    shape.kind = ObstacleKind::ellipsoid;
    shape.half_axes = {0.16, 0.12, 0.09};
    const FlowConstants constants{.grid = {.cells = {n, n, n}, .h = 1.0 / n}, .kinematic_viscosity = 1e-6};
    const Solid solid = shape.solid(constants.grid);
    const Vec3d known = added_inertia({solid.volume, {0, 0, 0}, times(solid.volume, solid.inertia)}).linear;
    for (int c = 0; c < 3; ++c) {
        const Vec3d along{c == 0 ? 1.0 : 0, c == 1 ? 1.0 : 0, c == 2 ? 1.0 : 0};
        std::vector<SharpBody> bodies = listed(
            {.surface = shape.shape(),
             .motion = [along](double time) -> BodyMotion {
                 return {.place = Vec3d{0.51, 0.49, 0.505} + (0.5 * time * time) * along, .velocity = time * along};
             },
             .moves = true});
        SharpForcing surfaces(comm, threads, constants.grid, constants.kinematic_viscosity, std::move(bodies));
        SurfacesAlone forcing(surfaces);
        auto flow = make_flow(comm, threads, constants);
        flow->set_forcing(&forcing);
        flow->set_velocity([](const Vec3d&) { return Vec3d{0, 0, 0}; });
        constexpr double step = 0.02;
        for (int s = 0; s < 8; ++s) {
            surfaces.reset_given();
            flow->step(step * s, step);
        }
        const double given = dot(surfaces.given()[0].linear, along) / (step * solid.volume),
                     added = component_of(known, c);
        EXPECT_NEAR(given - 1, added, 0.015 * added) << c;
    }
}

} // namespace
} // namespace skein
