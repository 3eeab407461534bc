// A physics that is no part of Skein: a class that makes its plan and what runs it. It acts between rods, alone and
// beside contact, has a limit, a line in the plan, a column in the series and a state in checkpoints.
#include "coupling/interaction.hpp"
#include "diagnostics/observables.hpp"
#include "kernels/kernels.hpp"
#include "neighbourhood/neighbourhood.hpp"
#include "parallel/exact_sum.hpp"
#include "physics/plan_input.hpp"
#include "plan/plan_line.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "simulation/world.hpp"
#include "support/interaction_examples.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

constexpr double stiffness = 3; // N/m

/// Springs from each node to the plane z = 0, by slot.
class Tether final : public Interaction {
public:
    explicit Tether(const InteractionParts& parts) { rebind(parts); }

    bool couples() const override { return true; }
    bool holds() override { return built_; }
    double begin_rebuild() override {
        built_ = true;
        return 0;
    }
    void rebind(const InteractionParts& parts) override {
        exposure_ = parts.around.exposure;
        loads_ = parts.around.loads;
    }
    void add_own(const Step&) override { loads_->begin(*exposure_); }
    void add_shared(const Step&) override {
        energy_ = 0;
        for (std::size_t slot = 0; slot < exposure_->slots(); ++slot) {
            if (!exposure_->owns_slot(slot)) continue;
            const double z = exposure_->node[slot].position.z;
            loads_->at(*exposure_, slot).force.z -= stiffness * z;
            energy_ += 0.5 * stiffness * z * z;
        }
        ++steps_;
    }
    std::vector<Figure> figures(const Sample&) const override {
        return {{"tether_energy[J]", Figure::Of::largest, {energy_}}};
    }
    std::string saved_name() const override { return "tether"; }
    SavedNumbers saved() const override { return {.name = saved_name(), .numbers = {static_cast<double>(steps_)}}; }
    void restore(const SavedNumbers& kept) override { steps_ = std::llround(kept.numbers.at(0)); }

    std::int64_t steps() const { return steps_; }

private:
    std::shared_ptr<const Exposure> exposure_;
    std::shared_ptr<SlotLoads> loads_;
    bool built_ = false;
    double energy_ = 0;
    std::int64_t steps_ = 0;
};

class PlannedTether final : public PhysicsPlan, public StartsInteraction {
public:
    std::string summary(const Plan&) const override { return "tether"; }
    std::vector<PlanLine> describe(const Plan&) const override {
        return {{"tether", "springs of 3 N/m to a plane", "tether", stiffness}};
    }
    void tighten_limits(GroupPlan& p, const RodGroup& group, const Scheme&) const override {
        const double rate = 2 / p.limits.front().dt;
        p.limit("tether", 2 / std::sqrt(rate * rate + stiffness / group.node_mass.front()), 0);
    }
    bool acts_between_rods() const override { return true; }
    Coupling coupling() const override { return Coupling::every_step; }
    std::unique_ptr<Interaction> start(const InteractionParts& parts) const override {
        return std::make_unique<Tether>(parts);
    }
};

Plan plan_with_tether(const SceneSpec& scene, std::span<const RodGroup> groups) {
    PlannedPhysics physics;
    PhysicsTables::plan({scene, scene, groups}, physics);
    physics.add<PlannedTether>();
    return make_plan(scene, physics.take(), groups, {Communicator::world().size(), 1, 1, 1, {}, Mapping::automatic});
}

/// A rod that is stiff against the springs: it swings as a whole.
SceneSpec swinging() {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(8);
    rod.placement.origin = {0, 0, 0.01};
    rod.placement.tangent = {1, 0, 0};
    rod.placement.normal = Vec3d{0, 0, 1};
    scene.rods = {rod};
    scene.time = {.duration = 1};
    return scene;
}

TEST(NewPhysics, MovesRodsAsItsForcesSay) {
    const SceneSpec scene = swinging();
    auto groups = make_groups(scene);
    Plan plan = plan_with_tether(scene, groups);
    EXPECT_NE(to_text(plan).find("springs of 3 N/m to a plane"), std::string::npos) << to_text(plan);
    EXPECT_NE(to_text(plan, false).find("physics       tether"), std::string::npos) << to_text(plan, false);
    EXPECT_NE(to_json(plan).find("\"tether\": 3.0"), std::string::npos) << to_json(plan);
    EXPECT_EQ(plan.groups[0].program.names().at(2), "expose");

    double mass = 0;
    for (const double node : groups[0].node_mass) mass += node;
    const double rate = std::sqrt(stiffness * static_cast<double>(groups[0].slots()) / mass);
    const Threads threads(1);
    World world(Communicator::world(), threads, std::move(groups), std::move(plan), Protocol::asynchronous,
                Balance::never);
    world.advance(world.clock.step_at(2.5 / rate));
    const double t = world.clock.time() - world.clock.lag(),
                 middle = observe(world.comm, threads, world.groups, world.rods(), t, 0)[observed_centre + 2];
    EXPECT_NEAR(middle, 0.01 * std::cos(rate * t), 2e-4);
    EXPECT_EQ(names_of_figures(world.interactions()), std::vector<std::string>{"tether_energy[J]"});

    const auto copy = world.copy();
    const std::int64_t then = world.clock.done();
    world.advance(then + 500);
    const std::uint64_t digest = world.digest();
    world.go_back(*copy);
    world.evaluate_at_rest(0);
    EXPECT_EQ(dynamic_cast<const Tether&>(*world.interactions().front()).steps(), then);
    world.advance(then + 500);
    EXPECT_EQ(world.digest(), digest);
}

/// Beside contact both forces act: rods that touch are pushed apart, and all are drawn to the plane.
TEST(NewPhysics, ActsBesideContact) {
    for (const test::InteractionExample& e : test::interaction_examples()) {
        SceneSpec scene = e.scene({.normal = ContactNormal::linear, .stiffness = 1e5}, test::Turn{});
        if (!scene.contact) continue;
        const auto force_on_all = [&](bool tethered) {
            auto groups = make_groups(scene);
            Plan plan = tethered ? plan_with_tether(scene, groups)
                                 : make_plan(scene, groups, {Communicator::world().size(), 1, 1, 1});
            const Threads threads(1);
            World world(Communicator::world(), threads, std::move(groups), std::move(plan), Protocol::asynchronous,
                        Balance::never);
            const auto momentum = [&] {
                return observe(world.comm, world.threads, world.groups, world.rods(), world.clock.time(), 0);
            };
            const std::vector<double> before = momentum();
            double drawn = 0;
            for (int step = 0; step < 1000; ++step) {
                world.advance(world.clock.done() + 1);
                for (std::size_t slot = 0; slot < world.exposure()->slots(); ++slot)
                    if (world.exposure()->owns_slot(slot))
                        drawn -= stiffness * world.exposure()->node[slot].position.z * world.plan.dt;
            }
            return std::pair(momentum()[observed_energies + 2] - before[observed_energies + 2],
                             exact_sums(world.comm, std::vector<std::vector<double>>{{drawn}}).front());
        };
        const auto [change, drawn] = force_on_all(true);
        EXPECT_NEAR(change, drawn, 1e-9 * std::abs(drawn)) << e.name;
        EXPECT_LT(std::abs(force_on_all(false).first), 1e-6 * std::abs(drawn)) << e.name;
    }
}

} // namespace
} // namespace skein
