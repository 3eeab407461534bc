// The snake of Gazzola et al. 2018 as PyElastica's example has it: a wave of muscle couple runs from its end to its start, and it crawls by
// friction that holds more across than along. Eleven periods of that example gave 0.1589 lengths per period ahead, -0.013 to the side.
#include "validation/study.hpp"

#include <numbers>

namespace skein {
namespace {

constexpr double length = 0.35, period = 2, gravity = 9.80665, radius = 0.011 * length;

SceneSpec snake(Law law, DampingScheme damping, double dt) {
    SceneSpec scene;
    scene.time = {.duration = 11 * period, .dt = dt, .damping = damping};
    RodSpec rod;
    rod.name = "snake";
    rod.material = {.density = 1000, .youngs_modulus = 1e6, .shear_modulus = 1e6 / 1.5, .law = law};
    rod.section = {.radius = radius};
    rod.shape = {.length = length, .elements = 50};
    rod.placement = {.origin = {0, 0, radius}, .tangent = {1, 0, 0}, .normal = Vec3d{0, 0, 1}};
    scene.rods = {rod};
    const double mu = length / (period * period * gravity * 0.1);
    scene.loads = {{.load = Gravity{{0, 0, -gravity}}},
                   {.load = MuscleTorques{.coefficients = {3.4e-3, 3.3e-3, 4.2e-3, 2.6e-3, 3.6e-3, 3.5e-3},
                                          .period = period,
                                          .wave_number = 2 * std::numbers::pi,
                                          .direction = {0, 0, 1},
                                          .ramp = period}},
                   {.load = PlaneFriction{.stiffness = 1, .damping = 1e-6, .kinetic_forward = mu, .kinetic_backward = 1.5 * mu, .kinetic_sideways = 2 * mu}}};
    scene.damping = {{.damping = {.kind = DampingKind::legacy, .rate = 2e-3}}};
    return scene;
}

struct Crawl {
    double ahead, sideways; ///< lengths per period
};

/// Mean over whole periods after the first: the way of the middle along and across the mean direction of each period.
Crawl crawl(SceneSpec scene) {
    test::Stage stage(std::move(scene), 1);
    const std::int64_t steps = std::llround(period / stage.plan.dt), looks = 100;
    Crawl sum{0, 0};
    Vec3d before{0, 0, 0};
    for (int p = 0; p < 11; ++p) {
        Vec3d middle{0, 0, 0}, along{0, 0, 0};
        for (std::int64_t look = 1; look <= looks; ++look) {
            stage.advance(p * steps + steps * look / looks);
            const auto state = stage.state(0);
            middle = {0, 0, 0};
            for (std::size_t i = 0; i < state.size(); ++i) middle += (i == 0 || i == 50 ? 0.01 : 0.02) * lane(state[i].position, 0);
            along += lane(state.back().position, 0) - lane(state.front().position, 0);
        }
        along = (1 / norm(along)) * along;
        const Vec3d way = (1 / length) * (middle - before), up{0, 0, 1};
        before = middle;
        if (p == 0) continue;
        sum.ahead += dot(way, along) / 10;
        sum.sideways += dot(way, cross(up, along)) / 10;
        EXPECT_NEAR(middle.z, radius, 0.1 * radius);
    }
    return sum;
}

TEST(CrawlingSnake, IsAsFastAsThePublishedOne) {
    const struct {
        const char* name;
        Law law;
        DampingScheme damping;
        double dt;
    } cases[] = {{"elastica", Law::elastica, DampingScheme::after, 1e-4}, {"incompressible", Law::incompressible, DampingScheme::midpoint, 1e-4},
                 {"incompressible, half the step", Law::incompressible, DampingScheme::midpoint, 5e-5}};
    for (const auto& c : cases) {
        const Crawl found = crawl(snake(c.law, c.damping, c.dt));
        std::printf("%s: %.4f lengths per period ahead, %.4f sideways\n", c.name, found.ahead, found.sideways);
        EXPECT_NEAR(std::abs(found.ahead), 0.1589, 0.03 * 0.1589) << c.name;
    }
}

} // namespace
} // namespace skein
