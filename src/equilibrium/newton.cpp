#include "equilibrium/newton.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Share of the diagonal below which a shift is left out.
constexpr double least_shift = 1e-13;

} // namespace

Unknown NewtonSolver::correction(const StaticState& state, StaticSystem::Balance& balance, double shift,
                                 std::string& reason) {
    if (!balance.residual.allFinite()) {
        reason = "loads are not finite";
        return {};
    }
    solution_.factorise(state, balance, shift);
    for (const NeutralMotions::Piece& piece : solution_.neutral().pieces) {
        Unknown own(piece.motion.rows());
        for (Eigen::Index r = 0; r < own.size(); ++r)
            own[r] = balance.residual[piece.unknowns[static_cast<std::size_t>(r)]];
        const Unknown along = piece.motion.transpose() * own;
        const double allowed = 1e-8 * balance.force_size * std::sqrt(static_cast<double>(own.size()));
        if (along.norm() > allowed) {
            reason =
                fmt::format("nothing balances the loads on the {}", system_.name_of(piece, along.normalized(), state));
            return {};
        }
    }
    Unknown correction = solution_.solve(balance.residual);
    if (!correction.allFinite()) {
        reason = "the stiffness is singular";
        return {};
    }
    return correction;
}

NewtonResult NewtonSolver::solve(StaticState& state, const Unknown& left) {
    constexpr int patience = 6; // iterations without a correction half as large as all before
    NewtonResult result;
    double last = HUGE_VAL, least = HUGE_VAL;
    int least_at = 0;
    const int most = system_.touches() ? options_.most_touching : options_.most_iterations;
    for (int i = 0; i < most; ++i) {
        StaticSystem::Balance balance = system_.balance(state, true);
        balance.residual -= left;
        const double relative = system_.relative(balance);
        const Unknown correction = this->correction(state, balance, 0, result.reason);
        if (correction.size() == 0) return result;
        const double size = system_.size(correction), turn = system_.turn(correction);
        const double share =
            std::min({1.0, options_.most_turn / turn, system_.farthest_way() / system_.way(correction)});
        system_.correct(state, correction, share);
        result.passes.push_back({relative, size});
        if (share < 1) {
            least_at = i;
            continue;
        }
        // The next correction would be of its square.
        if (size < options_.tolerance || (size < 1e-6 && last < 1e-3 && size >= last)) {
            result.converged = true;
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

/// A correction of (K + m diag K) du = r goes downhill where that matrix is positive, and no further than m allows.
NewtonResult NewtonSolver::descend(StaticState& state, const Unknown& left) {
    NewtonResult result;
    double shift = 1, last = HUGE_VAL;
    for (int i = 0; i < options_.most_descents; ++i) {
        StaticSystem::Balance balance = system_.balance(state, true);
        balance.residual -= left;
        const double relative = system_.relative(balance);
        Unknown correction = this->correction(state, balance, shift, result.reason);
        if (correction.size() == 0) return result;
        if (solution_.negative() > 0) {
            shift = shift > 0 ? 4 * shift : least_shift;
            continue;
        }
        const double size = system_.size(correction), turn = system_.turn(correction);
        const double share =
            std::min({1.0, options_.most_descent / turn, system_.farthest_way() / system_.way(correction)});
        system_.correct(state, correction, share);
        result.passes.push_back({relative, size});
        if (share == 1 && turn < 0.5 * options_.most_descent) shift = shift > least_shift ? 0.3 * shift : 0;
        if (share < 0.5) shift *= 2;
        if (share < 1 || shift > 0) continue;
        if (size < options_.tolerance || (size < 1e-6 && last < 1e-3 && size >= last)) {
            result.converged = true;
            return result;
        }
        last = size;
    }
    result.reason = fmt::format("{} corrections downhill do not end", options_.most_descents);
    return result;
}

Equilibrium NewtonSolver::find(StaticState& state, double time) {
    Equilibrium result;
    system_.set_time(0);
    system_.lead_ends(state);
    if (options_.friction) system_.set_reference(state);
    const Unknown start = system_.balance(state, false).residual;
    double done = 0, step = 1;
    StaticState good = state;
    while (done < 1) {
        double aim = std::min(1.0, done + step);
        if (const double up_to = system_.lead_up_to(done * time, aim * time, options_.most_turn); up_to < aim * time)
            aim = up_to / time;
        system_.set_time(aim * time);
        system_.lead_ends(state);
        NewtonResult pass = solve(state, (1 - aim) * start);
        const bool stable = !options_.stable || solution_.negative() <= 0;
        if (pass.converged && (stable || step <= 1.0 / 64)) {
            result.iterations.push_back(pass.passes.size());
            result.last = std::move(pass);
            done = aim;
            if (options_.friction) system_.keep_springs(state);
            good = state;
            step *= 2;
            continue;
        }
        state = good;
        step = 0.5 * std::min(step, aim - done);
        if (step < options_.least_step) {
            result.reason = pass.converged ? "it is unstable" : pass.reason;
            break;
        }
    }
    if (done < 1 && solution_.symmetric() && options_.stable &&
        system_.lead_up_to(done * time, time, options_.most_turn) >= time) {
        system_.set_time(time);
        system_.lead_ends(state);
        NewtonResult pass = descend(state, Unknown::Zero(system_.unknowns()));
        if (pass.converged) {
            done = 1;
            result.iterations.push_back(pass.passes.size());
            result.last = std::move(pass);
            if (options_.friction) system_.keep_springs(state);
        } else {
            result.reason += "; " + pass.reason;
            state = good;
        }
    }
    result.share = done;
    result.found = done >= 1;
    system_.set_time(done * time);
    describe(result, state);
    return result;
}

void NewtonSolver::describe(Equilibrium& result, const StaticState& state) {
    StaticState own = state;
    system_.refresh(own);
    result.factor = solution_.factor_name(); // of the iterations, where friction makes the stiffness unsymmetric
    auto [balance, asymmetry] = system_.sticking_balance(own);
    result.asymmetry = asymmetry;
    result.residual = system_.relative(balance);
    std::string reason;
    correction(own, balance, 0, reason);
    result.negative = solution_.negative();
    result.neutral = solution_.neutral().count();
    for (const NeutralMotions::Piece& piece : solution_.neutral().pieces)
        for (Eigen::Index m = 0; m < piece.motion.cols() && result.neutral_names.size() < 8; ++m)
            result.neutral_names.push_back(system_.name_of(piece, Unknown::Unit(piece.motion.cols(), m), own));
    if (result.asymmetry == 0) result.factor = solution_.factor_name();
}

} // namespace skein
