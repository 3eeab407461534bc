#include "studies/self_check.hpp"

#include "coupling/interaction.hpp"
#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"
#include "partition/partition.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "skein/time/clock.hpp"

namespace skein {

namespace {

SceneSpec self_check_scene() {
    const ContactLaw law = {.normal = ContactNormal::linear,
                            .stiffness = 2e3,
                            .damping = 0.05,
                            .friction = ContactFriction::memory,
                            .static_friction = 0.4,
                            .tangential_damping = 0.01};
    RodSpec lying;
    lying.name = "lying";
    lying.material = {.density = 1100, .youngs_modulus = 2e6};
    lying.section = {.radius = 5e-3};
    lying.shape = {.length = 0.2, .elements = 9};
    lying.placement = {.kind = PlacementKind::lattice,
                       .origin = {0, 0, 6e-3},
                       .tangent = {1, 0, 0},
                       .counts = {1, 12},
                       .spacing = {1, 0.0125}};
    lying.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 2e4, .direction = {1, 0, 0}};
    RodSpec falling = lying;
    falling.name = "falling";
    falling.material.law = Law::linear;
    falling.section = {.kind = SectionKind::elliptic, .radius = 5e-3, .radius_2 = 4e-3, .taper = 0.75};
    falling.shape = {.length = 0.15, .elements = 7, .rest_curvature = {0.5, 0, 0.25}, .velocity = {0.25, 0, -0.75}};
    falling.placement = {.kind = PlacementKind::lattice,
                         .origin = {0.01, 0, 0.017},
                         .tangent = {0, 1, 0},
                         .counts = {12, 1},
                         .spacing = {0.0155, 1}};
    falling.magnetisation = {};
    RodSpec body; // of all kinds of parts
    body.name = "body";
    body.material.density = 1100;
    body.body = BodySpec{.spheres = {{{0.02, 0, 0}}, {8e-3}},
                         .capsules = {{{0, 0, 0}}, {{-0.02, 0.01, -5e-3}}, {5e-3}},
                         .boxes = {{{0, 0, 0}}, {{0.03, 0.02, 0.016}}, {3e-3}}};
    body.shape.velocity = {0, 0.25, -2.5};
    body.shape.angular_velocity = {10, -5, 20};
    body.placement = {.origin = {0.09, 0.07, 0.048}, .tangent = {0.1, 0.2, 1}};

    SceneSpec scene;
    scene.title = "self-check";
    scene.time = {.duration = 0.012, .dt = 1e-5};
    scene.rods = {lying, falling, body};
    scene.loads = {{.load = Gravity{}}, {.load = MagneticField{.constant = {0, 0, 0.05}}}};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 2}}};
    scene.contact = ContactSpec{.law = law};
    Wall floor;
    floor.name = "floor";
    floor.law = law;
    scene.walls = {floor};
    check_scene(scene);
    return scene;
}

} // namespace

std::uint64_t self_check(const Communicator& comm, const Threads& threads, int lanes) {
    const SceneSpec scene = self_check_scene();
    const std::vector<RodGroup> groups = make_groups(scene);
    const Plan plan = make_plan(scene, groups, {.ranks = comm.size(), .threads = threads.count(), .lanes = lanes});
    Surroundings around;
    const std::unique_ptr<Rods> rods = make_rods(plan, groups, partition(comm, groups), threads, around);
    Neighbourhood neighbourhood(comm, threads, around.exposure);
    const Interactions interactions = make_interactions({comm, threads, plan, groups, *rods, around});
    Timers timers;
    for (Clock clock(plan.dt, 0, plan.integrator); clock.done() < plan.steps;) {
        const auto steps = clock.next(plan.steps, 1);
        rods->drift(steps.front());
        add_loads(interactions, neighbourhood, steps.front(), timers);
        rods->kick(steps.front(), false);
        clock.advance(steps);
    }
    return comm.sum_wrapping(rods->digest());
}

} // namespace skein
