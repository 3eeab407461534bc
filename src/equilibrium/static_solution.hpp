// Solutions of K x = r at a state, without neutral motions.
#pragma once

#include "equilibrium/factor.hpp"
#include "equilibrium/static_system.hpp"

#include <memory>
#include <string_view>

namespace skein {

/// A stiffness is symmetric where loads have a potential, to rounding.
constexpr bool is_symmetric(double asymmetry) { return asymmetry < 1e-11; }

class StaticSolution {
public:
    explicit StaticSolution(const StaticSystem& system) : system_(&system) {}
    StaticSolution(const StaticSystem& system, const StaticState& state, StaticSystem::Balance& balance)
        : system_(&system) {
        factorise(state, balance);
    }

    /// False where the stiffness is singular to working precision. Changes the stiffness of the balance.
    bool factorise(const StaticState& state, StaticSystem::Balance& balance);
    /// With `mass` added to the stiffness, which then resists all motions: none is neutral.
    bool factorise(const StaticState& state, const StaticSystem::Balance& balance, const Stiffness& mass);
    Unknown solve(Unknown right) const;
    /// The transpose of solve() of a symmetric stiffness: adjoint(a).dot(b) is a.dot(solve(b)).
    Unknown adjoint(Unknown right) const;

    /// False where the last stiffness was singular to working precision: solutions mean nothing then.
    bool regular() const { return regular_; }
    const NeutralMotions& neutral() const { return neutral_; }
    bool symmetric() const { return symmetric_; }
    /// Negative eigenvalues of the last stiffness, in which neutral motions are held; -1: not known.
    long negative() const { return factor_ ? factor_->negative() : -1; }
    std::string_view factor_name() const { return factor_ ? factor_->name() : ""; }
    double factor_entries() const { return factor_ ? factor_->entries() : 0; }

private:
    bool factorise(const StaticState& state, const Stiffness& stiffness, double asymmetry);

    const StaticSystem* system_;
    NeutralMotions neutral_;
    std::vector<int> pins_;
    std::unique_ptr<Factor> factor_;
    bool symmetric_ = true, regular_ = true;
};

} // namespace skein
