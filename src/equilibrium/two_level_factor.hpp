// Solutions of large stiffnesses of many short rods by iteration: conjugate gradients, or GMRES without symmetry, with
// the factors of rods by themselves and with the rigid motions of each rod as a coarse problem.       theory.md 25
#pragma once

#include "equilibrium/factor.hpp"

#include <Eigen/SparseCholesky>

#include <memory>
#include <string_view>
#include <vector>

namespace skein {

/// Unknowns of rods, and six motions of each as a rigid body.
struct RodMotions {
    std::vector<int> first; ///< unknown of each rod, and the number of all
    Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> motion;
};

/// The direct factor of make_factor() takes its place where the iteration does not converge, or meets a direction in
/// which the energy falls; after three such matrices it stays.
class TwoLevelFactor final : public Factor {
public:
    explicit TwoLevelFactor(bool symmetric) : symmetric_(symmetric) {}

    /// The rods of matrices from here on.
    void set_rods(RodMotions rods) { rods_ = std::move(rods); }

    std::string_view name() const override;
    bool suits(const Stiffness&, bool symmetric) const override { return symmetric == symmetric_; }
    bool factorise(const Stiffness& matrix) override;
    Unknown solve(const Unknown& right) const override;
    /// 0 where conjugate gradients from a vector of random numbers meet none.
    long negative() const override;
    double entries() const override;

    long iterations() const { return iterations_; } ///< of the last solution
    bool is_direct() const { return direct_now_; }

private:
    bool make_levels();
    Stiffness rigid_motions() const;
    bool go_direct() const;
    /// One step to the solution from each level.
    Unknown precondition(const Unknown& residual) const;
    Unknown coarse(const Unknown& residual) const;
    bool conjugate_gradients(const Unknown& right, Unknown& x) const;
    bool gmres(const Unknown& right, Unknown& x) const;

    bool symmetric_;
    RodMotions rods_;
    Unknown scale_;
    Stiffness matrix_; ///< scaled
    Stiffness motions_;
    Eigen::SimplicialLDLT<Stiffness, Eigen::Lower, Eigen::NaturalOrdering<int>> own_;
    mutable std::unique_ptr<Factor> coarse_;
    mutable std::unique_ptr<Factor> direct_;
    mutable bool direct_now_ = false, direct_regular_ = true;
    mutable int failures_ = 0;
    mutable long iterations_ = 0, negative_ = unknown;
    mutable double basis_ = 0; ///< numbers of the last iteration's vectors
    static constexpr long unknown = -2;
};

} // namespace skein
