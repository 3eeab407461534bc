// What the study of error against work is made of: configurations, runs, cases with known answers, and the ladders they
// climb.
//
// A configuration runs on a ladder of rungs, each with twice the elements or half the step of the one before, so that
// Richardson values and estimates of their error come along. With u of order p, and of order q after one extrapolation:
//   R(n/2, n) = u_n + (u_n - u_n/2)/(2^p - 1),   its error about |R(n/2, n) - R(n/4, n/2)|/(2^q - 1)
// p = 2, q = 4; p = 1, q = 2 with frozen clamps and where the step shrinks with the elements and is of first order.
#pragma once

#include "support/relaxation.hpp"

#include <fmt/os.h>

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace skein::bench {

struct Config {
    std::string name = "default";
    Law law = Law::incompressible;
    EndKind clamp = EndKind::clamped;
    DampingScheme damping = DampingScheme::midpoint;
    Integrator integrator = Integrator::verlet;
    double step = 1; ///< over the automatic one
    EndWeights weights = EndWeights::plain;
};

/// What is there to be chosen in a case, besides the law.
struct Choices {
    bool clamp = false, damping = false;
    bool integrator = false, step = false; ///< what is at rest knows neither
};

struct Rung {
    long n;
    double step = 1; ///< over the configuration's
};

/// What a run found, in units in which errors are stated, and what it took. Core time is that of steps alone.
struct Outcome {
    std::vector<Vec3d> value;
    double dt = 0;
    test::Cost cost;
    std::uint64_t digest = 0;
    DampingScheme damping =
        DampingScheme::midpoint; ///< as planned: laws and integrators may need another than asked for
};

struct Case {
    std::string name;
    Choices choices;
    std::vector<Rung> ladder;
    std::function<Outcome(const Config&, const Rung&)> run;
    std::function<std::vector<Vec3d>(Law)> exact;
    std::vector<Config> configs;
    std::function<int(const Config&, DampingScheme planned)> order; ///< p
    int next_order = 4;                                             ///< q where p = 2
    bool extrapolates = true; ///< no Richardson value of what is a largest deviation
};

/// The default, one choice changed at a time, and last what published codes do, but at the automatic step: `elastica`,
/// `clamped_frozen`, damping after the kick; without a clamp that is `elastica`, which always damps so.
std::vector<Config> one_at_a_time(const Choices& choices);

/// A case over n whose order is lowered by frozen clamps, and by damping after the kick in motion.
Case over_elements(std::string name, const Choices& choices, const std::vector<long>& ladder,
                   std::function<Outcome(const Config&, const Rung&)> run,
                   std::function<std::vector<Vec3d>(Law)> exact);

/// The scene as a configuration wants it: its law and its clamp where the scene has clamps, at the automatic step (0.9
/// x 0.95 of the limit, 0.6 without damping) times its own and the rung's, so that whole steps fill `interval` (s).
void configure(SceneSpec& scene, const Config& config, const Rung& rung, double interval);

/// Adds what the end of a run tells.
Outcome finished(const test::Stage& stage, Outcome outcome);

/// Largest distance of two points; infinity where a rod is lost.
double distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b);

/// From u of order `order` on two rungs.
std::vector<Vec3d> richardson(const std::vector<Vec3d>& coarse, const std::vector<Vec3d>& fine, int order);

/// Rows on the screen and, if a path is given, as CSV. Cells without a value stay empty.
class Table {
public:
    explicit Table(const std::string& path);
    void add(const std::string& name, const Choices& choices, const Config& config, long n, const Outcome& outcome,
             double error, double extrapolated = std::numeric_limits<double>::quiet_NaN(),
             double estimate = std::numeric_limits<double>::quiet_NaN());

private:
    std::string machine_;
    std::optional<fmt::ostream> file_;
};

/// All configurations of a case on all its rungs.
void climb(const Case& c, Table& table);

} // namespace skein::bench
