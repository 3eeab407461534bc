#include "equilibrium/newton.hpp"

#include "core/timer.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace skein {

namespace {

/// Smallest shift of a stiffness by masses: above what rounding leaves of the eigenvalues of motions that nothing
/// resists, 1/s^2.
double least_shift(const Stiffness& stiffness, const Stiffness& mass) {
    constexpr double round_off = 1e-14;
    double fastest = 0;
    for (Eigen::Index u = 0; u < stiffness.rows(); ++u)
        if (const double m = mass.coeff(u, u); m > 0) fastest = std::max(fastest, std::abs(stiffness.coeff(u, u)) / m);
    return round_off * fastest;
}

} // namespace

Unknown NewtonSolver::correction(const StaticState& state, StaticSystem::Balance& balance, std::string& reason) {
    if (!balance.residual.allFinite()) {
        reason = "loads are not finite";
        return {};
    }
    solution_.factorise(state, balance);
    for (const NeutralMotions::Piece& piece : solution_.neutral().pieces) {
        const Unknown own = piece.part_of(balance.residual), along = piece.motion.transpose() * own;
        const double allowed = 1e-8 * balance.force_size * std::sqrt(static_cast<double>(own.size()));
        if (along.norm() > allowed) {
            reason =
                fmt::format("nothing balances the loads on the {}", system_.name_of(piece, along.normalized(), state));
            return {};
        }
    }
    Unknown correction = solution_.solve(balance.residual);
    if (!correction.allFinite() || !solves(state, correction, balance.residual)) {
        reason = "the stiffness is singular";
        return {};
    }
    return correction;
}

bool NewtonSolver::solves(const StaticState& state, const Unknown& correction, const Unknown& residual) const {
    if (solution_.regular()) return true;
    const Stiffness& stiffness = *system_.balance(state, true).stiffness;
    return (stiffness * correction - residual).norm() <= 1e-6 * residual.norm();
}

NewtonResult NewtonSolver::solve(StaticState& state, const Unknown& left, int most) {
    constexpr int patience = 6; // iterations without a correction half as large as all before
    NewtonResult result;
    factor_is_last_ = false;
    double last = HUGE_VAL, least = HUGE_VAL;
    int least_at = 0;
    if (most == 0) most = system_.touches() ? options_.most_touching : options_.most_iterations;
    for (int i = 0; i < most; ++i) {
        StaticSystem::Balance balance = system_.balance(state, true);
        balance.residual -= left;
        if (!is_symmetric(balance.asymmetry)) system_.leave_couples(balance, left);
        const double relative = system_.relative(balance);
        const Unknown correction = this->correction(state, balance, result.reason);
        if (correction.size() == 0) return result;
        const double size = system_.size(correction), turn = system_.turn(correction);
        const double asked = std::min(1.0, options_.most_turn / turn),
                     share = system_.clear_share(state, correction, asked);
        meets_ = meets_ || share < asked;
        system_.correct(state, correction, share);
        result.passes.push_back({relative, size});
        if (!goes_on(result, false)) return result;
        if (share < 1) {
            least_at = i;
            continue;
        }
        // The next correction would be of its square.
        if (size < options_.tolerance || (size < 1e-6 && last < 1e-3 && size >= last)) {
            result.converged = true;
            factor_is_last_ = size < options_.tolerance;
            return result;
        }
        last = size;
        if (size < 0.5 * least) {
            least = size;
            least_at = i;
        }
        if (i - least_at >= patience && least > 0.01) break; // no way leads there
    }
    result.reason = fmt::format("corrections are {:.2g} after {} iterations", result.passes.back().correction,
                                result.passes.size());
    return result;
}

double NewtonSolver::first_shift(const StaticSystem::Balance& balance, const Stiffness& mass) const {
    const double farthest = std::min(system_.first_way(), options_.most_descent * system_.length());
    double shift = 0;
    for (int u = 0; u < system_.unknowns(); ++u) {
        const double most = system_.map().place(u).i < 3 ? farthest : options_.most_descent, m = mass.coeff(u, u);
        if (m > 0) shift = std::max(shift, std::abs(balance.residual[u]) / (m * most));
    }
    return shift;
}

/// Steps of motion in a thick fluid, M (u' - u) m = r(u'), in which the energy falls and bodies without any stiffness
/// do, too. The shift m goes towards 0 as steps converge.
NewtonResult NewtonSolver::descend(StaticState& state) {
    NewtonResult result;
    factor_is_last_ = false;
    const Stiffness mass = system_.mass(state);
    double shift = 0, near = 3e-4;
    const StaticState start = state;
    const double farthest = 2 * StaticSystem::extent(state) + system_.length();
    const std::size_t most = to_index(system_.touches() ? options_.most_falls : options_.most_descents);
    for (std::size_t tries = 0; tries < most && result.passes.size() < most; ++tries) {
        const StaticState before = state;
        const Fall step = fall(state, mass, shift, result);
        if (result.converged || !result.reason.empty()) return result;
        if (step.end == Fall::failed) {
            state = before;
            shift *= 8;
            continue;
        }
        if (const long slot = system_.gone(state, start, farthest); slot >= 0) {
            result.reason = fmt::format("{} leaves, as nothing stops it",
                                        system_.rod_name(system_.map().rod_of_slot()[static_cast<std::size_t>(slot)]));
            return result;
        }
        shift *= step.end == Fall::near ? 1.5 : step.corrections <= 3 ? 0.1 : 0.3;
        if (step.size >= near) continue;
        near *= 0.5;
        if (finish(state, result) || result.stopped) return result;
    }
    result.reason = fmt::format("{} corrections downhill do not end", most);
    return result;
}

/// The stiffness of contacts is taken convex until the step is near its end, as its negative part is that of normals
/// that turn, which large corrections overrate.
NewtonSolver::Fall NewtonSolver::fall(StaticState& state, const Stiffness& mass, double& shift, NewtonResult& result) {
    constexpr int most = 8;
    constexpr double whole_below = 0.3, near_below = 0.25, balanced_below = 0.01; // of the first promise
    Fall fall;
    Unknown way = Unknown::Zero(system_.unknowns());
    double first = 0, promised = 0, last = HUGE_VAL, last_size = HUGE_VAL;
    bool may_be_whole = true;
    while (fall.corrections < most) {
        const bool whole = fall.corrections > 0 && may_be_whole && promised < whole_below * first;
        const StaticSystem::Balance balance = system_.balance(state, true, !whole);
        if (!balance.residual.allFinite()) {
            result.reason = "loads are not finite";
            return fall;
        }
        const double least = least_shift(*balance.stiffness, mass);
        shift = std::max(shift == 0 ? first_shift(balance, mass) : shift, least);
        if (!solution_.factorise(state, balance, shift * mass) || solution_.negative() > 0) {
            if (!whole) return fall;
            may_be_whole = false;
            continue;
        }
        const Unknown residual = balance.residual - shift * (mass * way), step = solution_.solve(residual);
        promised = residual.dot(step);
        if (fall.corrections++ == 0) first = promised;
        const double size = system_.size(step),
                     share =
                         system_.clear_share(state, step, std::min(1.0, options_.most_descent / system_.turn(step)));
        result.passes.push_back({system_.relative(balance), size});
        if (!goes_on(result, true)) return fall;
        const bool settles = share == 1 && shift <= least;
        judge(balance, fall.corrections == 1 && size < 1e-3 * options_.tolerance && shift > 1e6 * least,
              settles && size >= 0.5 * last_size, result);
        if (result.converged || !result.reason.empty()) return fall;
        system_.correct(state, step, share);
        way += share * step;
        fall.size = system_.size(way);
        if (settles && (size < options_.tolerance || (size < 1e-6 && last_size < 1e-3 && size >= last_size))) {
            result.converged = true;
            return fall;
        }
        last_size = settles ? size : HUGE_VAL;
        if (share < 1) continue;
        if (promised < balanced_below * first && shift > least) {
            fall.end = Fall::balanced;
            return fall;
        }
        if (fall.corrections > 4 && promised > 2 * last) break;
        last = promised;
    }
    if (promised < near_below * first) fall.end = Fall::near;
    return fall;
}

void NewtonSolver::judge(const StaticSystem::Balance& balance, bool stands, bool settles, NewtonResult& result) const {
    // Residual in balance: only motions without stiffness remain.
    if (system_.relative(balance) < 1e-10 && (stands || settles)) result.converged = true;
    else if (stands) result.reason = text_of_jump(balance);
}

bool NewtonSolver::finish(StaticState& state, NewtonResult& result) {
    StaticState trial = state;
    NewtonResult exact = solve(trial, Unknown::Zero(system_.unknowns()), options_.most_iterations);
    result.passes.insert(result.passes.end(), exact.passes.begin(), exact.passes.end());
    result.stopped = exact.stopped;
    if (exact.stopped) result.reason = exact.reason;
    result.converged = exact.converged && solution_.negative() <= 0;
    if (result.converged) state = std::move(trial);
    return result.converged;
}

std::string NewtonSolver::text_of_jump(const StaticSystem::Balance& balance) const {
    Eigen::Index worst = 0;
    balance.residual.cwiseAbs().maxCoeff(&worst);
    return fmt::format("the forces on {} jump from one side of the state to the other, as at rods that lie along each "
                       "other: {:.1g} of the acting forces is left",
                       system_.rod_name(system_.map().place(static_cast<int>(worst)).rod), system_.relative(balance));
}

bool NewtonSolver::goes_on(NewtonResult& result, bool downhill) {
    if (!options_.watch) return true;
    ++progress_.corrections;
    progress_.residual = result.passes.back().residual;
    progress_.downhill = downhill;
    progress_.factor = solution_.factor_name();
    progress_.factor_entries = solution_.factor_entries();
    const double now = wall_seconds();
    progress_.seconds = now - std::exchange(last_told_, now);
    if (options_.watch(progress_)) return true;
    result.stopped = true;
    result.reason = "the solution was stopped";
    return false;
}

double NewtonSolver::load(StaticState& state, double time, bool at_once, Equilibrium& result) {
    double done = 0, step = 1;
    StaticState good = state;
    Unknown start; // what is out of balance at time 0, where the load is raised in steps
    const auto left_beside = [&](double aim) -> Unknown {
        if (aim == 1) return Unknown::Zero(system_.unknowns());
        if (start.size() == 0) {
            system_.set_time(0);
            start = system_.balance(good, false).residual;
        }
        return (1 - aim) * start;
    };
    while (done < 1) {
        double aim = std::min(1.0, done + step);
        if (const double up_to = system_.lead_up_to(done * time, aim * time, options_.most_turn); up_to < aim * time)
            aim = up_to / time;
        const Unknown left = left_beside(aim);
        system_.set_time(aim * time);
        system_.lead_ends(state);
        progress_.share = aim;
        NewtonResult pass = solve(state, left, at_once ? options_.most_iterations : 0);
        result.stopped = pass.stopped;
        const bool stable = !options_.stable || solution_.negative() <= 0;
        if (pass.converged && (stable || step <= 1.0 / 64)) {
            result.iterations.push_back(pass.passes.size());
            result.last = std::move(pass);
            done = aim;
            if (options_.friction && system_.rubs()) system_.keep_springs(state);
            system_.keep_joints(state);
            good = state;
            step *= 2;
            continue;
        }
        state = good;
        factor_is_last_ = false;
        step = 0.5 * std::min(step, aim - done);
        if (at_once || step < options_.least_step || result.stopped) {
            result.reason = pass.converged ? "it is unstable" : pass.reason;
            break;
        }
    }
    return done;
}

Equilibrium NewtonSolver::find(StaticState& state, double time) {
    Equilibrium result;
    progress_ = {};
    last_told_ = wall_seconds();
    system_.set_time(0);
    system_.lead_ends(state);
    system_.keep_joints(state);
    if (options_.friction) system_.set_reference(state);
    // Bodies that meet come to rest sooner downhill than by load steps, each of which has its own contacts.
    const bool at_once = options_.stable && system_.touches() && !system_.rubs();
    const StaticState start = state;
    meets_ = false;
    double done = load(state, time, at_once, result);
    const bool falls = at_once && meets_;
    const auto load_in_steps = [&] {
        if (done >= 1 || !at_once || result.stopped) return;
        state = start;
        done = load(state, time, false, result);
    };
    if (!falls) load_in_steps();
    if (done < 1 && go_downhill(state, done, time, result)) {
        done = 1;
    } else if (falls) {
        const std::string reason = std::exchange(result.reason, {});
        load_in_steps();
        if (done < 1) result.reason = reason;
    }
    result.share = done;
    result.found = done >= 1;
    system_.set_time(done * time);
    if (!result.stopped) describe(result, state);
    return result;
}

bool NewtonSolver::go_downhill(StaticState& state, double done, double time, Equilibrium& result) {
    if (result.stopped || !solution_.symmetric() || !options_.stable ||
        system_.lead_up_to(done * time, time, options_.most_turn) < time)
        return false;
    const StaticState good = state;
    system_.set_time(time);
    system_.lead_ends(state);
    progress_.share = 1;
    NewtonResult pass = descend(state);
    result.stopped = pass.stopped;
    if (!pass.converged) {
        result.reason += "; " + pass.reason;
        state = good;
        return false;
    }
    result.iterations.push_back(pass.passes.size());
    result.last = std::move(pass);
    if (options_.friction && system_.rubs()) system_.keep_springs(state);
    system_.keep_joints(state);
    return true;
}

void NewtonSolver::describe(Equilibrium& result, const StaticState& state) {
    StaticState own = state;
    system_.refresh(own);
    result.factor = solution_.factor_name(); // of the iterations, where friction makes the stiffness unsymmetric
    if (factor_is_last_ && !system_.touches() && !system_.rubs() && state.joint_memory.empty()) {
        // The last correction is below the tolerance, so that the stiffness before it is that of the state.
        result.residual = system_.relative(system_.balance(own, false));
    } else {
        auto [balance, asymmetry] = system_.sticking_balance(own);
        result.asymmetry = asymmetry;
        result.residual = system_.relative(balance);
        if (balance.residual.allFinite()) solution_.factorise(own, balance);
    }
    result.negative = solution_.negative();
    if (result.asymmetry == 0) result.factor = solution_.factor_name();
    result.factor_entries = solution_.factor_entries();
    result.neutral = solution_.neutral().count();
    for (const NeutralMotions::Piece& piece : solution_.neutral().pieces)
        for (Eigen::Index m = 0; m < piece.motion.cols() && result.neutral_names.size() < 8; ++m)
            result.neutral_names.push_back(system_.name_of(piece, Unknown::Unit(piece.motion.cols(), m), own));
    if (result.negative > 0) count_signs(result, own);
}

/// Several bodies together may move without stiffness, as a ball on rails that give way: signs of these are noise.
void NewtonSolver::count_signs(Equilibrium& result, const StaticState& state) {
    const Stiffness mass = system_.mass(state);
    const StaticSystem::Balance balance = system_.sticking_balance(state).first;
    const double least = least_shift(*balance.stiffness, mass);
    const auto below = [&](double share) {
        solution_.factorise(state, balance, share * least * mass);
        return solution_.negative();
    };
    result.negative = below(1);
    result.loose = below(-1) - result.negative - result.neutral;
}

} // namespace skein
