#include "scenes/work_precision/study.hpp"

#include "measure.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace skein::bench {

namespace {

std::string_view name_of(Law law) { return nth(law_names, law); }
std::string_view name_of(EndKind clamp) { return nth(end_names, clamp); }
std::string_view name_of(DampingScheme damping) { return nth(damping_scheme_names, damping); }
std::string_view name_of(Integrator integrator) { return nth(integrator_names, integrator); }

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{:.2e}", value) : ""; }

/// The same work again while it takes little: the least core time of up to twenty runs.
Outcome repeated(const Case& c, const Config& config, const Rung& rung) {
    Outcome outcome = c.run(config, rung);
    for (double spent = outcome.cost.seconds; spent < 0.02;) {
        const double again = c.run(config, rung).cost.seconds;
        outcome.cost.seconds = std::min(outcome.cost.seconds, again);
        spent += std::max(again, 0.001);
    }
    return outcome;
}

} // namespace

std::vector<Config> one_at_a_time(const Choices& choices) {
    std::vector<Config> all{{}};
    const auto with = [&](const std::string& name, auto member, auto value) {
        Config changed;
        changed.name = name;
        changed.*member = value;
        all.push_back(changed);
    };
    with("linear", &Config::law, Law::linear);
    if (choices.clamp) with("elastica", &Config::law, Law::elastica);
    if (choices.clamp) with("clamped_frozen", &Config::clamp, EndKind::clamped_frozen);
    if (choices.clamp) with("end_weights", &Config::weights, EndWeights::gregory);
    if (choices.damping) {
        with("exponential", &Config::damping, DampingScheme::exponential);
        with("after", &Config::damping, DampingScheme::after);
    }
    if (choices.integrator) with("pefrl", &Config::integrator, Integrator::pefrl);
    if (choices.step) {
        with("dt/2", &Config::step, 0.5);
        with("dt/4", &Config::step, 0.25);
    }
    all.push_back({"published", Law::elastica, EndKind::clamped_frozen, DampingScheme::after});
    return all;
}

Case over_elements(std::string name, const Choices& choices, const std::vector<long>& ladder,
                   std::function<Outcome(const Config&, const Rung&)> run,
                   std::function<std::vector<Vec3d>(Law)> exact) {
    Case c{std::move(name), choices, {}, std::move(run), std::move(exact), one_at_a_time(choices), {}};
    for (const long n : ladder) c.ladder.push_back({n});
    c.order = [choices](const Config& config, DampingScheme planned) {
        const bool frozen = choices.clamp && config.clamp == EndKind::clamped_frozen;
        return frozen || (choices.damping && choices.step && planned == DampingScheme::after) ? 1 : 2;
    };
    return c;
}

void configure(SceneSpec& scene, const Config& config, const Rung& rung, double interval) {
    for (RodSpec& rod : scene.rods) {
        rod.material.law = config.law;
        rod.shape.end_weights = config.weights;
        for (EndKind* end : {&rod.start, &rod.end})
            if (*end == EndKind::clamped) *end = config.clamp;
    }
    scene.time.integrator = config.integrator;
    scene.time.damping = config.damping;
    // Rods without damping get 0.6 at most, so that a half must start there.
    scene.time.safety = (scene.damping.empty() ? 0.6 : 0.9 * 0.95) * config.step * rung.step;
    scene.time.e_min = 1;
    scene.time.divide = interval;
}

Outcome finished(const test::Stage& stage, Outcome outcome) {
    outcome.dt = stage.plan.dt;
    outcome.digest = stage.rods->digest();
    outcome.damping = stage.plan.groups[0].damping_scheme;
    return outcome;
}

double distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double apart = norm(a[i] - b[i]);
        if (!std::isfinite(apart)) return std::numeric_limits<double>::infinity();
        most = std::max(most, apart);
    }
    return most;
}

std::vector<Vec3d> richardson(const std::vector<Vec3d>& coarse, const std::vector<Vec3d>& fine, int order) {
    std::vector<Vec3d> value;
    for (std::size_t i = 0; i < fine.size(); ++i)
        value.push_back(fine[i] + 1 / (std::exp2(order) - 1) * (fine[i] - coarse[i]));
    return value;
}

Table::Table(const std::string& path) : machine_(processor()) {
    if (path.empty()) return;
    file_.emplace(fmt::output_file(path));
    file_->print("case,configuration,law,clamp,damping,integrator,n,dt,error,richardson_error,richardson_error_"
                 "estimate,element_steps,"
                 "core_seconds,digest,machine\n");
}

void Table::add(const std::string& name, const Choices& choices, const Config& c, long n, const Outcome& o,
                double error, double extrapolated, double estimate) {
    const std::string_view clamp = choices.clamp ? name_of(c.clamp) : "none",
                           damping = choices.damping ? name_of(o.damping) : "none";
    fmt::print(
        "{:<20} {:<15} n {:>3}  dt {:.3e}  error {:.2e}  Richardson {:>8} ({:>8})  {:.3e} element-steps  {:.2e} s\n",
        name, c.name, n, o.dt, error, cell(extrapolated), cell(estimate), o.cost.element_steps, o.cost.seconds);
    if (file_)
        file_->print("{},{},{},{},{},{},{},{:.9g},{:.4g},{},{},{:.9g},{:.4g},{:016x},\"{}\"\n", name, c.name,
                     name_of(c.law), clamp, damping, name_of(c.integrator), n, o.dt, error, cell(extrapolated),
                     cell(estimate), o.cost.element_steps, o.cost.seconds, o.digest, machine_);
}

void climb(const Case& c, Table& table) {
    std::map<Law, std::vector<Vec3d>> exact;
    for (const Config& config : c.configs) {
        if (!exact.contains(config.law)) exact[config.law] = c.exact(config.law);
        const std::vector<Vec3d>& truth = exact[config.law];
        std::vector<std::vector<Vec3d>> value, extrapolated;
        for (const Rung& rung : c.ladder) {
            const Outcome outcome = repeated(c, config, rung);
            double error = std::nan(""), estimate = std::nan("");
            if (!value.empty() && c.extrapolates) {
                const int order = c.order(config, outcome.damping);
                extrapolated.push_back(richardson(value.back(), outcome.value, order));
                error = distance(extrapolated.back(), truth);
                if (extrapolated.size() > 1)
                    estimate = distance(extrapolated.back(), extrapolated[extrapolated.size() - 2]) /
                               (std::exp2(order == 1 ? 2 : c.next_order) - 1);
            }
            value.push_back(outcome.value);
            table.add(c.name, c.choices, config, rung.n, outcome, distance(outcome.value, truth), error, estimate);
        }
    }
}

} // namespace skein::bench
