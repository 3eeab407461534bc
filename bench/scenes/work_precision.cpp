// Error against work, over rod law, clamp, damping scheme, integrator, number of elements n and step.
//   bench_work_precision [--case NAME]... [--csv FILE]
//
//   timoshenko    thick rod under a tip force, at rest: tip against Timoshenko's line
//   beam          slender rod let go in its first mode: where it is after a quarter period, against Timoshenko's frequency
//   magnetised    rod magnetised along its axis in a field across it, at rest, bond 1: tip against its boundary-value problem
//   cilium        eight driven damped cilia in a row: tips at eight instants against each law's own finest runs
//   one_percent   timoshenko again: work until the tip is within 1 % of the line for good
//
// A configuration runs on a ladder of n, each rung twice the one before, so that Richardson values and estimates of their error
// come along. With u of order p in 1/n, of order q after one extrapolation:
//   R(n/2, n) = u_n + (u_n - u_n/2)/(2^p - 1),   its error about |R(n/2, n) - R(n/4, n/2)|/(2^q - 1)
// p = 2, q = 4; p = 1, q = 2 with frozen clamps and, in the moving cilium, with damping after the kick: its step shrinks with 1/n.
// Work counts the rods of the scene: one on one lane, or eight cilia on eight lanes. Core time is that of steps alone, best of
// repeats up to 20 ms.
#include "measure.hpp"
#include "support/magnetised_elastica.hpp"
#include "support/relaxation.hpp"
#include "support/timoshenko_beam.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <optional>

namespace {

using namespace skein;
using test::Stage;

struct Config {
    Law law = Law::incompressible;
    EndKind clamp = EndKind::clamped;
    DampingScheme damping = DampingScheme::midpoint;
    Integrator integrator = Integrator::verlet;
    double share = 0.855; ///< of the stable step; the automatic one's
};
/// What published codes do, but at the automatic step.
constexpr Config published{Law::elastica, EndKind::clamped_frozen, DampingScheme::after};

/// What a run found, in units in which errors are stated, and what it took.
struct Outcome {
    std::vector<Vec3d> value;
    double dt = 0;
    double element_steps = 0, core_seconds = 0;
    std::uint64_t digest = 0;
    DampingScheme damping = DampingScheme::midpoint; ///< as planned: laws and integrators may need another than asked for
};

/// Advances and counts.
void advance(Stage& stage, std::int64_t until, Outcome& outcome) {
    test::Cost cost;
    const double before = bench::core_seconds();
    test::advance(stage, until, cost);
    outcome.core_seconds += bench::core_seconds() - before;
    outcome.element_steps += cost.element_steps;
}

Outcome finished(const Stage& stage, Outcome outcome) {
    outcome.dt = stage.plan.dt;
    outcome.digest = stage.rods->digest();
    outcome.damping = stage.plan.groups[0].damping_scheme;
    return outcome;
}

void configure(SceneSpec& scene, const Config& config, double divide) {
    for (RodSpec& rod : scene.rods) {
        rod.material.law = config.law;
        rod.start = config.clamp;
    }
    scene.time.integrator = config.integrator;
    scene.time.damping = config.damping;
    scene.time.safety = config.share;
    scene.time.e_min = 1;
    scene.time.divide = divide;
}

// timoshenko: parameters of the published case.
constexpr test::TimoshenkoBeam thick{3, 0.25, 5000, 1e6, 1e4};
constexpr double thick_force = 0.15;

/// Twice this rate damps its slowest motion critically, nearly: the slender rod's frequency times 0.7, for shear.
double thick_frequency(const RodSpec& rod) { return 0.7 * test::cantilever_frequency(rod); }

SceneSpec timoshenko_scene(const Config& config, long n) {
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = thick.density, .youngs_modulus = thick.youngs, .shear_modulus = thick.shear};
    rod.section = {.radius = thick.radius};
    rod.shape = {.length = thick.length, .elements = n};
    SceneSpec scene = test::coming_to_rest(rod, thick_frequency(rod), {{.load = EndForce{.end = {thick_force, 0, 0}}}});
    configure(scene, config, scene.time.duration);
    return scene;
}

double deflection(const Stage& stage) {
    return lane(stage.state(0).back().position, 0).x / thick.deflection(thick_force, thick.length);
}

Outcome timoshenko(const Config& config, long n) {
    Stage stage(timoshenko_scene(config, n), 1);
    Outcome outcome;
    advance(stage, stage.plan.steps, outcome);
    outcome.value = {{deflection(stage), 0, 0}};
    return finished(stage, std::move(outcome));
}

// beam: let go in the first mode of the clamped rod, undamped. Its projection on the mode is cos(W t); after a quarter period that
// is zero and its error is the phase's, rad.
constexpr test::TimoshenkoBeam slender{1, 0.02, 1, 1, 1.0 / 3};

Outcome beam(const Config& config, long n) {
    static const double frequency = slender.frequencies<1>()[0];
    constexpr double amplitude = 1e-4;
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = slender.density, .youngs_modulus = slender.youngs};
    rod.section = {.radius = slender.radius};
    rod.shape = {.length = slender.length, .elements = n};
    SceneSpec scene;
    scene.rods = {rod};
    scene.time = {.duration = 0.5 * std::numbers::pi / frequency};
    configure(scene, config, scene.time.duration);
    Stage stage(scene, 1);
    const RodGroup& group = stage.groups[0];

    std::vector<double> w, theta;
    for (long k = 0; k <= n; ++k) w.push_back(slender.shape(frequency, static_cast<double>(k) / static_cast<double>(n))[0]);
    for (long k = 0; k < n; ++k)
        theta.push_back(slender.shape(frequency, (static_cast<double>(k) + 0.5) / static_cast<double>(n))[1]);
    if (config.clamp == EndKind::clamped_frozen) theta[0] = 0; // frozen means upright
    auto state = stage.state(0);
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].position, 0, lane(state[k].position, 0) + Vec3d{amplitude * w[k], 0, 0});
        if (k + 1 < state.size())
            set_lane(state[k].director, 0, rotation({0, amplitude * theta[k], 0}) * lane(state[k].director, 0));
    }
    stage.rods->import_rod(0, state);
    const auto projection = [&] {
        const auto now = stage.state(0);
        double sum = 0;
        for (std::size_t k = 0; k < now.size(); ++k) {
            sum += group.node_mass[k] * w[k] * lane(now[k].position, 0).x;
            if (k + 1 < now.size()) sum += group.element[k].inertia.y * theta[k] * std::asin(frame(now[k]).d3.x);
        }
        return sum;
    };
    const double start = projection();
    Outcome outcome;
    advance(stage, stage.plan.steps, outcome);
    outcome.value = {{projection() / start, 0, 0}};
    return finished(stage, std::move(outcome));
}

// magnetised: bond 1.
constexpr double magnetised_slenderness = 0.01;

Vec3d magnetised_exact(Law law) {
    const auto tip = test::magnetised_tip(1, law == Law::incompressible ? magnetised_slenderness : 0);
    const double scale = std::hypot(tip.x, 1 - tip.z);
    return {tip.x / scale, 0, tip.z / scale};
}

Outcome magnetised(const Config& config, long n) {
    constexpr double field = 0.08, youngs = 1e6;
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = 1e3, .youngs_modulus = youngs};
    rod.section = {.radius = magnetised_slenderness};
    rod.shape = {.length = 1, .elements = n};
    rod.magnetisation = {.pattern = MagnetisationPattern::uniform,
                         .strength = youngs * magnetised_slenderness * magnetised_slenderness / (4 * field)};
    const double omega = test::cantilever_frequency(rod);
    SceneSpec scene = test::coming_to_rest(rod, omega, {{.load = MagneticField{.constant = {field, 0, 0}, .ramp = 1 / omega}}});
    configure(scene, config, scene.time.duration);
    Stage stage(scene, 1);
    Outcome outcome;
    advance(stage, stage.plan.steps, outcome);
    const auto tip = test::magnetised_tip(1, config.law == Law::incompressible ? magnetised_slenderness : 0);
    outcome.value = {(1 / std::hypot(tip.x, 1 - tip.z)) * lane(stage.state(0).back().position, 0)};
    return finished(stage, std::move(outcome));
}

// cilium: a row of eight, bond 1, second half of the field's first turn.
Outcome cilium(const Config& config, long n) {
    constexpr double begin = 36, interval = 4.5;
    SceneSpec scene = test::cilia_scene(8, n);
    scene.rods[0].magnetisation.strength = 5781.25;
    std::get<MagneticField>(scene.loads[0].load).ramp = 9;
    scene.time = {.duration = begin + 8 * interval};
    configure(scene, config, interval);
    Stage stage(scene, 8);
    Outcome outcome;
    for (int instant = 1; instant <= 8; ++instant) {
        advance(stage, std::llround((begin + instant * interval) / stage.plan.dt), outcome);
        for (std::size_t i = 0; i < 8; ++i)
            outcome.value.push_back((1 / scene.rods[0].shape.length) * lane(stage.state(i).back().position, 0));
    }
    return finished(stage, std::move(outcome));
}

double distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, norm(a[i] - b[i]));
    return most;
}

/// From u of order `order` in 1/n at n and 2n.
std::vector<Vec3d> richardson(const std::vector<Vec3d>& coarse, const std::vector<Vec3d>& fine, int order) {
    std::vector<Vec3d> value;
    for (std::size_t i = 0; i < fine.size(); ++i) value.push_back(fine[i] + 1 / (std::exp2(order) - 1) * (fine[i] - coarse[i]));
    return value;
}

/// The law's own finest runs, n = 32, 64 and 128 at a quarter of the automatic step, extrapolated twice.
std::vector<Vec3d> cilium_reference(Law law) {
    const Config fine{.law = law, .share = 0.855 / 4};
    const int order = law == Law::elastica ? 1 : 2; // its damping comes after the kick
    const auto coarse = cilium(fine, 32).value, middle = cilium(fine, 64).value, finest = cilium(fine, 128).value;
    return richardson(richardson(coarse, middle, order), richardson(middle, finest, order), 2 * order);
}

std::string_view name_of(Law law) { return law_names[static_cast<std::size_t>(law)]; }
std::string_view name_of(EndKind clamp) { return end_names[static_cast<std::size_t>(clamp)]; }
std::string_view name_of(DampingScheme damping) { return damping_scheme_names[static_cast<std::size_t>(damping)]; }
std::string_view name_of(Integrator integrator) { return integrator_names[static_cast<std::size_t>(integrator)]; }

/// Rows on the screen and, if a path is given, as CSV. Cells without a value stay empty.
class Table {
public:
    explicit Table(const std::string& path) : machine_(bench::processor()) {
        if (!path.empty()) {
            file_.emplace(fmt::output_file(path));
            file_->print("case,law,clamp,damping,integrator,n,dt,error,richardson_error,richardson_error_estimate,element_steps,"
                         "core_seconds,"
                         "digest,machine\n");
        }
    }
    void add(const std::string& name, bool damped, const Config& c, long n, const Outcome& o, double error,
             double extrapolated = nan, double estimate = nan) {
        const std::string_view damping = damped ? name_of(o.damping) : "none";
        fmt::print("{:<12} {:<14} {:<14} {:<11} {:<7} n {:>3}  dt {:.3e}  error {:.2e}  Richardson {:>8} ({:>8})  {:.3e} "
                   "element-steps  {:.2e} s\n",
                   name, name_of(c.law), name_of(c.clamp), damping, name_of(c.integrator), n, o.dt, error, cell(extrapolated),
                   cell(estimate), o.element_steps, o.core_seconds);
        if (file_)
            file_->print("{},{},{},{},{},{},{:.9g},{:.4g},{},{},{:.9g},{:.4g},{:016x},\"{}\"\n", name, name_of(c.law),
                         name_of(c.clamp), damping, name_of(c.integrator), n, o.dt, error, cell(extrapolated), cell(estimate),
                         o.element_steps, o.core_seconds, o.digest, machine_);
    }

private:
    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    static std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{:.2e}", value); }

    std::string machine_;
    std::optional<fmt::ostream> file_;
};

struct Case {
    std::string name;
    bool damped, moving;
    std::vector<long> ladder; ///< each twice the one before
    std::function<Outcome(const Config&, long n)> run;
    std::function<std::vector<Vec3d>(Law)> exact;
    std::vector<Config> configs;
};

/// The same work again while it takes little: the least core time of up to twenty runs.
Outcome repeated(const Case& c, const Config& config, long n) {
    Outcome outcome = c.run(config, n);
    for (double spent = outcome.core_seconds; spent < 0.02;) {
        const double again = c.run(config, n).core_seconds;
        outcome.core_seconds = std::min(outcome.core_seconds, again);
        spent += std::max(again, 0.001);
    }
    return outcome;
}

void climb(const Case& c, Table& table) {
    std::map<Law, std::vector<Vec3d>> exact;
    for (const Config& config : c.configs) {
        if (!exact.contains(config.law)) exact[config.law] = c.exact(config.law);
        const std::vector<Vec3d>& truth = exact[config.law];
        std::vector<std::vector<Vec3d>> value, extrapolated;
        for (const long n : c.ladder) {
            const Outcome outcome = repeated(c, config, n);
            double error = std::nan(""), estimate = std::nan("");
            const bool first_order =
                config.clamp == EndKind::clamped_frozen || (c.damped && c.moving && outcome.damping == DampingScheme::after);
            const int order = first_order ? 1 : 2;
            if (!value.empty()) {
                extrapolated.push_back(richardson(value.back(), outcome.value, order));
                error = distance(extrapolated.back(), truth);
                if (extrapolated.size() > 1)
                    estimate = distance(extrapolated.back(), extrapolated[extrapolated.size() - 2]) / (std::exp2(2 * order) - 1);
            }
            value.push_back(outcome.value);
            table.add(c.name, c.damped, config, n, outcome, distance(outcome.value, truth), error, estimate);
        }
    }
}

/// Work until the tip is within 1 % of the line and stays there; nothing where it never is.
std::optional<Outcome> to_one_percent(const Config& config, long n, double dt) {
    SceneSpec scene = timoshenko_scene(config, n);
    scene.time.dt = dt;
    Stage stage(scene, 1);
    Outcome outcome, reached;
    const std::int64_t look = std::max<std::int64_t>(1, stage.plan.steps / 1000);
    bool within = false;
    for (std::int64_t step = look; step <= stage.plan.steps; step += look) {
        advance(stage, step, outcome);
        const double error = std::abs(deflection(stage) - 1);
        if (error <= 0.01 && !within) {
            reached = finished(stage, outcome);
            reached.value = {{deflection(stage), 0, 0}};
        }
        within = error <= 0.01;
    }
    if (!within) return {};
    return reached;
}

/// Least element-steps over n, for Skein's default and towards what published codes do, one choice at a time.
void one_percent(Table& table) {
    struct Way {
        std::string name;
        Config config;
        double step_over_length; ///< dt over the element length, s/m; 0: automatic
        double least = std::numeric_limits<double>::infinity();
        long n = 0;
        double steps = 0;
    };
    Config frozen;
    frozen.clamp = EndKind::clamped_frozen;
    std::vector<Way> ways{{"default", {}, 0},
                          {"frozen clamp", frozen, 0},
                          {"published, automatic step", published, 0},
                          {"published, step 0.01 s/m l", published, 0.01}};
    for (Way& way : ways) {
        for (const long n : {4, 5, 6, 7, 8, 10, 12, 16, 20, 40, 60, 80, 90, 95, 100, 105, 110, 120, 140}) {
            if (way.config.clamp == EndKind::clamped && n > 20) continue; // long since within
            const auto reached = to_one_percent(way.config, n, way.step_over_length * thick.length / static_cast<double>(n));
            if (!reached) continue;
            table.add("one_percent", true, way.config, n, *reached, std::abs(reached->value[0].x - 1));
            if (reached->element_steps < way.least) {
                way.least = reached->element_steps;
                way.n = n;
                way.steps = reached->element_steps / static_cast<double>(n);
            }
        }
    }
    fmt::print("\nwork to 1 % of the tip's deflection, best n\n");
    for (const Way& way : ways)
        fmt::print("{:<32} n {:>3}, {:>6.0f} steps, {:.3e} element-steps, {:>6.1f} times the default's\n", way.name, way.n,
                   way.steps, way.least, way.least / ways[0].least);
    fmt::print("\n");
}

/// The default, one choice changed at a time, and the published configuration.
std::vector<Config> one_at_a_time(bool damped, bool moving) {
    const Config base;
    std::vector<Config> all{base};
    const auto with = [&](auto member, auto value) {
        Config changed = base;
        changed.*member = value;
        all.push_back(changed);
    };
    with(&Config::law, Law::linear);
    with(&Config::law, Law::elastica);
    with(&Config::clamp, EndKind::clamped_frozen);
    if (damped) {
        with(&Config::damping, DampingScheme::exponential);
        with(&Config::damping, DampingScheme::after);
    }
    with(&Config::integrator, Integrator::pefrl);
    with(&Config::share, base.share / 2);
    if (moving) with(&Config::share, base.share / 4); // what is at rest does not know the step
    all.push_back(published);
    return all;
}

} // namespace

int main(int argc, char** argv) {
    std::vector<std::string> chosen;
    std::string csv;
    CLI::App app{"Error against work over law, clamp, damping, integrator, n and dt"};
    app.add_option("--case", chosen, "cases to run; all where absent")
        ->check(CLI::IsMember({"timoshenko", "beam", "magnetised", "cilium", "one_percent"}));
    app.add_option("--csv", csv, "file for the table");
    CLI11_PARSE(app, argc, argv);
    const auto wanted = [&](const std::string& name) {
        return chosen.empty() || std::find(chosen.begin(), chosen.end(), name) != chosen.end();
    };

    const auto fixed = [](Vec3d value) { return [value](Law) { return std::vector<Vec3d>{value}; }; };
    const Case cases[] = {
        {"timoshenko", true, false, {5, 10, 20, 40, 80}, timoshenko, fixed({1, 0, 0}), one_at_a_time(true, false)},
        {"beam", false, true, {5, 10, 20, 40, 80}, beam, fixed({0, 0, 0}), one_at_a_time(false, true)},
        {"magnetised",
         true,
         false,
         {5, 10, 20, 40},
         magnetised,
         [](Law law) { return std::vector<Vec3d>{magnetised_exact(law)}; },
         one_at_a_time(true, false)},
        {"cilium", true, true, {4, 8, 16, 32}, cilium, cilium_reference, one_at_a_time(true, true)},
    };
    Table table(csv);
    for (const Case& c : cases)
        if (wanted(c.name)) climb(c, table);
    if (wanted("one_percent")) one_percent(table);
}
