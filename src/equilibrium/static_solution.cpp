#include "equilibrium/static_solution.hpp"

#include <cmath>

namespace skein {

namespace {

/// Stiffness is symmetric where loads have a potential, to rounding.
constexpr double round_off = 1e-11;

} // namespace

void StaticSolution::factorise(const StaticState& state, StaticSystem::Balance& balance, double shift) {
    Stiffness& stiffness = *balance.stiffness;
    neutral_ = system_->neutral(state, balance);
    pins_ = neutral_.pins();
    hold(stiffness, pins_);
    symmetric_ = balance.asymmetry < round_off;
    if (!factor_ || !factor_->suits(stiffness, symmetric_))
        factor_ = make_factor(stiffness, symmetric_, system_->ranks());
    if (shift > 0)
        for (Eigen::Index i = 0; i < stiffness.rows(); ++i) {
            double& own = stiffness.coeffRef(i, i);
            own += shift * std::abs(own);
        }
    factor_->factorise(stiffness);
}

Unknown StaticSolution::solve(Unknown right) const {
    for (const int pin : pins_) right[pin] = 0;
    Unknown x = factor_->solve(right);
    neutral_.take_out(x);
    return x;
}

} // namespace skein
