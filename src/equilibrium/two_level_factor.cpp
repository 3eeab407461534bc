#include "equilibrium/two_level_factor.hpp"

#include "equilibrium/large_factor.hpp"

#include <Eigen/Dense>
#include <Eigen/Jacobi>

#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <utility>

namespace skein {

namespace {

constexpr double tolerance = 1e-10; ///< of the scaled residual, over that of the right side
constexpr int most_iterations = 400, most_directions = 200;
constexpr int most_failures = 3;
constexpr double least_rod_pivot = 1e-14;
constexpr Eigen::Index large_coarse = 3000; ///< motions from which the factor of the coarse problem is a large one

/// Part between unknowns of the same rod.
Stiffness parts_of_rods(const Stiffness& matrix, const std::vector<int>& first) {
    Stiffness parts(matrix.rows(), matrix.cols());
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t r = 0; r + 1 < first.size(); ++r)
        for (int j = first[r]; j < first[r + 1]; ++j)
            for (Stiffness::InnerIterator at(matrix, j); at; ++at)
                if (at.row() >= j && at.row() < first[r + 1])
                    entries.emplace_back(static_cast<int>(at.row()), j, at.value());
    parts.setFromTriplets(entries.begin(), entries.end());
    return parts;
}

Unknown random_vector(Eigen::Index size) {
    std::mt19937 random(1);
    Unknown v(size);
    for (double& x : v) x = static_cast<double>(random()) / 4294967296.0 - 0.5;
    return v;
}

} // namespace

std::string_view TwoLevelFactor::name() const {
    if (direct_now_) return direct_->name();
    return symmetric_ ? "sparse factors of rods and rigid motions (conjugate gradients)"
                      : "sparse factors of rods and rigid motions (GMRES)";
}

double TwoLevelFactor::entries() const {
    if (direct_now_) return direct_->entries();
    return static_cast<double>(matrix_.nonZeros() + own_.matrixL().nestedExpression().nonZeros()) + coarse_->entries() +
           basis_;
}

bool TwoLevelFactor::factorise(const Stiffness& matrix) {
    scale_ = scales_of(matrix);
    matrix_ = scale_.asDiagonal() * matrix * scale_.asDiagonal();
    direct_now_ = false;
    negative_ = symmetric_ ? unknown : -1;
    if (failures_ < most_failures && make_levels()) return true;
    return go_direct();
}

/// Both levels are those of the symmetric part; false where it is singular, or has to be positive and is not.
bool TwoLevelFactor::make_levels() {
    const Stiffness even = symmetric_ ? matrix_ : Stiffness(0.5 * (matrix_ + Stiffness(matrix_.transpose())));
    own_.compute(parts_of_rods(even, rods_.first));
    if (own_.info() != Eigen::Success) return false;
    const Eigen::ArrayXd pivots = own_.vectorD().array();
    if (!((symmetric_ ? pivots : Eigen::ArrayXd(pivots.abs())) > least_rod_pivot).all()) return false;
    motions_ = rigid_motions();
    const Stiffness coarse = motions_.transpose() * Stiffness(even * motions_);
    if (!coarse_ && coarse.rows() >= large_coarse) coarse_ = make_large_factor(true);
    if (!coarse_) coarse_ = make_factor(coarse, true);
    return coarse_->factorise(coarse) && (!symmetric_ || coarse_->negative() == 0);
}

/// Orthonormal columns for each rod, without unknowns that are held.
Stiffness TwoLevelFactor::rigid_motions() const {
    std::vector<Eigen::Triplet<double>> entries;
    int column = 0;
    for (std::size_t r = 0; r + 1 < rods_.first.size(); ++r) {
        const int begin = rods_.first[r], count = rods_.first[r + 1] - begin;
        Eigen::MatrixXd motion = rods_.motion.middleRows(begin, count);
        for (int i = 0; i < count; ++i) {
            bool coupled = false;
            for (Stiffness::InnerIterator at(matrix_, begin + i); at && !coupled; ++at)
                coupled = at.row() != begin + i && at.value() != 0;
            motion.row(i) *= coupled ? 1 / scale_[begin + i] : 0;
        }
        Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(motion);
        qr.setThreshold(1e-9);
        const Eigen::MatrixXd own = qr.householderQ() * Eigen::MatrixXd::Identity(count, qr.rank());
        for (Eigen::Index m = 0; m < own.cols(); ++m, ++column)
            for (int i = 0; i < count; ++i) entries.emplace_back(begin + i, column, own(i, m));
    }
    Stiffness motions(matrix_.rows(), column);
    motions.setFromTriplets(entries.begin(), entries.end());
    return motions;
}

bool TwoLevelFactor::go_direct() const {
    if (++failures_ == most_failures) coarse_.reset(); // it stays so: the levels' memory is free
    if (!direct_) direct_ = make_factor(matrix_, symmetric_);
    direct_now_ = true;
    direct_regular_ = direct_->factorise(matrix_);
    negative_ = direct_->negative();
    return direct_regular_;
}

Unknown TwoLevelFactor::coarse(const Unknown& residual) const {
    return motions_ * coarse_->solve(motions_.transpose() * residual);
}

/// Rods, rigid motions, rods: symmetric, and positive as both levels are.
Unknown TwoLevelFactor::precondition(const Unknown& residual) const {
    constexpr double share = 0.5; // of the corrections of rods, which overlap at contacts
    Unknown x = share * own_.solve(residual);
    x += coarse(residual - matrix_ * x);
    x += share * own_.solve(residual - matrix_ * x);
    return x;
}

bool TwoLevelFactor::conjugate_gradients(const Unknown& right, Unknown& x) const {
    x = Unknown::Zero(right.size());
    const double enough = tolerance * right.norm();
    Unknown residual = right, step = precondition(residual), along = step;
    double square = residual.dot(step);
    for (iterations_ = 0; residual.norm() > enough; ++iterations_) {
        if (iterations_ == most_iterations || !(square > 0)) return false;
        const Unknown resisted = matrix_ * along;
        const double curvature = along.dot(resisted);
        if (!(curvature > 0)) return false;
        x += square / curvature * along;
        residual -= square / curvature * resisted;
        step = precondition(residual);
        const double next = residual.dot(step);
        along = step + next / square * along;
        square = next;
    }
    basis_ = 4.0 * static_cast<double>(right.size());
    return true;
}

/// Preconditioned from the right, so that the residual is that of the equations.
bool TwoLevelFactor::gmres(const Unknown& right, Unknown& x) const {
    const double size = right.norm();
    x = Unknown::Zero(right.size());
    iterations_ = 0;
    if (size == 0) return true;
    Eigen::MatrixXd basis(right.size(), 32);
    basis.col(0) = right / size;
    Eigen::MatrixXd triangle = Eigen::MatrixXd::Zero(most_directions + 1, most_directions);
    Unknown left = Unknown::Zero(most_directions + 1);
    left[0] = size;
    std::vector<Eigen::JacobiRotation<double>> turns;
    Eigen::Index k = 0;
    while (std::abs(left[k]) > tolerance * size) {
        if (k == most_directions) return false;
        Unknown next = matrix_ * precondition(basis.col(k));
        for (int pass = 0; pass < 2; ++pass) { // the second restores the right angles that rounding takes
            const Unknown parts = basis.leftCols(k + 1).transpose() * next;
            triangle.col(k).head(k + 1) += parts;
            next -= basis.leftCols(k + 1) * parts;
        }
        triangle(k + 1, k) = next.norm();
        if (!std::isfinite(triangle(k + 1, k))) return false;
        if (k + 1 == basis.cols()) basis.conservativeResize(Eigen::NoChange, 2 * basis.cols());
        basis.col(k + 1) = next / std::max(triangle(k + 1, k), 1e-300);
        for (Eigen::Index i = 0; i < k; ++i)
            triangle.col(k).applyOnTheLeft(i, i + 1, turns[static_cast<std::size_t>(i)].adjoint());
        turns.emplace_back();
        turns.back().makeGivens(triangle(k, k), triangle(k + 1, k));
        triangle.col(k).applyOnTheLeft(k, k + 1, turns.back().adjoint());
        left.applyOnTheLeft(k, k + 1, turns.back().adjoint());
        iterations_ = ++k;
    }
    const Unknown share = triangle.topLeftCorner(k, k).triangularView<Eigen::Upper>().solve(left.head(k));
    x = precondition(basis.leftCols(k) * share);
    basis_ = static_cast<double>(basis.size());
    return true;
}

Unknown TwoLevelFactor::solve(const Unknown& right) const {
    const Unknown scaled = scale_.cwiseProduct(right);
    if (!direct_now_) {
        Unknown x;
        if (symmetric_ ? conjugate_gradients(scaled, x) : gmres(scaled, x)) return scale_.cwiseProduct(x);
        go_direct();
    }
    if (!direct_regular_) return Unknown::Constant(right.size(), std::numeric_limits<double>::quiet_NaN());
    return scale_.cwiseProduct(direct_->solve(scaled));
}

/// A negative direction with any part in the right side would make the iteration's own matrix negative, too.
long TwoLevelFactor::negative() const {
    if (negative_ != unknown) return negative_;
    const long solution = iterations_;
    Unknown x;
    if (conjugate_gradients(random_vector(matrix_.rows()), x)) negative_ = 0;
    else go_direct();
    iterations_ = solution;
    return negative_;
}

} // namespace skein
