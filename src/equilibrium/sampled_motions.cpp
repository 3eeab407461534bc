// Test of a few rows of a stiffness for resistance to all rigid motions of a piece. Further rows only raise the
// resistance, so that such a piece has no neutral motion. Sizes are bounded from above and rounding as well:
// what this test leaves open, the test of all rows decides.
#include "equilibrium/static_system.hpp"

#include "core/rotation.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

using Seven = Eigen::Matrix<double, 7, 7>;

Eigen::Vector3d column(const Vec3d& v) { return {v.x, v.y, v.z}; }

/// Sums over nodes and elements that bound the size of rigid motions from above: |m|^2 <= m.gram m.
struct Extent {
    std::vector<Vec3d> node, axis; ///< places, and third directors of elements
    Vec3d middle{0, 0, 0};

    void find_middle() {
        for (const Vec3d& x : node) middle = middle + x;
        middle = (1 / std::max(1.0, static_cast<double>(node.size()))) * middle;
    }
    /// Gram matrix of three translations, of three turns about the middle that move a node at the distance of `length`
    /// by 1, and of the spin of all elements.
    Seven gram(double length) const {
        const double share = 1 / (length * length), elements = static_cast<double>(axis.size());
        Eigen::Vector3d sum = Eigen::Vector3d::Zero(), spin = Eigen::Vector3d::Zero();
        Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
        for (const Vec3d& x : node) {
            const Eigen::Vector3d r = column((1 / length) * (x - middle));
            sum += r;
            square += r * r.transpose();
        }
        for (const Vec3d& d : axis) spin += column(d);
        Seven gram = Seven::Zero();
        gram.topLeftCorner<3, 3>().diagonal().setConstant(static_cast<double>(node.size()));
        Eigen::Matrix3d skew;
        skew << 0, -sum[2], sum[1], sum[2], 0, -sum[0], -sum[1], sum[0], 0;
        gram.block<3, 3>(0, 3) = -skew;
        gram.block<3, 3>(3, 0) = skew;
        gram.block<3, 3>(3, 3) = (square.trace() + share * elements) * Eigen::Matrix3d::Identity() - square;
        gram.block<3, 1>(3, 6) = share * spin;
        gram.block<1, 3>(6, 3) = share * spin.transpose();
        gram(6, 6) = share * elements;
        return gram;
    }
    /// All elements on one line, to rounding: their spin is a turn about it.
    bool is_straight(double length) const {
        constexpr double round_off = 1e-14;
        if (axis.empty()) return false;
        const Vec3d along = axis.front();
        return std::all_of(axis.begin(), axis.end(), [&](const Vec3d& d) { return norm(d - along) <= round_off; }) &&
               std::all_of(node.begin(), node.end(),
                           [&](const Vec3d& x) { return norm(cross(along, x - middle)) <= round_off * length; });
    }
};

} // namespace

/// Slots near the ends of rods, and near those where other unknowns are held than in the next.
void StaticSystem::choose_sample() {
    constexpr long reach = 3;
    sampled_.assign(static_cast<std::size_t>(unknowns()), 0);
    for (std::size_t i = 0; i < rods_.size(); ++i) {
        const auto first = static_cast<long>(first_slot(i)), last = static_cast<long>(first_slot(i + 1)) - 1;
        const auto take = [&](long from, long to) {
            for (long s = std::max(from, first); s <= std::min(to, last); ++s)
                for (const int u : unknowns_.of(static_cast<std::size_t>(s)))
                    if (u >= 0) sampled_[static_cast<std::size_t>(u)] = 1;
        };
        take(first, first + reach - 1);
        take(last - reach + 1, last);
        for (long s = first; s < last; ++s) {
            const auto &one = unknowns_.of(static_cast<std::size_t>(s)),
                       &next = unknowns_.of(static_cast<std::size_t>(s + 1));
            bool alike = true;
            for (std::size_t j = 0; j < slot_unknowns; ++j) alike &= (one[j] < 0) == (next[j] < 0);
            if (!alike) take(s - reach + 1, s + reach);
        }
    }
}

bool StaticSystem::sample_resists(const std::vector<int>& piece, const StaticState& state, const Balance& balance,
                                  Resistance& work) const {
    if (!assembly_.has_symmetric_pattern()) return false; // columns show which entries a row has
    std::vector<int> sample;
    for (const int u : piece)
        if (sampled_[static_cast<std::size_t>(u)]) sample.push_back(u);
    if (sample.empty() || 4 * sample.size() > piece.size()) return false;
    Extent extent;
    const Slot<1>*node = nullptr, *element = nullptr;
    for (const int u : piece) {
        const Slot<1>& at = slot(u, state);
        const bool moves = unknowns_.place(u).i < 3;
        if (std::exchange(moves ? node : element, &at) == &at) continue;
        if (moves) extent.node.push_back(lane(at.position, 0));
        else extent.axis.push_back(third_director(lane(at.director, 0)));
    }
    extent.find_middle();
    // Coordinates in which a motion of size 1 is at most of length 1.
    const Eigen::Index motions = extent.is_straight(length_) ? 6 : 7;
    const Eigen::MatrixXd gram = extent.gram(length_).topLeftCorner(motions, motions);
    const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> size(scale.asDiagonal() * gram * scale.asDiagonal());
    constexpr double least_size = 1e-6; // motions that are more alike differ by their rounding
    if (!(size.eigenvalues()[0] > least_size)) return false;

    const Eigen::MatrixXd resisted =
        sampled_resistance(piece, sample, extent.middle, state, balance, work).leftCols(motions) * scale.asDiagonal() *
        size.eigenvectors() * size.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
    if (resisted.rows() < motions) return false;
    constexpr double margin = 2; // over 1, where all rows are asked
    const Eigen::HouseholderQR<Eigen::MatrixXd> upper(resisted);
    const Eigen::MatrixXd triangle = upper.matrixQR().topRows(motions).triangularView<Eigen::Upper>();
    return Eigen::JacobiSVD<Eigen::MatrixXd>(triangle).singularValues()[motions - 1] >= margin;
}

/// Forces by which the unknowns of a sample answer the seven rigid motions, over what does not count.
Eigen::MatrixXd StaticSystem::sampled_resistance(const std::vector<int>& piece, const std::vector<int>& sample,
                                                 const Vec3d& middle, const StaticState& state, const Balance& balance,
                                                 Resistance& work) const {
    const Stiffness& stiffness = *balance.stiffness;
    if (work.place.empty()) work.place.assign(static_cast<std::size_t>(unknowns()), -1);
    std::vector<int> columns;
    for (std::size_t r = 0; r < sample.size(); ++r) {
        work.place[static_cast<std::size_t>(sample[r])] = static_cast<int>(r);
        for (Stiffness::InnerIterator at(stiffness, sample[r]); at; ++at) columns.push_back(static_cast<int>(at.row()));
    }
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    const auto rows = static_cast<Eigen::Index>(sample.size());
    Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor> resisted =
        Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>::Zero(rows, 7);
    Eigen::VectorXd terms = Eigen::VectorXd::Zero(rows);
    for (const int c : columns) {
        if (!std::binary_search(piece.begin(), piece.end(), c)) continue;
        const RigidMotions motion = rigid_motions(c, middle, state);
        for (Stiffness::InnerIterator at(stiffness, c); at; ++at) {
            const int r = work.place[static_cast<std::size_t>(at.row())];
            if (r < 0) continue;
            resisted.row(r) += at.value() * motion;
            terms[r] += std::abs(at.value());
        }
    }
    for (Eigen::Index r = 0; r < rows; ++r) {
        const int u = sample[static_cast<std::size_t>(r)];
        work.place[static_cast<std::size_t>(u)] = -1;
        const double lever = unknowns_.place(u).i < 3 ? 1 : length_;
        const double change = 1e-7 * balance.force_size * lever / length_,
                     rounding = 1e-13 * std::sqrt(static_cast<double>(piece.size())) * terms[r];
        resisted.row(r) /= std::max({change, rounding, 1e-300});
    }
    return resisted;
}

} // namespace skein
