// Figures of a finished run: summary.json for programs, a timing table for people.
#pragma once

#include "neighbourhood/neighbourhood.hpp"
#include "physics/fluid/fluid_interaction.hpp"
#include "plan/plan.hpp"
#include "simulation/simulation.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Seconds of one phase over the ranks.
struct PhaseTime {
    double min, mean, max;
};

/// End of a run as the run knows it.
struct RunEnd {
    bool finished;           ///< the scene, not only this run
    std::int64_t first_step; ///< of this run; > 0 after a restart
    double wall_s;
    std::vector<std::string> names;      ///< of observables
    std::span<const double> observables; ///< at the end
    const SceneTexts& texts;
};

struct RunFigures {
    const Plan& plan;
    RunResult result;
    RunEnd end;
    double time_s;
    Protocol protocol;
    std::vector<PhaseTime> phases;             ///< by Phase
    std::int64_t rod_bytes = 0;                ///< state and scratch, all ranks
    std::int64_t resident_bytes = 0;           ///< resident set, all ranks
    std::vector<LargestOverlap> overlaps = {}; ///< of contacts and walls, in this run
    std::vector<GhostFigures> ghosts = {};     ///< by rank, at the end; none where ranks do not meet
    std::vector<WaitFigures> waits = {};       ///< by rank; none where ranks do not meet
    BalanceFigures balance = {};
    double cell_steps = 0;                                   ///< of the fluid: cells times steps, in this run
    double speed_to_expect = 0;                              ///< see FluidInteraction
    std::optional<FluidInteraction::SlipFigures> slips = {}; ///< absent without two-way rods, or if steps ignore slips
    std::string slip_warning = {};
    std::string interactions = {}; ///< JSON, their parts of the summary
};
/// Collective.
RunFigures figures_of(const World& world, const RunResult& result, RunEnd end);

std::string summary_json(const RunFigures& figures);

/// Content of an earlier run's summary.
struct EarlierSummary {
    bool ended = false;  ///< it tells of this digest as the end of a run
    std::string changes; ///< of [output] since, a line each: "  /output/series: was 0.1, now 0.2"
};
EarlierSummary read_summary(const std::string& path, std::uint64_t digest, const std::string& output);
/// A scene's [output] as JSON.
std::string output_json(const SceneSpec& scene);

std::string timing_table(const RunFigures& figures);

/// Resident set of this process, bytes; 0 where the system does not tell.
std::int64_t resident_bytes();

/// The digest as it is printed everywhere: 16 hexadecimal digits.
std::string digest_text(std::uint64_t digest);

} // namespace skein
