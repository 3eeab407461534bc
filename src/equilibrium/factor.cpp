#include "equilibrium/factor.hpp"

#include "core/hash.hpp"
#include "equilibrium/large_factor.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace skein {

namespace {

constexpr long widest_band = 40; ///< of slots of a ring side by side

/// A pivot below this share of its unscaled diagonal is round-off.
constexpr double least_pivot = 1e-14;

/// Scales S K S to a diagonal of 1, in which forces and couples, thick and thin rods compare.
Unknown scales_of(const Stiffness& matrix) {
    Unknown scale = matrix.diagonal().cwiseAbs();
    for (Eigen::Index i = 0; i < scale.size(); ++i) scale[i] = scale[i] > 0 ? 1 / std::sqrt(scale[i]) : 1;
    return scale;
}

/// A number of the places of entries, by which patterns are told apart.
std::uint64_t pattern_of(const Stiffness& matrix) {
    std::uint64_t hash = hash_begin(static_cast<std::uint64_t>(matrix.rows()));
    const auto add = [&](const int* at, Eigen::Index count) {
        for (Eigen::Index i = 0; i < count; ++i) hash = hash_with(hash, static_cast<double>(at[i]));
    };
    add(matrix.outerIndexPtr(), matrix.outerSize() + 1);
    add(matrix.innerIndexPtr(), matrix.nonZeros());
    return hash_end(hash);
}

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
        if (const std::uint64_t pattern = pattern_of(matrix); pattern != known_) {
            band_ = half_bandwidth(matrix);
            known_ = pattern;
        }
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
    double bytes() const override { return static_cast<double>(columns_.size() * 8); }

private:
    long band_ = 0, negative_ = 0;
    std::uint64_t known_ = 0; ///< pattern with this band
    Unknown scale_;
    Eigen::MatrixXd columns_;
};

class SparseFactor final : public Factor {
public:
    std::string_view name() const override { return "sparse L D L^T (Eigen)"; }
    bool suits(const Stiffness&, bool symmetric) const override { return symmetric; }
    bool factorise(const Stiffness& matrix) override {
        scale_ = scales_of(matrix);
        const Stiffness scaled = scale_.asDiagonal() * matrix * scale_.asDiagonal();
        if (const std::uint64_t pattern = pattern_of(scaled); pattern != analysed_) {
            factor_.analyzePattern(scaled);
            analysed_ = pattern;
        }
        factor_.factorize(scaled);
        if (factor_.info() != Eigen::Success) return false;
        const Unknown d = factor_.vectorD();
        negative_ = (d.array() < 0).count();
        return (d.array().abs() > least_pivot).all();
    }
    Unknown solve(const Unknown& right) const override {
        return scale_.cwiseProduct(factor_.solve(scale_.cwiseProduct(right)));
    }
    long negative() const override { return negative_; }
    double bytes() const override {
        return 16.0 * static_cast<double>(factor_.matrixL().nestedExpression().nonZeros());
    }

private:
    Eigen::SimplicialLDLT<Stiffness, Eigen::Lower, Eigen::AMDOrdering<int>> factor_;
    Unknown scale_;
    std::uint64_t analysed_ = 0; ///< pattern that is known
    long negative_ = 0;
};

class GeneralFactor final : public Factor {
public:
    std::string_view name() const override { return "sparse LU (Eigen)"; }
    bool suits(const Stiffness&, bool symmetric) const override { return !symmetric; }
    bool factorise(const Stiffness& matrix) override {
        scale_ = scales_of(matrix);
        const Stiffness scaled = scale_.asDiagonal() * matrix * scale_.asDiagonal();
        if (const std::uint64_t pattern = pattern_of(scaled); pattern != analysed_) {
            factor_.analyzePattern(scaled);
            analysed_ = pattern;
        }
        factor_.factorize(scaled);
        return factor_.info() == Eigen::Success;
    }
    Unknown solve(const Unknown& right) const override {
        const Unknown scaled = scale_.cwiseProduct(right);
        return scale_.cwiseProduct(factor_.solve(scaled));
    }
    long negative() const override { return -1; }
    double bytes() const override { return 16.0 * static_cast<double>(factor_.nnzL() + factor_.nnzU()); }

private:
    Eigen::SparseLU<Stiffness, Eigen::COLAMDOrdering<int>> factor_;
    Unknown scale_;
    std::uint64_t analysed_ = 0; ///< pattern that is known
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
    for (Eigen::Index j = 0; j < matrix.outerSize(); ++j)
        for (Stiffness::InnerIterator at(matrix, j); at; ++at)
            band = std::max<long>(band, std::labs(static_cast<long>(at.row() - at.col())));
    return band;
}

std::unique_ptr<Factor> make_factor(const Stiffness& matrix, bool symmetric) {
    const bool banded = symmetric && half_bandwidth(matrix) <= widest_band;
    if (matrix.rows() >= large_unknowns && !banded)
        if (std::unique_ptr<Factor> large = make_large_factor(symmetric)) return large;
    if (!symmetric) return std::make_unique<GeneralFactor>();
    if (banded) return std::make_unique<BandFactor>();
    return std::make_unique<SparseFactor>();
}

} // namespace skein
