#include "equilibrium/factor.hpp"

#include "core/hash.hpp"
#include "equilibrium/large_factor.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace skein {

namespace {

constexpr long widest_band = 40; ///< of slots of a ring side by side

/// A pivot below this share of its unscaled diagonal is round-off.
constexpr double least_pivot = 1e-14;

/// L D L^T of a band, column by column: column j holds the entries from j to j + band.
class BandFactor final : public Factor {
public:
    std::string_view name() const override { return "band L D L^T"; }
    bool suits(const Stiffness& matrix, bool symmetric) const override {
        return symmetric && half_bandwidth(matrix) <= widest_band;
    }

    bool factorise(const Stiffness& matrix) override {
        const Eigen::Index n = matrix.rows();
        scale_ = scales_of(matrix);
        band_ = half_bandwidth(matrix);
        columns_.setZero(band_ + 1, n);
        for (Eigen::Index j = 0; j < n; ++j)
            for (Stiffness::InnerIterator at(matrix, j); at; ++at)
                if (at.row() >= j) columns_(at.row() - j, j) = at.value() * scale_[j] * scale_[at.row()];
        bool regular = true;
        negative_ = 0;
        for (Eigen::Index j = 0; j < n; ++j) {
            const Eigen::Index below = std::min<Eigen::Index>(band_, n - 1 - j);
            double& pivot = columns_(0, j);
            if (!(std::abs(pivot) > least_pivot)) {
                regular = false;
                pivot = least_pivot;
            }
            negative_ += pivot < 0;
            auto column = columns_.col(j).segment(1, below);
            const double inverse = 1 / pivot;
            for (Eigen::Index i = 0; i < below; ++i)
                if (const double share = inverse * column[i]; share != 0)
                    columns_.col(j + 1 + i).head(below - i) -= share * column.tail(below - i);
            column *= inverse;
        }
        return regular;
    }

    Unknown solve(const Unknown& right) const override {
        const Eigen::Index n = columns_.cols();
        Unknown x = scale_.cwiseProduct(right);
        for (Eigen::Index j = 0; j < n; ++j) {
            const Eigen::Index below = std::min<Eigen::Index>(band_, n - 1 - j);
            x.segment(j + 1, below) -= x[j] * columns_.col(j).segment(1, below);
        }
        for (Eigen::Index j = 0; j < n; ++j) x[j] /= columns_(0, j);
        for (Eigen::Index j = n - 1; j >= 0; --j) {
            const Eigen::Index below = std::min<Eigen::Index>(band_, n - 1 - j);
            x[j] -= columns_.col(j).segment(1, below).dot(x.segment(j + 1, below));
        }
        return scale_.cwiseProduct(x);
    }
    long negative() const override { return negative_; }
    double entries() const override { return static_cast<double>(columns_.size()); }

private:
    long band_ = 0, negative_ = 0;
    Unknown scale_;
    Eigen::MatrixXd columns_;
};

/// Hash of a sparsity pattern.
std::uint64_t pattern_of(const Stiffness& matrix) {
    std::uint64_t hash = hash_begin(static_cast<std::uint64_t>(matrix.rows()));
    const auto add = [&](const int* at, Eigen::Index count) {
        for (Eigen::Index i = 0; i < count; ++i) hash = hash_with(hash, static_cast<double>(at[i]));
    };
    add(matrix.outerIndexPtr(), matrix.outerSize() + 1);
    add(matrix.innerIndexPtr(), matrix.nonZeros());
    return hash_end(hash);
}

/// A solver of Eigen's for S K S, which analyses a pattern once.
template <class Solver> class SparseFactorBy : public Factor {
public:
    bool factorise(const Stiffness& matrix) override {
        scale_ = scales_of(matrix);
        const Stiffness scaled = scale_.asDiagonal() * matrix * scale_.asDiagonal();
        if (const std::uint64_t pattern = pattern_of(scaled); pattern != analysed_) {
            solver_.analyzePattern(scaled);
            analysed_ = pattern;
        }
        solver_.factorize(scaled);
        return solver_.info() == Eigen::Success;
    }
    Unknown solve(const Unknown& right) const override {
        const Unknown scaled = scale_.cwiseProduct(right);
        return scale_.cwiseProduct(solver_.solve(scaled));
    }

protected:
    Solver solver_;

private:
    Unknown scale_;
    std::uint64_t analysed_ = 0; ///< pattern that is known
};

class SparseFactor final
    : public SparseFactorBy<Eigen::SimplicialLDLT<Stiffness, Eigen::Lower, Eigen::AMDOrdering<int>>> {
public:
    std::string_view name() const override { return "sparse L D L^T (Eigen)"; }
    bool suits(const Stiffness&, bool symmetric) const override { return symmetric; }
    bool factorise(const Stiffness& matrix) override {
        if (!SparseFactorBy::factorise(matrix)) return false;
        const Unknown d = solver_.vectorD();
        negative_ = (d.array() < 0).count();
        return (d.array().abs() > least_pivot).all();
    }
    long negative() const override { return negative_; }
    double entries() const override { return static_cast<double>(solver_.matrixL().nestedExpression().nonZeros()); }

private:
    long negative_ = 0;
};

class GeneralFactor final : public SparseFactorBy<Eigen::SparseLU<Stiffness, Eigen::COLAMDOrdering<int>>> {
public:
    std::string_view name() const override { return "sparse LU (Eigen)"; }
    bool suits(const Stiffness&, bool symmetric) const override { return !symmetric; }
    long negative() const override { return -1; }
    double entries() const override { return static_cast<double>(solver_.nnzL() + solver_.nnzU()); }
};

} // namespace

void hold(Stiffness& matrix, const std::vector<int>& pins) {
    if (pins.empty()) return;
    std::vector<char> held(static_cast<std::size_t>(matrix.rows()), 0);
    for (const int pin : pins) held[static_cast<std::size_t>(pin)] = 1;
    const double size = matrix.diagonal().cwiseAbs().maxCoeff();
    for (Eigen::Index j = 0; j < matrix.outerSize(); ++j)
        for (Stiffness::InnerIterator at(matrix, j); at; ++at)
            if (held[static_cast<std::size_t>(at.row())] || held[static_cast<std::size_t>(at.col())])
                at.valueRef() = at.row() == at.col() ? std::max(size, 1e-300) : 0;
}

long half_bandwidth(const Stiffness& matrix) {
    long band = 0;
    const int *first = matrix.outerIndexPtr(), *row = matrix.innerIndexPtr();
    for (int j = 0; j < matrix.outerSize(); ++j)
        if (const int end = first[j + 1]; end > first[j]) // rows ascend in a column
            band = std::max<long>({band, j - row[first[j]], row[end - 1] - j});
    return band;
}

std::unique_ptr<Factor> make_factor(const Stiffness& matrix, bool symmetric, const Communicator* ranks) {
    const bool banded = symmetric && half_bandwidth(matrix) <= widest_band;
    if (matrix.rows() >= large_unknowns && !banded)
        if (std::unique_ptr<Factor> large = make_large_factor(symmetric, ranks)) return large;
    if (!symmetric) return std::make_unique<GeneralFactor>();
    if (banded) return std::make_unique<BandFactor>();
    return std::make_unique<SparseFactor>();
}

} // namespace skein
