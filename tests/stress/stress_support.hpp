// What stress tests share: runs that stop as the program does, start states node by node, and what must not change.
#pragma once

#include "core/rotation.hpp"
#include "mechanics/rod_copies.hpp"
#include "scene/make_plan.hpp"
#include "support/energy.hpp"
#include "support/scenes_for_tests.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

namespace skein::test {

/// SKEIN_LONG=1: runs of full length where the suite's are shortened.
inline bool long_runs() {
    const char* text = std::getenv("SKEIN_LONG");
    return text && *text && *text != '0';
}

/// Steps up to `until`, looking at the rods every 64 steps; throws NumericalError as a run would.
inline void advance_checked(Stage& stage, std::int64_t until) {
    while (stage.clock.done() < until) {
        const auto steps = stage.clock.next(until);
        const bool fit = stage.rods->advance(steps, true);
        stage.clock.advance(steps);
        if (!fit) stage.rods->inspect(stage.clock.done(), stage.plan.dt);
    }
}

/// Plans and builds anew, after a test has changed constants of a group.
inline void rebuild(Stage& stage) {
    stage.plan = make_plan(stage.scene, stage.groups, stage.plan.machine);
    stage.rods = make_rods(stage.plan, stage.groups, all_rods(stage.groups), stage.threads);
    stage.clock = Clock(stage.plan.dt, 0);
}

/// `count` rods in one group, side by side in SIMD lanes; far apart only for clarity, they do not feel each other.
inline Placement in_a_row(long count) { return {.kind = PlacementKind::line, .counts = {count}, .spacing = {1}}; }

/// Adds normally distributed velocities and spins: `speed` m/s and `spin` rad/s, each per component.
inline void shake(std::vector<Slot<1>>& state, double speed, double spin, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto vector = [&](double size) {
        const double x = normal(random), y = normal(random), z = normal(random);
        return Vec3d{size * x, size * y, size * z};
    };
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].velocity, 0, lane(state[k].velocity, 0) + vector(speed));
        if (k + 1 < state.size()) set_lane(state[k].spin, 0, lane(state[k].spin, 0) + vector(spin));
    }
}

/// max |Q Q^T - 1| over elements and entries.
inline double director_defect(const std::vector<Slot<1>>& state) {
    double worst = 0;
    for (std::size_t k = 0; k + 1 < state.size(); ++k) {
        const Mat3d q = frame(state[k]);
        for (const double d : {dot(q.d1, q.d1) - 1, dot(q.d2, q.d2) - 1, dot(q.d3, q.d3) - 1, dot(q.d1, q.d2),
                               dot(q.d1, q.d3), dot(q.d2, q.d3)})
            worst = std::max(worst, std::abs(d));
    }
    return worst;
}

inline double dilatation(const RodGroup& group, const std::vector<Slot<1>>& state, std::size_t k) {
    return group.element[k].inv_rest_length *
           dot(frame(state[k]).d3, lane(state[k + 1].position, 0) - lane(state[k].position, 0));
}

/// How the energy of a rod went, relative to its start.
struct EnergyRecord {
    double drift = 0;  ///< max |E - E0|/E0
    double trend = 0;  ///< (mean of the last quarter - mean of the first)/E0
    double strain = 0; ///< max |e - 1|
};

/// Energy of every rod of the first group.
inline std::vector<double> energies(Stage& stage) {
    std::vector<double> all;
    for (std::size_t i = 0; i < static_cast<std::size_t>(stage.groups[0].count()); ++i)
        all.push_back(energy(stage.groups[0], stage.state(i)));
    return all;
}

/// The energy that an undamped, unloaded step keeps to fourth order, of every rod of the first group. With H = T + U, F
/// the forces and couples at the synchronised state and U' the change of U along the drift,
///   H~ = H - (h^2/24) U'' + (h^2/12) F.M^-1 F          (Baker-Campbell-Hausdorff for drift, kick, drift; Hairer et
///   al., ch. IX)
/// The energy itself differs from H~ by h^2 times what the modes in play make of it: as motion spreads from slow modes
/// to fast ones, H wanders at this order although nothing is lost. A trend of H~ would be a real one.
class ShadowEnergy {
public:
    explicit ShadowEnergy(const SceneSpec& scene) : kicked_(scene) {}

    std::vector<double> operator()(const Stage& stage) {
        const RodGroup& group = stage.groups[0];
        std::vector<double> shadow;
        for (std::size_t i = 0; i < static_cast<std::size_t>(group.count()); ++i) {
            auto state = stage.state(i);
            const auto elastic_at = [&](double h) {
                auto copy = state;
                synchronise(group, copy, h);
                return rod_energy(group, copy).elastic();
            };
            const double half = 0.5 * stage.plan.dt, u = rod_energy(group, state).elastic();
            shadow.push_back(energy(group, state) -
                             (elastic_at(half) + elastic_at(-half) - 2 * u) / 6); // U'' by differences over h/2
            for (Slot<1>& s : state) {
                set_lane(s.velocity, 0, Vec3d{0, 0, 0});
                set_lane(s.spin, 0, Vec3d{0, 0, 0});
            }
            kicked_.rods->import_rod(i, state);
        }
        // One step from rest: rates are h M^-1 F, their energy is (h^2/2) F.M^-1 F.
        kicked_.clock = Clock(stage.plan.dt, 0);
        kicked_.rods->advance(kicked_.clock.next(1), false);
        std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
        for (std::size_t i = 0; i < shadow.size(); ++i) {
            kicked_.rods->export_rod(i, state);
            const RodEnergy u = rod_energy(group, state);
            shadow[i] += (u.translation + u.rotation) / 6;
        }
        return shadow;
    }

private:
    Stage kicked_;
};

/// Runs to step `steps` and measures `samples` times; `measure` gives one value per rod of the first group, or several
/// in turn.
template <class Measure>
std::vector<EnergyRecord> watch(Stage& stage, std::int64_t steps, int samples, Measure&& measure) {
    const RodGroup& group = stage.groups[0];
    const std::vector<double> start = measure(stage);
    const std::size_t rods = start.size();
    std::vector<EnergyRecord> record(rods);
    std::vector<double> first(rods), last(rods);
    for (int s = 1; s <= samples; ++s) {
        advance_checked(stage, steps * s / samples);
        const std::vector<double> now = measure(stage);
        for (std::size_t i = 0; i < rods; ++i) {
            const double change = (now[i] - start[i]) / start[i];
            record[i].drift = std::max(record[i].drift, std::abs(change));
            if (4 * s <= samples) first[i] += change;
            if (4 * s > 3 * samples) last[i] += change;
            const auto state = stage.state(i % static_cast<std::size_t>(group.count()));
            for (std::size_t k = 0; k + 1 < state.size(); ++k)
                record[i].strain = std::max(record[i].strain, std::abs(dilatation(group, state, k) - 1));
        }
    }
    for (std::size_t i = 0; i < rods; ++i) record[i].trend = (last[i] - first[i]) / (samples / 4);
    return record;
}

inline std::vector<EnergyRecord> watch_energy(Stage& stage, std::int64_t steps, int samples = 2000) {
    return watch(stage, steps, samples, energies);
}

/// Energy and shadow energy of the same run.
struct EnergyRecords {
    std::vector<EnergyRecord> energy, shadow;
};
inline EnergyRecords watch_both(Stage& stage, std::int64_t steps, int samples = 2000) {
    ShadowEnergy shadow(stage.scene);
    const auto all = watch(stage, steps, samples, [&](Stage& s) {
        std::vector<double> values = energies(s);
        const std::vector<double> more = shadow(s);
        values.insert(values.end(), more.begin(), more.end());
        return values;
    });
    const auto half = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    return {{all.begin(), half}, {half, all.end()}};
}

inline EnergyRecord worst(const std::vector<EnergyRecord>& records) {
    EnergyRecord w;
    for (const EnergyRecord& r : records) {
        w.drift = std::max(w.drift, r.drift);
        w.trend = std::abs(r.trend) > std::abs(w.trend) ? r.trend : w.trend;
        w.strain = std::max(w.strain, r.strain);
    }
    return w;
}

/// Trend of the mean rod.
inline double mean_trend(const std::vector<EnergyRecord>& records) {
    double sum = 0;
    for (const EnergyRecord& r : records) sum += r.trend;
    return sum / static_cast<double>(records.size());
}

} // namespace skein::test
