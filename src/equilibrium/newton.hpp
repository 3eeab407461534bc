// Equilibria by Newton's method, with steps of the load where it does not converge at once.         theory.md
// (98)-(100)
//   loads(u, t) - (1 - s) g = 0,  g = loads(u0, 0),  t = s T      s from 0, where the start is balanced by g, to 1
#pragma once

#include "equilibrium/static_solution.hpp"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// How far a solution is, after a correction.
struct NewtonProgress {
    double share = 0;    ///< of the load that is being balanced
    int corrections = 0; ///< of all load steps
    double residual = 0; ///< relative, before the correction
    bool downhill = false;
    double seconds = 0; ///< what the correction took
    std::string_view factor;
    double factor_entries = 0; ///< see Factor::entries()
};

struct NewtonOptions {
    double tolerance = 1e-11; ///< of a correction: displacement over length, or turn
    int most_iterations = 16;
    int most_touching = 100;       ///< of bodies that touch, which must not pass through each other
    double most_turn = 1.5;        ///< rad of an element in a correction, and of an end in a load step
    double least_step = 1.0 / 256; ///< of the load
    int most_descents = 300;       ///< corrections downhill
    int most_falls = 20000;        ///< of bodies that touch
    double most_descent = 0.3;     ///< rad of an element in one of them
    bool friction = false;         ///< with memory acts, from springs that load steps hand on
    bool stable = true;            ///< steps that end in an unstable equilibrium are made shorter
    std::function<bool(const NewtonProgress&)> watch; ///< called after each correction; false ends the solution
};

/// Record of an iteration.
struct NewtonPass {
    double residual;   ///< relative, before it
    double correction; ///< its size
};

struct NewtonResult {
    bool converged = false;
    bool stopped = false; ///< by the watch
    std::vector<NewtonPass> passes;
    std::string reason; ///< why it did not converge
};

/// Result of a whole solution.
struct Equilibrium {
    bool found = false;
    bool stopped = false;                ///< by the watch of the options
    double share = 0;                    ///< of the load that is balanced
    std::vector<std::size_t> iterations; ///< by step of the load
    NewtonResult last;
    double residual = 0;      ///< relative, at the end
    long negative = 0;        ///< directions in which the energy falls; -1: not known
    double asymmetry = 0;     ///< of the stiffness where friction sticks, whose symmetric part counts
    Eigen::Index neutral = 0; ///< motions that change no load, of a piece or of a body by itself
    Eigen::Index loose = 0;   ///< further ones, of several bodies, to rounding
    std::vector<std::string> neutral_names;
    std::string factor;
    double factor_entries = 0;
    std::string reason; ///< why none was found
};

class NewtonSolver {
public:
    NewtonSolver(StaticSystem& system, const NewtonOptions& options)
        : system_(system), options_(options), solution_(system) {}

    /// Solves from `state` at the present time, for `left` beside the loads; the state is changed either way.
    /// `most`: iterations; 0: those of the options.
    NewtonResult solve(StaticState& state, const Unknown& left, int most = 0);
    /// Goes from the state, as it is at time 0, to an equilibrium at `time`.
    Equilibrium find(StaticState& state, double time);

private:
    /// Correction for a residual; empty where something is wrong, with the reason.
    Unknown correction(const StaticState& state, StaticSystem::Balance& balance, std::string& reason);
    /// True where a correction does what it should: with a stiffness that is singular it may not.
    bool solves(const StaticState& state, const Unknown& correction, const Unknown& residual) const;
    /// Raises the load from 0 as far as an equilibrium follows; leaves the last state. Returns the share.
    /// `at_once`: in one step of few iterations, or not at all.
    double load(StaticState& state, double time, bool at_once, Equilibrium& result);
    /// Goes to a minimum of the energy.
    NewtonResult descend(StaticState& state);
    /// Step of motion in a thick fluid, M (u' - u) shift = loads(u'), by Newton's method; see descend().
    struct Fall {
        enum End { failed, near, balanced } end = failed;
        int corrections = 0;
        double size = 0; ///< of its way, as of a correction
    };
    Fall fall(StaticState& state, const Stiffness& mass, double& shift, NewtonResult& result);
    /// Ends the solution if a correction with a shift shows the balance, or that there is none.
    void judge(const StaticSystem::Balance& balance, bool stands, bool settles, NewtonResult& result) const;
    /// Tries the stiffness without a shift; true where it leads to a stable equilibrium.
    bool finish(StaticState& state, NewtonResult& result);
    /// Puts a solution that goes downhill into the result; true where it is one.
    bool go_downhill(StaticState& state, double done, double time, Equilibrium& result);
    /// Tells how far the solution is; false where it is to end.
    bool goes_on(NewtonResult& result, bool downhill);
    /// Shift m by which no unknown goes beyond what it may in a correction of m M du = r.
    double first_shift(const StaticSystem::Balance& balance, const Stiffness& mass) const;
    std::string text_of_jump(const StaticSystem::Balance& balance) const;
    void describe(Equilibrium& result, const StaticState& state);
    void count_signs(Equilibrium& result, const StaticState& state);

    StaticSystem& system_;
    NewtonOptions options_;
    StaticSolution solution_; ///< of the last correction
    /// That is the factor of the stiffness where the solution ended, to the tolerance.
    bool factor_is_last_ = false;
    bool meets_ = false; ///< a correction was cut where bodies meet
    NewtonProgress progress_;
    double last_told_ = 0; ///< wall time, s
};

} // namespace skein
