#include "scenes/work_precision/cases.hpp"

#include "support/timoshenko_cantilever.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein::bench {

namespace {

/// Nothing where the tip never stays within.
std::optional<Outcome> to_one_percent(const Config& config, long n, double dt) {
    SceneSpec scene = test::timoshenko_cantilever::scene(n);
    configure(scene, config, {n}, scene.time.duration);
    scene.time.dt = dt;
    test::Stage stage(scene, 1);
    Outcome outcome, reached;
    const std::int64_t look = std::max<std::int64_t>(1, stage.plan.steps / 1000);
    bool within = false;
    for (std::int64_t step = look; step <= stage.plan.steps; step += look) {
        test::advance(stage, step, outcome.cost);
        const double deflection = relative_deflection(stage), error = std::abs(deflection - 1);
        if (error <= 0.01 && !within) {
            reached = finished(stage, outcome);
            reached.value = {{deflection, 0, 0}};
        }
        within = error <= 0.01;
    }
    if (!within) return {};
    return reached;
}

} // namespace

void one_percent(Table& table) {
    struct Way {
        Config config;
        double step_over_length = 0; ///< dt over the element length, s/m; 0: automatic
        double least = std::numeric_limits<double>::infinity();
        long n = 0;
        double steps = 0;
    };
    constexpr Choices choices{.clamp = true, .damping = true};
    const Config published = one_at_a_time(choices).back();
    std::vector<Way> ways{
        {{}}, {{.name = "clamped_frozen", .clamp = EndKind::clamped_frozen}}, {published}, {published, 0.01}};
    ways.back().config.name = "published dt";
    for (Way& way : ways) {
        for (const long n : {4, 5, 6, 7, 8, 10, 12, 16, 20, 40, 60, 80, 90, 95, 100, 105, 110, 120, 140}) {
            if (way.config.clamp == EndKind::clamped && n > 20) continue; // long since within
            const double length = test::timoshenko_cantilever::beam.length / static_cast<double>(n);
            const auto reached = to_one_percent(way.config, n, way.step_over_length * length);
            if (!reached) continue;
            table.add("one_percent", choices, way.config, n, *reached, std::abs(reached->value[0].x - 1));
            if (reached->cost.element_steps < way.least) {
                way.least = reached->cost.element_steps;
                way.n = n;
                way.steps = reached->cost.element_steps / static_cast<double>(n);
            }
        }
    }
    fmt::print("\nwork to 1 % of the tip's deflection, best n\n");
    for (const Way& way : ways)
        fmt::print("{:<15} n {:>3}, {:>6.0f} steps, {:.3e} element-steps, {:>6.1f} times the default's\n",
                   way.config.name, way.n, way.steps, way.least, way.least / ways[0].least);
    fmt::print("\n");
}

} // namespace skein::bench
