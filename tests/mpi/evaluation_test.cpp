// Forces that are evaluated for figures alone: they are those of one rank, and leave the state, the memory of contacts
// and walls, and later steps as they are.
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "simulation/world.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <random>

namespace skein {
namespace {

/// Rods that slide and fall into each other and a floor, with friction that remembers.
SceneSpec heap() {
    const ContactLaw law{.stiffness = 200, .damping = 0.1, .friction = ContactFriction::memory, .static_friction = 0.4};
    SceneSpec scene;
    scene.title = "heap";
    scene.time = {.duration = 1, .dt = 1e-5};
    scene.contact = ContactSpec{.law = law};
    Wall floor;
    floor.name = "floor";
    floor.law = law;
    scene.walls.push_back(floor);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform;
    for (const bool faster : {false, true}) {
        RodSpec rod = test::simple_rod(6);
        rod.name = faster ? "faster" : "slower";
        rod.shape.velocity = {faster ? 0.5 : -0.3, 0, -0.5};
        rod.placement = {.kind = PlacementKind::list, .tangent = {1, 0, 0}};
        for (int i = 0; i < 30; ++i)
            rod.placement.origins.push_back(
                {0.4 * uniform(random), 0.6 * uniform(random), 0.015 + 0.2 * uniform(random)});
        scene.rods.push_back(rod);
    }
    return scene;
}

bool is_of_search(const std::string& name) {
    return name == "candidates[-]" || name == "rebuilds[-]" || name == "skin[m]";
}

struct Heap {
    explicit Heap(const Communicator& comm) : world(make(comm)) {}

    const SceneSpec scene = heap();
    const Threads threads{2};
    World world;

    /// Figures by name, without those of the search for candidates, which begins anew.
    std::map<std::string, double> figures() const {
        const std::vector<std::string> names = names_of_figures(world.interactions());
        const std::vector<double> values =
            values_of_figures(world.comm, world.interactions(), {world.clock.time(), 0, world.solved().has_value()});
        std::map<std::string, double> all;
        for (std::size_t i = 0; i < names.size(); ++i)
            if (!is_of_search(names[i])) all[names[i]] = values[i];
        return all;
    }
    /// All that a checkpoint has.
    std::vector<std::vector<double>> kept() {
        std::vector<std::vector<double>> all;
        for (const SavedNumbers& one : saved(world.interactions())) {
            all.push_back(one.numbers);
            all.push_back(one.rows);
        }
        for (std::size_t i = 0; i < world.rods().local().size(); ++i) {
            all.push_back(world.rods().memory(i));
            std::vector<Slot<1>> state(7);
            world.rods().export_rod(i, state);
            std::vector<double>& numbers = all.emplace_back(state.size() * sizeof(Slot<1>) / sizeof(double));
            std::memcpy(numbers.data(), state.data(), numbers.size() * sizeof(double));
        }
        return all;
    }

private:
    World make(const Communicator& comm) {
        std::vector<RodGroup> groups = make_groups(scene);
        Plan plan = make_plan(scene, groups, {comm.size(), 1, 2, 2, {}, Mapping::across});
        return {comm, threads, std::move(groups), std::move(plan), Protocol::asynchronous, Balance::never};
    }
};

TEST(EvaluationAtRest, LeavesNoTrace) {
    Heap plain(Communicator::world()), looked_at(Communicator::world());
    EXPECT_EQ(looked_at.figures()["contacts[-]"], 0) << "no step has been made";
    looked_at.world.evaluate_at_rest(0);
    EXPECT_GT(looked_at.figures()["contacts[-]"], 10);
    for (const std::int64_t step : {1, 8, 9, 40}) {
        plain.world.advance(step);
        looked_at.world.advance(step);
        const auto figures = looked_at.figures();
        EXPECT_EQ(figures, plain.figures()) << step;
        for (int i = 0; i < 2; ++i) {
            looked_at.world.evaluate_at_rest(3.0 + i);
            EXPECT_EQ(looked_at.kept(), plain.kept()) << step;
            EXPECT_EQ(looked_at.world.digest(), plain.world.digest()) << step;
            EXPECT_NE(looked_at.figures(), figures) << "dashpots do nothing at rest";
            EXPECT_GT(looked_at.figures()["wall_contacts[-]"], 10);
        }
    }
}

TEST(EvaluationAtRest, IsThatOfOneRank) {
    Heap shared(Communicator::world()), alone(Communicator::alone());
    for (Heap* one : {&shared, &alone}) {
        one->world.advance(20);
        one->world.evaluate_at_rest(1);
    }
    const auto of_all = shared.figures(), of_one = alone.figures();
    for (const auto& [name, value] : of_one) EXPECT_EQ(of_all.at(name), value) << name;
    shared.world.show_solution(1);
    for (const auto& [name, value] : shared.figures())
        EXPECT_EQ(std::isnan(value), name.find("_work") != std::string::npos) << name;
}

} // namespace
} // namespace skein
