#include "equilibrium/quadratic_modes.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace skein {

namespace {

using Complex = std::complex<double>;

constexpr Eigen::Index together = 8; ///< vectors at the start, and so many alike eigenvalues that none is missed
constexpr int ahead = 4;             ///< powers of the operator that take fast motions from them
constexpr Eigen::Index most_vectors = 2000;
constexpr double real = 1e-10;      ///< imaginary part over the size that is round-off, of real ones that are alike
constexpr double near = 30;         ///< times the shift, within which the slowest motion has all digits
constexpr double converged = 1e-12; ///< residual of an eigenvalue of the operator over its size

/// The operator, in unknowns times the root of their mass and rates over the unit.
class ShiftedPairs {
public:
    ShiftedPairs(const SmallMotions& motions, double unit) {
        scale_ = motions.mass.diagonal().cwiseSqrt().cwiseInverse();
        const auto scaled = [&](const Stiffness& matrix, double by) {
            Stiffness all = scale_.asDiagonal() * matrix * scale_.asDiagonal();
            all *= by;
            return all;
        };
        mass_ = scaled(motions.mass, 1);
        damping_ = scaled(motions.damping, 1 / unit);
        const Stiffness stiffness = scaled(motions.stiffness, 1 / (unit * unit)),
                        shifted = stiffness + damping_ + mass_, transposed = stiffness.transpose();
        factor_ = make_factor(shifted, motions.symmetric);
        regular_ = factor_->factorise(shifted);
        // Energy falls along motions that grow: more mass makes it positive.
        constexpr double most = 1e6;
        for (double share = 1; share <= most; share *= 4) {
            energy_ = 0.5 * (stiffness + transposed) + share * mass_;
            const std::unique_ptr<Factor> trial = make_factor(energy_, true);
            if (trial->factorise(energy_) && trial->negative() <= 0) break;
        }
    }
    /// Weights of the inner product, that of the energy, in which slow and fast swings are normal.
    Unknown weighted(const Unknown& pair) const {
        const Eigen::Index n = scale_.size();
        Unknown out(2 * n);
        out.head(n) = energy_ * pair.head(n);
        out.tail(n) = mass_ * pair.tail(n);
        return out;
    }
    bool regular() const { return regular_; } ///< has an inverse about the shift
    Eigen::Index size() const { return 2 * scale_.size(); }
    Unknown operator()(const Eigen::Ref<const Unknown>& pair) const {
        const Eigen::Index n = scale_.size();
        const Unknown both = pair.head(n) + pair.tail(n);
        Unknown out(2 * n);
        out.head(n) = -factor_->solve(mass_ * both + damping_ * pair.head(n));
        out.tail(n) = pair.head(n) + out.head(n);
        return out;
    }
    /// Displacements of a pair of the eigenvalue mu, from its larger half.
    Eigen::VectorXcd shape(const Eigen::VectorXcd& pair, Complex mu) const {
        const Eigen::Index n = scale_.size();
        const Eigen::VectorXcd x = std::abs(mu) > 1 ? Eigen::VectorXcd(pair.tail(n) / mu) : pair.head(n);
        return scale_.cast<Complex>().cwiseProduct(x);
    }

private:
    Unknown scale_;
    Stiffness mass_, damping_, energy_;
    std::unique_ptr<Factor> factor_;
    bool regular_ = false;
};

/// Basis that is orthonormal in the energy, and the operator in it.
class Krylov {
public:
    explicit Krylov(const ShiftedPairs& apply) : apply_(apply) {
        std::uint64_t state = 1;
        const auto random = [&] {
            state = state * 6364136223846793005u + 1442695040888963407u;
            return static_cast<double>(state >> 11) * 0x1p-52 - 1;
        };
        const Eigen::Index size = apply_.size(), count = std::min(together, size);
        Eigen::MatrixXd block = Eigen::MatrixXd::NullaryExpr(size, count, random);
        for (int i = 0; i < ahead; ++i) {
            const Eigen::HouseholderQR<Eigen::MatrixXd> qr(block);
            const Eigen::MatrixXd apart = qr.householderQ() * Eigen::MatrixXd::Identity(size, count);
            for (Eigen::Index j = 0; j < count; ++j) block.col(j) = apply_(apart.col(j));
        }
        for (Eigen::Index j = 0; j < count; ++j) add(block.col(j));
    }
    /// Applies the operator until `count` vectors of the basis are mapped; fewer where no other is met.
    void extend(Eigen::Index count) {
        while (mapped_ < std::min(count, size_)) {
            const Unknown weights = add(apply_(basis_.col(mapped_)));
            if (projected_.rows() < basis_.cols()) {
                const Eigen::Index old = projected_.rows();
                projected_.conservativeResize(basis_.cols(), basis_.cols());
                projected_.bottomRows(basis_.cols() - old).setZero();
                projected_.rightCols(basis_.cols() - old).setZero();
            }
            projected_.col(mapped_++).head(weights.size()) = weights;
        }
    }
    bool invariant() const { return mapped_ == size_; }
    Eigen::Index mapped() const { return mapped_; }
    Eigen::MatrixXd projected() const { return projected_.topLeftCorner(mapped_, mapped_); }
    /// Part of the image of a vector of the subspace that lies outside of it.
    double outside(const Eigen::VectorXcd& weights) const {
        return (projected_.block(mapped_, 0, size_ - mapped_, mapped_).cast<Complex>() * weights).norm();
    }
    Eigen::VectorXcd vector(const Eigen::VectorXcd& weights) const {
        Eigen::VectorXcd v(apply_.size());
        v.real() = basis_.leftCols(mapped_) * weights.real();
        v.imag() = basis_.leftCols(mapped_) * weights.imag();
        return v;
    }

private:
    /// Adds what of a vector lies outside of the basis. Returns its weights.
    Unknown add(Unknown v) {
        constexpr double dependent = 1e-13;
        if (size_ == basis_.cols()) basis_.conservativeResize(apply_.size(), std::max<Eigen::Index>(32, 2 * size_));
        const auto norm = [&] { return std::sqrt(std::max(0.0, v.dot(apply_.weighted(v)))); };
        const double before = norm();
        Unknown weights = Unknown::Zero(size_ + 1);
        for (int pass = 0; pass < 2; ++pass) {
            const Unknown part = basis_.leftCols(size_).transpose() * apply_.weighted(v);
            v -= basis_.leftCols(size_) * part;
            weights.head(size_) += part;
        }
        const double left = norm();
        if (size_ == apply_.size() || !(left > dependent * before)) return weights.head(size_);
        weights[size_] = left;
        basis_.col(size_++) = v / left;
        return weights;
    }

    const ShiftedPairs& apply_;
    Eigen::MatrixXd basis_, projected_;
    Eigen::Index size_ = 0, mapped_ = 0;
};

/// An eigenvalue mu of the subspace.
struct Found {
    Complex mu;
    Eigen::Index column;
};

/// Converged pairs, smallest first, up to the size below which none is missing.
std::vector<Found> settled(const Krylov& space, const Eigen::EigenSolver<Eigen::MatrixXd>& solver) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(space.mapped()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Eigen::Index i, Eigen::Index j) {
        return std::abs(solver.eigenvalues()[i]) > std::abs(solver.eigenvalues()[j]);
    });
    std::vector<Found> found;
    const Eigen::MatrixXcd vectors = solver.eigenvectors();
    double distance = 0; // from the shift, of the last that has converged
    bool all = space.invariant();
    for (const Eigen::Index i : order) {
        const Complex theta = solver.eigenvalues()[i];
        if (space.outside(vectors.col(i)) > converged * std::abs(theta)) break;
        if (theta == 0.0) break;
        const Complex mu = 1.0 + 1.0 / theta;
        distance = std::abs(mu - 1.0);
        found.push_back({mu, i});
    }
    // All within the distance from the shift are there, and so all that are smaller by 1.
    if (!all)
        found.erase(std::remove_if(found.begin(), found.end(),
                                   [&](const Found& one) { return std::abs(one.mu) > distance - 1; }),
                    found.end());
    std::stable_sort(found.begin(), found.end(),
                     [](const Found& a, const Found& b) { return std::abs(a.mu) < std::abs(b.mu); });
    return found;
}

/// Pairs that one shift finds, and the size of the smallest over the shift.
struct Smallest {
    std::vector<ExponentPair> pairs;
    double ratio = 0;
};

Smallest smallest(const SmallMotions& motions, double unit, Eigen::Index count, Eigen::Index zeros) {
    const ShiftedPairs apply(motions, unit);
    if (!apply.regular()) return {};
    Krylov space(apply);
    for (Eigen::Index most = 2 * (2 * count + zeros) + 3 * together;; most += most / 3) {
        space.extend(std::min(most, most_vectors));
        const Eigen::EigenSolver<Eigen::MatrixXd> solver(space.projected());
        std::vector<Found> found = settled(space, solver);
        found.erase(found.begin(), found.begin() + std::min<std::ptrdiff_t>(zeros, std::ssize(found)));
        found.erase(std::remove_if(found.begin(), found.end(),
                                   [](const Found& one) { return one.mu.imag() < -real * std::abs(one.mu); }),
                    found.end());
        const bool enough = std::ssize(found) >= count;
        if (!enough && !space.invariant()) {
            if (most >= most_vectors) return {};
            continue;
        }
        if (enough) found.erase(found.begin() + count, found.end());
        Smallest result;
        for (const Found& one : found) {
            const Eigen::VectorXcd weights = solver.eigenvectors().col(one.column);
            const bool swings = one.mu.imag() > real * std::abs(one.mu);
            const Complex mu = swings ? one.mu : Complex(one.mu.real());
            result.pairs.push_back({unit * mu, apply.shape(space.vector(weights), one.mu)});
        }
        if (!found.empty()) result.ratio = std::abs(found.front().mu);
        return result;
    }
}

} // namespace

std::vector<ExponentPair> smallest_exponents(const SmallMotions& motions, double unit, Eigen::Index count,
                                             Eigen::Index zeros) {
    Smallest found = smallest(motions, unit, count, zeros);
    if (found.ratio > near) found = smallest(motions, unit * found.ratio, count, zeros);
    return found.pairs;
}

} // namespace skein
