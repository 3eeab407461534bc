// Whole scenes made in C++, and rods ready to step.
#pragma once

#include "kernels/kernels.hpp"
#include "loads/magnetic_field.hpp"
#include "mechanics/rod_copies.hpp"
#include "plan/plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <initializer_list>
#include <string>
#include <vector>

namespace skein::test {

inline constexpr double gravity = 9.81; ///< m/s2

/// Of these numbers of lanes those that have kernels of their own in this build, on this processor.
inline std::vector<int> built_lanes(std::initializer_list<int> lanes = {1, 2, 4, 8}) {
    std::vector<int> built;
    for (const int wanted : lanes)
        if (kernels(wanted).lanes == wanted) built.push_back(wanted);
    return built;
}
/// Those beside the one that serves for one lane.
inline std::vector<int> other_lanes() {
    std::vector<int> others;
    for (const int lanes : built_lanes())
        if (lanes != kernels(1).lanes) others.push_back(lanes);
    return others;
}
/// Reason to skip comparisons of widths; empty: there are several.
inline std::string one_width() {
    if (!other_lanes().empty()) return {};
    return "kernels of one width alone are built: -DSKEIN_WIDTHS=\"1;2;4;8\" builds others to compare it with";
}

/// Largest distance between nodes of two states of a rod, m.
inline double distance(const std::vector<Slot<1>>& a, const std::vector<Slot<1>>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        most = std::max(most, norm(lane(a[i].position, 0) - lane(b[i].position, 0)));
    return most;
}

/// A cilium of the paper's carpet, `count` of them in a row: clamped, magnetised in a wave, legacy damping.
inline SceneSpec cilia_scene(long count, long elements = 25, EndKind start = EndKind::clamped) {
    SceneSpec scene;
    scene.title = "cilia";
    scene.time = {.duration = 7.2};
    RodSpec rod;
    rod.name = "cilia";
    rod.material = {.density = 2390, .youngs_modulus = 1.85e5, .shear_modulus = 6.16e4};
    rod.section = {.radius = 0.15};
    rod.shape = {.length = 1.5, .elements = elements};
    rod.placement = {.kind = PlacementKind::line, .counts = {count}, .spacing = {1.5}};
    rod.start = start;
    rod.magnetisation = {.pattern = MagnetisationPattern::wave_x, .strength = 18999, .wavelength_x = 10.5};
    scene.rods.push_back(rod);
    scene.loads.push_back(
        {.load = MagneticField{.constant = {0, 8e-4, 0}, .rotating = 0.08, .period = 72, .ramp = {0.01}}});
    scene.damping.push_back({.damping = {.kind = DampingKind::legacy, .rate = 0.5}});
    return scene;
}

/// All rods of a scene on this process, in scene order.
inline std::vector<LocalRod> all_rods(std::span<const RodGroup> groups) {
    std::vector<LocalRod> rods;
    for (const RodGroup& g : groups)
        for (std::int64_t i = 0; i < g.count(); ++i) rods.push_back({g.first_gid() + i, g.id(), i});
    return rods;
}

/// Groups, plan and rods of a scene, kept together.
struct Stage {
    SceneSpec scene;
    std::vector<RodGroup> groups;
    Plan plan;
    Threads threads;
    std::unique_ptr<Rods> rods;
    Clock clock;

    explicit Stage(SceneSpec s, int lanes = 8, int thread_count = 1, Mapping mapping = Mapping::automatic)
        : scene(std::move(s)), groups(make_groups(scene)),
          plan(make_plan(scene, groups, {1, thread_count, thread_count, lanes, {}, mapping})), threads(thread_count),
          rods(make_rods(plan, groups, all_rods(groups), threads)), clock(plan.dt, 0, plan.integrator) {}

    /// Steps up to step `until` in batches of at most `batch` steps.
    void advance(std::int64_t until, std::int64_t batch = Clock::largest_batch) {
        while (clock.done() < until) {
            const auto steps = clock.next(until, batch);
            rods->advance(steps, false);
            clock.advance(steps);
        }
    }
    /// State of rod i at the present time: positions and directors brought up to the rates.
    std::vector<Slot<1>> state(std::size_t i) const {
        const RodGroup& group = nth(groups, rods->local()[i].group);
        std::vector<Slot<1>> out(static_cast<std::size_t>(group.slots()));
        rods->export_rod(i, out);
        if (clock.lag() > 0) synchronise(group, out, clock.lag());
        return out;
    }
};

} // namespace skein::test
