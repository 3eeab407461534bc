#include "equilibrium/static_solution.hpp"

namespace skein {

bool StaticSolution::factorise(const StaticState& state, StaticSystem::Balance& balance) {
    neutral_ = system_->neutral(state, balance);
    pins_ = neutral_.pins();
    hold(*balance.stiffness, pins_);
    return factorise(*balance.stiffness, balance.asymmetry);
}

bool StaticSolution::factorise(const StaticSystem::Balance& balance, const Stiffness& mass) {
    neutral_ = {};
    pins_.clear();
    return factorise(*balance.stiffness + mass, balance.asymmetry);
}

bool StaticSolution::factorise(const Stiffness& stiffness, double asymmetry) {
    symmetric_ = is_symmetric(asymmetry);
    if (!factor_ || !factor_->suits(stiffness, symmetric_))
        factor_ = make_factor(stiffness, symmetric_, system_->ranks());
    return regular_ = factor_->factorise(stiffness);
}

Unknown StaticSolution::solve(Unknown right) const {
    for (const int pin : pins_) right[pin] = 0;
    Unknown x = factor_->solve(right);
    neutral_.take_out(x);
    return x;
}

Unknown StaticSolution::adjoint(Unknown right) const {
    neutral_.take_out(right);
    Unknown x = factor_->solve(right);
    for (const int pin : pins_) x[pin] = 0;
    return x;
}

} // namespace skein
