#include "equilibrium/static_solution.hpp"

#include "equilibrium/two_level_factor.hpp"

namespace skein {

bool StaticSolution::factorise(const StaticState& state, StaticSystem::Balance& balance) {
    neutral_ = system_->neutral(state, balance);
    pins_ = neutral_.pins();
    hold(*balance.stiffness, pins_);
    return factorise(state, *balance.stiffness, balance.asymmetry);
}

bool StaticSolution::factorise(const StaticState& state, const StaticSystem::Balance& balance, const Stiffness& mass) {
    neutral_ = {};
    pins_.clear();
    return factorise(state, *balance.stiffness + mass, balance.asymmetry);
}

bool StaticSolution::factorise(const StaticState& state, const Stiffness& stiffness, double asymmetry) {
    symmetric_ = is_symmetric(asymmetry);
    if (!factor_ || !factor_->suits(stiffness, symmetric_)) {
        if (system_->is_heap()) factor_ = std::make_unique<TwoLevelFactor>(symmetric_);
        else factor_ = make_factor(stiffness, symmetric_, system_->ranks());
    }
    if (auto* two_level = dynamic_cast<TwoLevelFactor*>(factor_.get()))
        two_level->set_rods(system_->motions_of_rods(state));
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
