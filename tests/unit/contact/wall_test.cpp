// Rods on walls: at rest, bouncing, sliding, rolling, in tubes; energy budgets of walls; eight lanes against one.
#include "contact/wall_pass.hpp"

#include "diagnostics/observables.hpp"
#include "kernels/rod_tiles.hpp"
#include "loads/gravity.hpp"
#include "loads/load_pass.hpp"
#include "loads/uniform_force.hpp"
#include "mechanics/elastic.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/kick.hpp"
#include "mechanics/rod_copies.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
using State = std::vector<Slot<1>>;

/// W rods of one group under gravity, between walls.
template <int W> class Stage {
public:
    Stage(const RodGroup& group, const std::vector<State>& states, const std::vector<Wall>& scene, const Vec3d& gravity,
          double dt, std::int64_t done = 0, const std::optional<UniformForce>& push = {})
        : group_(group), walls(std::make_shared<Walls>(scene)),
          contacts(std::make_shared<WallContactTiles<W>>(*walls, group)), slot_(states[0].size()),
          load_(states[0].size()), clock_(dt, done) {
        for (std::size_t k = 0; k < slot_.size(); ++k)
            for (int i = 0; i < W; ++i) set_lane(slot_[k], i, nth(states, i)[k]);
        tile_ = {slot_.data(), group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {}, W};
        with_gyration(gyration_of(group),
                      [&]<class Top>(Top) { program_.push_back(std::make_unique<DriftPass<Top, W>>()); });
        with_energy_law(group.law(),
                        [&]<class L>(L) { program_.push_back(std::make_unique<ElasticPass<L, W>>(ends_of(group))); });
        program_.push_back(std::make_unique<LoadPass<Gravity, W>>(Gravity{gravity}, group));
        if (push) program_.push_back(std::make_unique<LoadPass<UniformForce, W>>(*push, group));
        auto pass = std::make_unique<WallPass<W>>(walls, group, contacts);
        wall_pass = pass.get();
        program_.push_back(std::move(pass));
        if (group.closed()) program_.push_back(std::make_unique<FoldRingPass<W>>());
        program_.push_back(
            std::make_unique<KickPass<KickKind::undamped, W>>(KicksOfGroup{KickConstants(group, {}, dt)}));
        if (group.closed()) program_.insert(program_.begin() + 1, std::make_unique<CloseRingPass<W>>());
        for (const auto& p : program_) p->bind(tile_);
    }
    void advance(std::int64_t steps) {
        for (std::int64_t until = clock_.done() + steps; clock_.done() < until;) {
            const auto batch = clock_.next(until);
            for (const auto& p : program_) p->prepare(batch);
            for (const Step& step : batch)
                for (const auto& p : program_) p->run(tile_, load_.data(), step);
            clock_.advance(batch);
        }
    }
    /// Of the time of the rates.
    State state(int l = 0) const {
        State out;
        for (const Slot<W>& s : slot_) out.push_back(lane(s, l));
        synchronise(group_, out, clock_.lag());
        return out;
    }
    WallFigures figures(int wall = 0, int l = 0) const { return contacts->figures({0, 0, l}, wall); }
    const AlignedVector<Slot<W>>& slots() const { return slot_; }
    const RodTile<W>& tile() const { return tile_; }
    double time() const { return clock_.time(); }

private:
    const RodGroup& group_;

public:
    std::shared_ptr<Walls> walls;
    std::shared_ptr<WallContactTiles<W>> contacts;
    WallPass<W>* wall_pass = nullptr;

private:
    AlignedVector<Slot<W>> slot_;
    AlignedVector<SlotLoad<W>> load_;
    Clock clock_;
    RodTile<W> tile_;
    TilePasses<W> program_;
};

constexpr double radius = 0.02, gravity = 9.81;

/// Lying along x at the given height; stiff, so that it moves as one body.
RodSpec lying_rod(double height, long elements = 8, Law law = Law::incompressible) {
    RodSpec spec = test::simple_rod(elements);
    spec.material.law = law;
    spec.placement.origin = {0, 0, height};
    spec.placement.tangent = {1, 0, 0};
    return spec;
}
State start(const RodGroup& group) {
    State state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    return state;
}
double mass_of(const RodGroup& group) {
    double sum = 0;
    for (const double m : group.node_mass) sum += m;
    return sum;
}
Vec3d centre(const RodGroup& group, const State& state) {
    Vec3d sum{0, 0, 0};
    for (std::size_t i = 0; i < state.size(); ++i)
        sum += (group.node_mass[i] / mass_of(group)) * lane(state[i].position, 0);
    return sum;
}
Vec3d velocity(const RodGroup& group, const State& state) {
    return (1 / mass_of(group)) * test::momenta(group, state).linear;
}
double energy(const RodGroup& group, const State& state) {
    const RodEnergy e = rod_energy(group, state);
    return e.translation + e.rotation + e.elastic();
}

Wall floor_of(ContactLaw law) {
    Wall wall;
    wall.name = "floor";
    wall.law = law;
    return wall;
}
ContactLaw sticky(double stiffness, double static_friction, double kinetic_friction) {
    return {.normal = ContactNormal::linear,
            .stiffness = stiffness,
            .friction = ContactFriction::memory,
            .static_friction = static_friction,
            .kinetic_friction = kinetic_friction};
}

TEST(Walls, CarryARodAtTheOverlapOfTheirLaw) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        // A ring lies flat with the same load on every node; its dashpot brings it to rest.
        RodSpec spec = test::simple_rod(16);
        spec.shape.closed = true;
        spec.placement.tangent = {1, 0, 0};
        spec.placement.normal = Vec3d{0, 0, 1};
        const double k = normal == ContactNormal::linear ? 1e4 : 1e5;
        spec.placement.origin = {0, 0, radius};
        const RodGroup ring(spec, 0, 0, "");
        ASSERT_LT(std::abs(lane(start(ring)[7].position, 0).z - radius), 1e-12) << "lies flat";
        const double load = mass_of(ring) * gravity / 16,
                     overlap = normal == ContactNormal::linear ? load / k : std::pow(load / k, 2.0 / 3);
        Stage<1> stage(
            ring, {start(ring)},
            {floor_of({.normal = normal, .stiffness = k, .damping = normal == ContactNormal::linear ? 40.0 : 2000.0})},
            {0, 0, -gravity}, 2e-5);
        stage.advance(150000);
        EXPECT_NEAR(radius - lane(stage.state()[3].position, 0).z, overlap, 1e-6 * overlap);
        const WallFigures figures = stage.figures();
        EXPECT_NEAR(figures.force.z, -mass_of(ring) * gravity, 1e-6 * mass_of(ring) * gravity);
        EXPECT_NEAR(figures.normal, mass_of(ring) * gravity, 1e-6 * mass_of(ring) * gravity);
        EXPECT_EQ(figures.touching, 16);
        EXPECT_NEAR(figures.max_overlap, overlap / (2 * radius), 1e-5 * figures.max_overlap);
        EXPECT_NEAR(figures.stiffness, normal == ContactNormal::linear ? k : 1.5 * k * std::sqrt(overlap),
                    1e-5 * figures.stiffness);
    }
    // A straight rod bends a little, since its ends weigh half; but the overlaps together carry its weight.
    const RodGroup group(lying_rod(radius), 0, 0, "");
    Stage<1> stage(group, {start(group)},
                   {floor_of({.normal = ContactNormal::linear, .stiffness = 1e4, .damping = 40})}, {0, 0, -gravity},
                   2e-5);
    stage.advance(150000);
    double overlaps = 0;
    for (const Slot<1>& s : stage.state()) overlaps += radius - lane(s.position, 0).z;
    EXPECT_NEAR(overlaps, mass_of(group) * gravity / 1e4, 1e-5 * overlaps);
}

TEST(Walls, GiveBackAllEnergyWithoutADashpot) {
    // Sections as at rest: where they shrink with the stretch, the overlap does work on it that no force takes (2e-4 of
    // the energy here).
    RodSpec spec = lying_rod(radius + 0.01, 8, Law::linear);
    spec.shape.velocity = {0, 0, -1};
    const RodGroup group(spec, 0, 0, "");
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        Stage<1> stage(group, {start(group)},
                       {floor_of({.normal = normal, .stiffness = normal == ContactNormal::linear ? 2e4 : 2e5})},
                       {0, 0, 0}, 2e-6);
        const double before = energy(group, stage.state());
        double most = 0;
        for (int look = 0; look < 60; ++look) {
            stage.advance(1000);
            if (stage.figures().touching == 0) most = std::max(most, energy(group, stage.state()) / before - 1);
        }
        EXPECT_GT(velocity(group, stage.state()).z, 0.5) << "has bounced";
        EXPECT_EQ(stage.figures().touching, 0);
        EXPECT_NEAR(energy(group, stage.state()) / before, 1, 1e-6);
        EXPECT_LT(most, 1e-6);
        EXPECT_EQ(stage.figures().viscous_work, 0);
    }
}

TEST(Walls, BounceAsADampedOscillator) {
    // A ring: m x'' = -c x' - k x per node, from x = 0 at speed -1 until the force is no longer a push.
    RodSpec spec = test::simple_rod(16);
    spec.shape.closed = true;
    spec.shape.velocity = {0, 0, -1};
    spec.placement.tangent = {1, 0, 0};
    spec.placement.normal = Vec3d{0, 0, 1};
    spec.placement.origin = {0, 0, radius + 0.005};
    const RodGroup ring(spec, 0, 0, "");
    const double m = mass_of(ring) / 16, k = 2e4, w = std::sqrt(k / m);
    for (const double zeta : {0.05, 0.3}) {
        Stage<1> stage(ring, {start(ring)},
                       {floor_of({.normal = ContactNormal::linear, .stiffness = k, .damping = 2 * zeta * w * m})},
                       {0, 0, 0}, 2e-6);
        const double before = energy(ring, stage.state());
        stage.advance(20000);
        ASSERT_EQ(stage.figures().touching, 0);
        const double root = std::sqrt(1 - zeta * zeta),
                     at = std::atan2(2 * zeta * root, 2 * zeta * zeta - 1) / (root * w); // where N = 0
        const double out =
            -std::exp(-zeta * w * at) * (std::cos(root * w * at) - zeta / root * std::sin(root * w * at));
        EXPECT_NEAR(velocity(ring, stage.state()).z, out, 2e-3 * out) << zeta;
        EXPECT_NEAR(before - energy(ring, stage.state()), stage.figures().viscous_work, 2e-3 * before);
        EXPECT_NEAR(stage.figures().viscous_work, before * (1 - out * out), 2e-3 * before);
        EXPECT_EQ(stage.figures().friction_work, 0);
    }
}

/// On a floor, in the overlap that its weight needs.
State lying(const RodGroup& group, double stiffness, double weight) {
    const double radius = group.element[0].radius;
    State state = start(group);
    for (std::size_t i = 0; i < state.size(); ++i) {
        const double x = group.node_mass[i] * weight / stiffness;
        Vec3d at = lane(state[i].position, 0);
        at.z = radius - x;
        set_lane(state[i].position, 0, at);
    }
    return state;
}

TEST(Walls, HoldARodOnAnIncline) {
    // Thin, since friction at the bottom presses the front end and relieves the rear one: by 16 r sin(slope)/L of an
    // end's weight. And soft, so that an end, which weighs half, does not bear its neighbour's load: springs hold each
    // node by itself.
    const double mu = 0.5, kinetic = 0.4, k = 1e3, thin = 0.1 * radius;
    RodSpec spec = lying_rod(thin);
    spec.section.radius = thin;
    spec.material.youngs_modulus = 1e5;
    const RodGroup group(spec, 0, 0, "");
    for (const double share : {0.95, 1.05}) {
        const double slope = std::atan(share * mu);
        ContactLaw law = sticky(k, mu, kinetic);
        law.damping = 0.1;
        law.tangential_damping = 0.1;
        // Tilted slowly: under a load that comes at once springs swing beyond it and let go.
        const UniformForce fall{.force = {mass_of(group) * gravity * std::sin(slope), 0, 0}, .ramp = {0.5}};
        Stage<1> tilted(group, {lying(group, k, gravity * std::cos(slope))}, {floor_of(law)},
                        {0, 0, -gravity * std::cos(slope)}, 1e-5, 0, fall);
        tilted.advance(100000);
        const State before = tilted.state();
        tilted.advance(100000);
        const State after = tilted.state();
        if (share < 1) {
            EXPECT_LT(std::abs(centre(group, after).x - centre(group, before).x), 1e-6) << "creeps";
        } else {
            const double expected = gravity * (std::sin(slope) - kinetic * std::cos(slope));
            EXPECT_NEAR(velocity(group, after).x - velocity(group, before).x, expected, 0.01 * expected);
        }
    }
}

TEST(Walls, LetARodRollUntilItSlips) {
    const double k = 1e6;
    const RodGroup group(lying_rod(radius), 0, 0, "");
    for (const double slope : {0.2, 0.9}) {
        const double mu = 0.3; // tan/3: 0.068 and 0.42
        ContactLaw law = sticky(k, mu, mu);
        law.damping = 20;
        law.tangential_damping = 20;
        const Vec3d down{0, gravity * std::sin(slope), -gravity * std::cos(slope)};
        Stage<1> stage(group, {lying(group, k, gravity * std::cos(slope))}, {floor_of(law)}, down, 5e-6);
        stage.advance(40000);
        const State before = stage.state();
        stage.advance(40000);
        const State after = stage.state();
        const double acceleration = (velocity(group, after).y - velocity(group, before).y) / 0.2;
        const bool rolls = mu > std::tan(slope) / 3;
        const double expected =
            rolls ? 2.0 / 3 * gravity * std::sin(slope) : gravity * (std::sin(slope) - mu * std::cos(slope));
        EXPECT_NEAR(acceleration, expected, 0.01 * expected) << slope;
        const double rim = norm(lane(after[4].spin, 0)) * radius;
        if (rolls) EXPECT_NEAR(rim, velocity(group, after).y, 0.01 * rim);
        else EXPECT_LT(rim, 0.9 * velocity(group, after).y);
    }
}

TEST(Walls, HoldASlidingSnakeLessAlongItThanAcross) {
    const double k = 1e5;
    const RodGroup group(lying_rod(radius), 0, 0, "");
    ContactLaw law{.normal = ContactNormal::linear,
                   .stiffness = k,
                   .friction = ContactFriction::anisotropic,
                   .kinetic_friction = 0.2};
    law.kinetic_backward = 0.3;
    law.kinetic_sideways = 0.5;
    law.slip_speed = 1e-3;
    const auto slowed = [&](const Vec3d& speed, const Vec3d& spin = {0, 0, 0}, int steps = 10, double h = 1e-5,
                            int skipped = 0) {
        State state = lying(group, k, gravity);
        for (Slot<1>& s : state) {
            set_lane(s.velocity, 0, speed);
            set_lane(s.spin, 0, spin);
        }
        Stage<1> stage(group, {state}, {floor_of(law)}, {0, 0, -gravity}, h);
        stage.advance(skipped);
        const Vec3d before = velocity(group, stage.state());
        stage.advance(steps);
        EXPECT_GE(stage.figures().friction_work, 0);
        return (1 / (steps * h)) * (velocity(group, stage.state()) - before);
    };
    const double g = gravity;
    EXPECT_NEAR(slowed({1, 0, 0}).x, -0.2 * g, 1e-3 * g);
    EXPECT_NEAR(slowed({-1, 0, 0}).x, 0.3 * g, 1e-3 * g);
    EXPECT_NEAR(slowed({0, 1, 0}).y, -0.5 * g, 1e-3 * g);
    EXPECT_NEAR(slowed({0, -1, 0}).y, 0.5 * g, 1e-3 * g);
    const Vec3d aslant = slowed({0.6, 0.8, 0}); // shares of the slip, each with its own coefficient
    EXPECT_NEAR(aslant.x, -0.2 * 0.6 * g, 1e-3 * g);
    EXPECT_NEAR(aslant.y, -0.5 * 0.8 * g, 1e-3 * g);
    EXPECT_NEAR(slowed({5e-4, 0, 0}, {0, 0, 0}, 10, 1e-7, 5).x, -0.5 * 0.2 * g,
                1e-3 * g); // half the slip speed, half the friction
    // A rod that spins about its axis slips sideways: its frame is d3 = x, so body spin about d3 turns the lowest line
    // along +-y.
    const Vec3d rolled = slowed({0, 0, 0}, {0, 0, 100});
    EXPECT_NEAR(std::abs(rolled.y), 0.5 * g, 2e-2 * g);
    EXPECT_NEAR(rolled.x, 0, 1e-4 * g);
}

TEST(Walls, OfATubeHoldARodAtItsLowestLine) {
    const RodGroup group(lying_rod(0), 0, 0, "");
    Wall tube;
    tube.name = "tube";
    tube.kind = WallKind::tube;
    tube.point = {0.3, 0, 0};
    tube.axis = {2, 0, 0};
    tube.radius = 0.1;
    tube.law = {.normal = ContactNormal::linear, .stiffness = 1e5, .damping = 60};
    const auto at_height = [&](double y, double z) {
        State state = start(group);
        for (Slot<1>& s : state) set_lane(s.position, 0, lane(s.position, 0) + Vec3d{0, y, z});
        return state;
    };
    Stage<1> lowest(group, {at_height(0, -0.08)}, {tube}, {0, 0, -gravity}, 2e-5);
    lowest.advance(100000);
    const double arm = 0.08 + mass_of(group) * gravity / 9 / 1e5;
    EXPECT_NEAR(centre(group, lowest.state()).y, 0, 1e-12);
    EXPECT_NEAR(centre(group, lowest.state()).z, -arm, 1e-5);
    // Beside it the rod swings: as a point where it slides, with half as much inertia again where it rolls.
    for (const bool rolls : {false, true}) {
        if (rolls) {
            tube.law = sticky(1e5, 1, 1);
            tube.law.damping = tube.law.tangential_damping = 60;
        }
        const double angle = 0.05,
                     period = 2 * pi * std::sqrt((rolls ? 1.5 : 1) * arm / gravity) * (1 + angle * angle / 16);
        Stage<1> swing(group, {at_height(arm * std::sin(angle), -arm * std::cos(angle))}, {tube}, {0, 0, -gravity},
                       2e-5);
        double crossed = 0, before = 1, now = 1;
        int crossings = 0;
        for (; crossings < 4; before = now) {
            swing.advance(1);
            now = centre(group, swing.state()).y;
            if (before * now <= 0 && ++crossings % 4 != 2 && crossings != 3) crossed = swing.time() - crossed;
            ASSERT_LT(swing.time(), 5);
        }
        EXPECT_NEAR(crossed, 1.5 * period, 0.003 * period) << rolls;
    }
    // Around a tube and a ball the rod is pushed out.
    for (const WallKind kind : {WallKind::tube, WallKind::ball}) {
        Wall post = tube;
        post.kind = kind;
        post.law = {.normal = ContactNormal::linear, .stiffness = 1e4};
        post.side = WallSide::outside;
        post.point = lane(start(group)[4].position, 0) + Vec3d{0, 0, -(0.1 + radius - 0.001)};
        Stage<1> one(group, {start(group)}, {post}, {0, 0, 0}, 1e-6);
        one.advance(1);
        EXPECT_EQ(one.figures().touching, kind == WallKind::tube ? 9 : 1);
        EXPECT_NEAR(one.figures().force.z, kind == WallKind::tube ? -90 : -10, 1e-6);
    }
}

/// A box that shaken rods are thrown about in.
std::vector<Wall> box_and_ball(ContactLaw law) {
    Wall box = floor_of(law), ball = floor_of(law);
    box.name = "box";
    box.kind = WallKind::box;
    box.lower = {-0.1, -0.15, 0};
    box.upper = {1.1, 0.15, 0.3};
    ball.name = "ball";
    ball.kind = WallKind::ball;
    ball.side = WallSide::outside;
    ball.point = {0.5, 0, -0.05};
    ball.radius = 0.1;
    ball.velocity = {0.1, 0.2, 0.3};
    ball.from = 0.01;
    return {box, ball};
}

template <int W> void expect_lanes_alike(const ContactLaw& law) {
    const RodGroup group(lying_rod(0.1), 0, 0, "");
    std::vector<State> states;
    for (int i = 0; i < W; ++i)
        states.push_back(test::shaken_state(group, 0.001, 0.01, i == 1 ? 0.0 : 1.0, static_cast<unsigned>(i)));
    Stage<W> wide(group, states, box_and_ball(law), {0, 0, -gravity}, 2e-5);
    wide.advance(20000);
    for (int i = 0; i < W; ++i) {
        Stage<1> one(group, {nth(states, i)}, box_and_ball(law), {0, 0, -gravity}, 2e-5);
        one.advance(20000);
        for (std::size_t k = 0; k < one.slots().size(); ++k) {
            const Slot<1> a = lane(wide.slots()[k], i), b = one.slots()[k];
            ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0) << "W " << W << " lane " << i << " slot " << k;
        }
        double friction_work = 0;
        for (int w = 0; w < 7; ++w) {
            const WallFigures a = wide.figures(w, i), b = one.figures(w, 0);
            EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0) << "W " << W << " lane " << i << " wall " << w;
            friction_work += a.friction_work;
        }
        EXPECT_TRUE(law.friction == ContactFriction::none || friction_work > 0);
        if (i > 1) break;
    }
}
TEST(Walls, GiveTheSameBitsInAllLanes) {
    ContactLaw law{.normal = ContactNormal::hertz,
                   .stiffness = 1e5,
                   .damping = 100,
                   .friction = ContactFriction::memory,
                   .static_friction = 0.5,
                   .kinetic_friction = 0.4};
    law.slip_speed = 1e-2;
    law.kinetic_backward = 0.7;
    law.kinetic_sideways = 1.1;
    for (const ContactFriction friction :
         {ContactFriction::none, ContactFriction::memory, ContactFriction::regularised, ContactFriction::anisotropic}) {
        law.friction = friction;
        expect_lanes_alike<2>(law);
        expect_lanes_alike<4>(law);
        expect_lanes_alike<8>(law);
    }
}

TEST(Walls, LeaveLanesThatDoNotTouchAsTheyAre) {
    // Even a zero keeps its sign.
    const RodGroup group(lying_rod(0.1), 0, 0, "");
    State low = start(group);
    for (Slot<1>& s : low) set_lane(s.position, 0, lane(s.position, 0) - Vec3d{0, 0, 0.09});
    Stage<2> stage(group, {start(group), low}, {floor_of(sticky(1e4, 0.5, 0.4))}, {0, 0, 0}, 1e-5);
    stage.advance(1);
    AlignedVector<SlotLoad<2>> load(low.size());
    for (SlotLoad<2>& l : load)
        l = {broadcast<2>(Vec3d{-0.0, -0.0, -0.0}), broadcast<2>(Vec3d{-0.0, -0.0, -0.0}), Pack<2>(1.0)};
    const Step step{.index = 2, .dt = 1e-5, .drift = 1e-5, .kick = 1e-5, .time = 1e-5};
    stage.wall_pass->prepare({&step, 1});
    stage.wall_pass->run(stage.tile(), load.data(), step);
    EXPECT_GT(load[3].force.z[1], 0);
    for (const SlotLoad<2>& l : load)
        for (const double zero : {l.force.x[0], l.force.z[0], l.couple.x[0], l.couple.y[0]})
            EXPECT_TRUE(zero == 0 && std::signbit(zero));
}

TEST(Walls, TakeWhatRodsGive) {
    // Momentum that a rod loses is what walls get.
    const RodGroup group(lying_rod(0.05), 0, 0, "");
    Stage<1> stage(group, {test::shaken_state(group, 0.001, 0.01, 1, 7)}, box_and_ball(sticky(1e4, 0.5, 0.4)),
                   {0, 0, 0}, 2e-5);
    Vec3d given{0, 0, 0};
    const Vec3d before = test::momenta(group, stage.state()).linear;
    double size = 0;
    for (int step = 0; step < 20000; ++step) {
        stage.advance(1);
        for (int w = 0; w < 7; ++w) {
            given += 2e-5 * stage.figures(w).force;
            size += 2e-5 * norm(stage.figures(w).force);
        }
    }
    EXPECT_GT(size, 1);
    EXPECT_LT(norm(before - test::momenta(group, stage.state()).linear - given), 1e-12 * size);
}

TEST(Walls, CloseTheEnergyAccount) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const ContactFriction friction :
             {ContactFriction::memory, ContactFriction::regularised, ContactFriction::anisotropic}) {
            RodSpec spec = lying_rod(radius + 0.002, 8, Law::linear);
            spec.shape.velocity = {0.3, 0.5, -1};
            const RodGroup group(spec, 0, 0, "");
            ContactLaw law{.normal = normal,
                           .stiffness = normal == ContactNormal::linear ? 1e4 : 1e5,
                           .damping = normal == ContactNormal::linear ? 3.0 : 100.0,
                           .friction = friction,
                           .static_friction = 0.3,
                           .kinetic_friction = 0.3,
                           .kinetic_backward = 0.5,
                           .kinetic_sideways = 0.2,
                           .tangential_damping = 1,
                           .slip_speed = 0.01};
            Stage<1> stage(group, {start(group)}, {floor_of(law)}, {0, 0, -gravity}, 5e-7);
            const double weight = mass_of(group) * gravity,
                         before = energy(group, stage.state()) + weight * centre(group, stage.state()).z;
            double worst = 0;
            for (int look = 0; look < 100; ++look) {
                stage.advance(2000);
                const WallFigures a = stage.figures();
                const double now = energy(group, stage.state()) + weight * centre(group, stage.state()).z;
                if (a.touching == 0)
                    worst = std::max(
                        worst, std::abs(now + a.elastic_energy + a.friction_work + a.viscous_work - before) / before);
            }
            EXPECT_GT(stage.figures().friction_work, 0.05 * before);
            EXPECT_GT(stage.figures().viscous_work, 0.05 * before);
            EXPECT_EQ(stage.figures().touching, 0);
            EXPECT_LT(worst, 1e-3) << static_cast<int>(normal) << static_cast<int>(friction);
        }
}

TEST(Walls, GoOnFromWhatTheyRemember) {
    RodSpec spec = lying_rod(radius);
    spec.shape.velocity = {0.1, 0.2, 0};
    const RodGroup group(spec, 0, 0, "");
    ContactLaw law = sticky(1e4, 0.5, 0.4);
    law.damping = 5;
    const auto make = [&](std::int64_t done) {
        return Stage<1>(group, {lying(group, 1e4, gravity)}, {floor_of(law)}, {0, 0, -gravity}, 2e-5, done);
    };
    Stage<1> whole = make(0), other = make(3000);
    whole.advance(3000);
    ASSERT_GT(whole.figures().touching, 0);
    ASSERT_GT(whole.figures().elastic_energy, 0);
    std::vector<double> memory;
    whole.wall_pass->append_memory(whole.tile(), 0, memory);
    ASSERT_EQ(memory.size(), 2 + 9 * 8u); // two sums, and per node what the contact keeps
    for (std::size_t k = 0; k < whole.slots().size(); ++k) other.tile().slot[k] = whole.slots()[k];
    EXPECT_EQ(other.wall_pass->restore(other.tile(), 0, memory), memory.size());
    whole.advance(3000);
    other.advance(3000);
    for (std::size_t k = 0; k < whole.slots().size(); ++k)
        EXPECT_EQ(std::memcmp(&whole.slots()[k], &other.slots()[k], sizeof(Slot<1>)), 0) << k;
    const WallFigures a = whole.figures(), b = other.figures();
    EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

TEST(Walls, ActOnTheGroupsTheyName) {
    const RodGroup group(lying_rod(0), 0, 0, "");
    Wall floor = floor_of(sticky(1e4, 0.5, 0.4));
    floor.rods = {"others"};
    Stage<1> stage(group, {start(group)}, {floor}, {0, 0, 0}, 1e-5);
    stage.advance(10);
    EXPECT_EQ(stage.figures().touching, 0);
    EXPECT_EQ(test::momenta(group, stage.state()).linear.z, 0);
}

TEST(Walls, ThatMoveCarryRodsAlong) {
    // A floor that moves sideways drags the rod up to its own speed, one that rises lifts it.
    const RodGroup group(lying_rod(radius), 0, 0, "");
    ContactLaw law = sticky(1e5, 0.5, 0.5);
    law.damping = 10;
    law.tangential_damping = 10;
    Wall floor = floor_of(law);
    floor.velocity = {0.2, 0, 0.1};
    floor.from = 0.1;
    Stage<1> stage(group, {lying(group, 1e5, gravity)}, {floor}, {0, 0, -gravity}, 1e-5);
    stage.advance(100000);
    EXPECT_NEAR(velocity(group, stage.state()).x, 0.2, 1e-4);
    EXPECT_NEAR(centre(group, stage.state()).z, radius + 0.9 * 0.1, 1e-3);
}

} // namespace
} // namespace skein
