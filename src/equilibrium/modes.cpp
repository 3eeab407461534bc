#include "equilibrium/modes.hpp"

#include "equilibrium/quadratic_modes.hpp"

#include <Eigen/Eigenvalues>
#include <Spectra/SymGEigsShiftSolver.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

double Mode::frequency() const {
    return (eigenvalue < 0 ? std::sqrt(-eigenvalue) : exponent.imag()) / (2 * std::numbers::pi);
}

double Mode::damping_ratio() const { return decay() / std::max(std::abs(exponent), 1e-300); }

bool Mode::grows() const { return eigenvalue < 0 || damping_ratio() < -1e-7; }

namespace {

constexpr int dense_unknowns = 300; ///< up to which all eigenvalues are found at once

/// (K - sigma M)^-1, as Spectra asks for it.
class ShiftedInverse {
public:
    using Scalar = double;
    ShiftedInverse(const Stiffness& stiffness, const Stiffness& mass, const Communicator* ranks)
        : stiffness_(stiffness), mass_(mass), ranks_(ranks) {}
    Eigen::Index rows() const { return stiffness_.rows(); }
    Eigen::Index cols() const { return stiffness_.cols(); }
    void set_shift(double sigma) {
        const Stiffness shifted = stiffness_ - sigma * mass_;
        factor_ = make_factor(shifted, true, ranks_);
        regular_ = factor_->factorise(shifted);
    }
    void perform_op(const double* in, double* out) const {
        const Eigen::Map<const Unknown> x(in, rows());
        Eigen::Map<Unknown>(out, rows()) = factor_->solve(x);
    }
    bool regular() const { return regular_; }

private:
    const Stiffness &stiffness_, &mass_;
    const Communicator* ranks_;
    std::unique_ptr<Factor> factor_;
    bool regular_ = false;
};

class MassProduct {
public:
    using Scalar = double;
    explicit MassProduct(const Stiffness& mass) : mass_(mass) {}
    Eigen::Index rows() const { return mass_.rows(); }
    Eigen::Index cols() const { return mass_.cols(); }
    void perform_op(const double* in, double* out) const {
        const Eigen::Map<const Unknown> x(in, rows());
        Eigen::Map<Unknown>(out, rows()) = mass_ * x;
    }

private:
    const Stiffness& mass_;
};

struct Pairs {
    Unknown value;
    Eigen::MatrixXd vector;
};

Pairs by_dense(const Stiffness& stiffness, const Stiffness& mass) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver{Eigen::MatrixXd(stiffness),
                                                                           Eigen::MatrixXd(mass)};
    return {solver.eigenvalues(), solver.eigenvectors()};
}

/// The `count` lowest; empty where Lanczos' iteration does not converge.
Pairs by_lanczos(const Stiffness& stiffness, const Stiffness& mass, double shift, Eigen::Index count,
                 const Communicator* ranks) {
    ShiftedInverse inverse(stiffness, mass, ranks);
    MassProduct product(mass);
    const Eigen::Index vectors = std::min<Eigen::Index>(stiffness.rows(), 2 * count + 20);
    Spectra::SymGEigsShiftSolver<ShiftedInverse, MassProduct, Spectra::GEigsMode::ShiftInvert> solver(
        inverse, product, count, vectors, shift);
    if (!inverse.regular()) return {};
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-12, Spectra::SortRule::SmallestAlge);
    if (solver.info() != Spectra::CompInfo::Successful) return {};
    return {solver.eigenvalues(), solver.eigenvectors()};
}

/// Share of a shape that lies in neutral motions, squared, by mass.
double neutral_share(const Unknown& shape, const Eigen::MatrixXd& neutral, const Stiffness& mass) {
    return neutral.cols() > 0 ? (neutral.transpose() * (mass * shape)).squaredNorm() : 0;
}

/// All neutral motions as columns that are orthonormal by mass.
Eigen::MatrixXd by_mass(const NeutralMotions& neutral, const Stiffness& mass) {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(mass.rows(), neutral.count());
    Eigen::Index column = 0;
    for (const NeutralMotions::Piece& piece : neutral.pieces)
        for (Eigen::Index m = 0; m < piece.motion.cols(); ++m, ++column)
            for (std::size_t r = 0; r < piece.unknowns.size(); ++r)
                all(piece.unknowns[r], column) = piece.motion(static_cast<Eigen::Index>(r), m);
    const Eigen::MatrixXd gram = all.transpose() * (mass * all);
    const Eigen::LLT<Eigen::MatrixXd> factor(gram);
    return factor.matrixL().solve(all.transpose()).transpose();
}

/// True where a matrix answers a motion by more than round-off.
bool resists(const Stiffness& matrix, const Unknown& motion) {
    constexpr double round_off = 1e-9;
    const Unknown terms = matrix.cwiseAbs() * motion.cwiseAbs();
    return (matrix * motion).lpNorm<Eigen::Infinity>() > round_off * terms.lpNorm<Eigen::Infinity>();
}

/// Modes without damping of loads with a potential.
void find_swinging(const StaticSystem& system, const Stiffness& stiffness, const Stiffness& mass, int count,
                   ModesResult& result) {
    const Eigen::Index neutral = result.neutral.count(),
                       wanted = std::min<Eigen::Index>(stiffness.rows(), count + neutral);
    Pairs pairs;
    if (stiffness.rows() <= dense_unknowns) {
        pairs = by_dense(stiffness, mass);
        result.method = "dense eigenvalues (Eigen)";
    } else {
        pairs = by_lanczos(stiffness, mass, -system.slow_eigenvalue(), wanted, system.ranks());
        result.method = "shifted and inverted Lanczos (Spectra)";
    }
    if (pairs.value.size() == 0) {
        result.reason = "Lanczos' iteration did not converge, or the stiffness is singular at its shift";
        return;
    }
    const Eigen::MatrixXd still = by_mass(result.neutral, mass);
    const Stiffness sizes = stiffness.cwiseAbs();
    for (Eigen::Index i = 0; i < std::min(wanted, pairs.value.size()); ++i) {
        Mode mode{.eigenvalue = pairs.value[i], .shape = pairs.vector.col(i)};
        mode.exponent = mode.eigenvalue < 0 ? std::complex(std::sqrt(-mode.eigenvalue), 0.0)
                                            : std::complex(0.0, std::sqrt(mode.eigenvalue));
        mode.shape /= std::sqrt(mode.shape.dot(mass * mode.shape));
        const Unknown off = stiffness * mode.shape - mode.eigenvalue * (mass * mode.shape);
        mode.residual = off.lpNorm<1>() / std::max((sizes * mode.shape.cwiseAbs()).lpNorm<1>(), 1e-300);
        mode.neutral = neutral_share(mode.shape, still, mass) > 0.5;
        result.modes.push_back(std::move(mode));
    }
}

/// A mode of this exponent and shape, which is scaled to phi^H M phi = 1 with as much of it as can be in its real part.
Mode damped_mode(const SmallMotions& motions, std::complex<double> exponent, Eigen::VectorXcd shape) {
    const std::complex<double> along = shape.transpose() * (motions.mass * shape);
    if (std::abs(along) > 0) shape *= std::sqrt(std::conj(along) / std::abs(along));
    shape /= std::sqrt((shape.adjoint() * (motions.mass * shape)).value().real());
    const Eigen::VectorXcd off =
        exponent * (exponent * (motions.mass * shape) + motions.damping * shape) + motions.stiffness * shape;
    const Unknown size = shape.cwiseAbs();
    const double lambda = std::abs(exponent), terms = lambda * (lambda * (motions.mass.cwiseAbs() * size).lpNorm<1>() +
                                                                (motions.damping.cwiseAbs() * size).lpNorm<1>()) +
                                                      (motions.stiffness.cwiseAbs() * size).lpNorm<1>();
    Mode mode{.eigenvalue = lambda * lambda, .residual = off.lpNorm<1>() / std::max(terms, 1e-300)};
    mode.exponent = exponent;
    mode.shape = shape.real();
    if (exponent.imag() > 0) mode.quadrature = shape.imag();
    return mode;
}

/// Modes with damping. Each neutral motion is one of lambda = 0, twice where nothing damps it.
void find_damped(const StaticSystem& system, const SmallMotions& motions, int count, ModesResult& result) {
    const Eigen::MatrixXd still = by_mass(result.neutral, motions.mass);
    const double unit = std::sqrt(system.slow_eigenvalue());
    Eigen::Index zeros = 2 * still.cols();
    if (still.cols() > 0) {
        const Eigen::MatrixXd decay = still.transpose() * (motions.damping * still);
        zeros -= (Eigen::JacobiSVD<Eigen::MatrixXd>(decay).singularValues().array() > 1e-8 * unit).count();
    }
    for (Eigen::Index m = 0; m < still.cols(); ++m) {
        Mode mode = damped_mode(motions, 0.0, still.col(m).cast<std::complex<double>>());
        mode.neutral = true;
        result.modes.push_back(std::move(mode));
    }
    const std::vector<ExponentPair> pairs = smallest_exponents(motions, unit, count, zeros);
    result.method = "shifted and inverted block Arnoldi";
    if (pairs.empty() && 2 * motions.mass.rows() > zeros)
        result.reason = "Arnoldi's iteration did not converge, or is singular at its shift";
    for (const ExponentPair& pair : pairs) result.modes.push_back(damped_mode(motions, pair.exponent, pair.shape));
}

} // namespace

ModesResult find_modes(StaticSystem& system, const StaticState& state, int count, bool undamped) {
    ModesResult result;
    Stiffness damping(system.unknowns(), system.unknowns());
    if (!undamped) damping = system.damping(state);
    const auto [balance, asymmetry] = system.sticking_balance(state);
    result.asymmetry = asymmetry;
    const Stiffness& stiffness = *balance.stiffness;
    const Stiffness mass = system.mass(state);
    result.neutral = system.neutral(state, balance);
    constexpr double round_off = 1e-9;
    const bool potential = balance.asymmetry <= round_off;
    const Unknown spin = undamped ? Unknown() : system.axial_spin(state);
    result.slowed = spin.size() > 0 && (resists(stiffness, spin) || resists(damping, spin));
    result.gyroscopic = spin.size() > 0 && !result.slowed;
    if (result.gyroscopic) damping = Stiffness(damping + system.gyroscopic(spin));
    result.damped = !potential || damping.nonZeros() > 0;
    if (!result.damped) {
        find_swinging(system, stiffness, mass, count, result);
        return result;
    }
    const Stiffness transposed = damping.transpose();
    const bool symmetric =
        potential && Stiffness(damping - transposed).norm() <= round_off * std::max(damping.norm(), 1e-300);
    find_damped(system, {mass, damping, stiffness, symmetric}, count, result);
    return result;
}

} // namespace skein
