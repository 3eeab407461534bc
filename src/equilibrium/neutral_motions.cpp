// Neutral motions: pieces of a stiffness, their rigid motions, and those that nothing resists.
#include "equilibrium/static_system.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace skein {

std::vector<std::vector<int>> StaticSystem::pieces(const Stiffness& stiffness) const {
    if (rods_.size() == 1) {
        std::vector<int> all(static_cast<std::size_t>(unknowns()));
        std::iota(all.begin(), all.end(), 0);
        if (all.empty()) return {};
        return {std::move(all)};
    }
    std::vector<std::size_t> leader(rods_.size());
    std::iota(leader.begin(), leader.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
        while (leader[i] != i) i = leader[i] = leader[leader[i]];
        return i;
    };
    for (Eigen::Index j = 0; j < stiffness.outerSize(); ++j) {
        const std::size_t rod = unknowns_.place(static_cast<int>(j)).rod;
        for (Stiffness::InnerIterator at(stiffness, j); at; ++at)
            if (const std::size_t other = unknowns_.place(static_cast<int>(at.row())).rod; other != rod)
                leader[root(other)] = root(rod);
    }
    std::map<std::size_t, std::vector<int>> of;
    for (int u = 0; u < unknowns(); ++u) of[root(unknowns_.place(u).rod)].push_back(u);
    std::vector<std::vector<int>> pieces;
    for (auto& [at, own] : of) pieces.push_back(std::move(own));
    return pieces;
}

Vec3d StaticSystem::centre(const std::vector<int>& piece, const StaticState& state) const {
    Vec3d sum{0, 0, 0};
    double nodes = 0;
    for (const int u : piece) {
        if (unknowns_.place(u).i >= 3) continue;
        sum = sum + lane(slot(u, state).position, 0);
        ++nodes;
    }
    return nodes > 0 ? (1 / nodes) * sum : sum;
}

StaticSystem::RigidMotions StaticSystem::rigid_motions(int unknown, const Vec3d& middle,
                                                       const StaticState& state) const {
    constexpr Vec3d units[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const auto part = [](const Vec3d& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; };
    const int i = unknowns_.place(unknown).i;
    const Slot<1>& at = slot(unknown, state);
    RigidMotions motions;
    for (int m = 0; m < 3; ++m) {
        const Vec3d axis = (1 / length_) * units[m];
        motions[m] = i == m;
        motions[3 + m] =
            i < 3 ? part(cross(axis, lane(at.position, 0) - middle), i) : part(lane(at.director, 0) * axis, i - 3);
    }
    motions[6] = i == 5 ? 1 / length_ : 0;
    return motions;
}

/// Three translations, three turns about the piece's centre that move a rod's end by 1, and the spin of all elements
/// about their own axes: round rods that are straight at rest do not resist it, bent or not.
Eigen::MatrixXd StaticSystem::rigid_motions(const std::vector<int>& piece, const StaticState& state) const {
    Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(piece.size()), 7);
    const Vec3d middle = centre(piece, state);
    for (Eigen::Index r = 0; r < motions.rows(); ++r)
        motions.row(r) = rigid_motions(piece[static_cast<std::size_t>(r)], middle, state);
    return motions;
}

RodMotions StaticSystem::motions_of_rods(const StaticState& state) const {
    RodMotions rods;
    rods.motion.resize(unknowns(), 6);
    std::vector<int> own;
    for (int u = 0; u < unknowns(); ++u) {
        own.push_back(u);
        if (u + 1 < unknowns() && unknowns_.place(u + 1).rod == unknowns_.place(u).rod) continue;
        rods.first.push_back(own.front());
        const Vec3d middle = centre(own, state);
        for (const int at : own) rods.motion.row(at) = rigid_motions(at, middle, state).head<6>();
        own.clear();
    }
    rods.first.push_back(unknowns());
    return rods;
}

NeutralMotions StaticSystem::neutral(const StaticState& state, const Balance& balance, bool sampled) const {
    NeutralMotions found;
    if (all_gripped_) return found;
    Resistance work;
    const auto add = [&](std::vector<int> piece) {
        if (sampled && sample_resists(piece, state, balance, work)) return false;
        ++found.asked_in_full;
        return add_neutral(std::move(piece), state, balance, work, found);
    };
    for (std::vector<int>& piece : pieces(*balance.stiffness)) {
        if (add(piece)) continue;
        const auto rod_of = [&](int u) { return unknowns_.place(u).rod; };
        if (rod_of(piece.front()) == rod_of(piece.back())) continue;
        // Bodies that touch others may roll or slide by themselves.
        for (auto begin = piece.begin(); begin != piece.end();) {
            const auto end = std::find_if(begin, piece.end(), [&](int u) { return rod_of(u) != rod_of(*begin); });
            add({begin, end});
            begin = end;
        }
    }
    return found;
}

/// Adds the rigid motions of these unknowns that nothing resists; true where there are some.
bool StaticSystem::add_neutral(std::vector<int> piece, const StaticState& state, const Balance& balance,
                               Resistance& work, NeutralMotions& found) const {
    // Orthonormal before it is asked what they meet: a turn less a spin may move a straight rod by next to nothing.
    const auto count = static_cast<Eigen::Index>(piece.size());
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rigid_motions(piece, state));
    qr.setThreshold(1e-9);
    const Eigen::Index rank = qr.rank();
    Motions own = Motions::Zero(count, 8);
    own.leftCols(rank) = qr.householderQ() * Eigen::MatrixXd::Identity(count, rank);
    if (work.met.empty()) {
        work.resisted = work.terms = Motions::Zero(unknowns(), 8);
        work.met.resize(static_cast<std::size_t>(unknowns()));
    }
    work.rows.clear();
    const Stiffness& stiffness = *balance.stiffness;
    for (Eigen::Index c = 0; c < count; ++c) {
        const Eigen::Matrix<double, 1, 8> motion = own.row(c), size = motion.cwiseAbs();
        for (Stiffness::InnerIterator at(stiffness, piece[static_cast<std::size_t>(c)]); at; ++at) {
            std::uint8_t& met = work.met[static_cast<std::size_t>(at.row())];
            if (!met) work.rows.push_back(static_cast<int>(at.row()));
            met = 1;
            work.resisted.row(at.row()).noalias() += at.value() * motion;
            work.terms.row(at.row()).noalias() += std::abs(at.value()) * size;
        }
    }
    std::sort(work.rows.begin(), work.rows.end());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(std::max(static_cast<Eigen::Index>(work.rows.size()), rank), rank);
    for (std::size_t r = 0; r < work.rows.size(); ++r) {
        const int u = work.rows[r];
        const double lever = unknowns_.place(u).i < 3 ? 1 : length_;
        const double change = 1e-7 * balance.force_size * lever / length_,
                     rounding = 1e-13 * std::sqrt(static_cast<double>(count)) * work.terms.row(u).maxCoeff();
        rows.row(static_cast<Eigen::Index>(r)) = work.resisted.row(u).head(rank) / std::max({change, rounding, 1e-300});
        work.resisted.row(u).setZero();
        work.terms.row(u).setZero();
        work.met[static_cast<std::size_t>(u)] = 0;
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> upper(rows);
    const Eigen::MatrixXd triangle = upper.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeFullV);
    Eigen::Index resisting = 0;
    while (resisting < rank && svd.singularValues()[resisting] >= 1) ++resisting;
    if (resisting == rank) return false;
    found.pieces.push_back({std::move(piece), own.leftCols(rank) * svd.matrixV().rightCols(rank - resisting)});
    return true;
}

std::string StaticSystem::name_of(const NeutralMotions::Piece& piece, const Unknown& along,
                                  const StaticState& state) const {
    const Unknown motion = piece.motion * along;
    Vec3d shift{0, 0, 0}, turn{0, 0, 0};
    double nodes = 0, elements = 0, shifts = 0, turns = 0; // these: sums of squares
    for (std::size_t r = 0; r < piece.unknowns.size(); ++r) {
        const auto place = unknowns_.place(piece.unknowns[r]);
        const double value = motion[static_cast<Eigen::Index>(r)];
        Vec3d unit{0, 0, 0};
        (place.i % 3 == 0 ? unit.x : place.i % 3 == 1 ? unit.y : unit.z) = value;
        if (place.i < 3) {
            shift = shift + unit;
            shifts += value * value;
            nodes += 1.0 / 3;
        } else {
            turn = turn + transpose_times(lane(slot(piece.unknowns[r], state).director, 0), unit);
            turns += length_ * length_ * value * value;
            elements += 1.0 / 3;
        }
    }
    shift = (1 / std::max(nodes, 1.0)) * shift;
    turn = (length_ / std::max(elements, 1.0)) * turn;
    const std::string rod = rod_name(unknowns_.place(piece.unknowns.front()).rod);
    if (shifts < 1e-9 * turns && dot(turn, turn) * elements < 0.999 * turns)
        return fmt::format("turn of {} about its own axis", rod);
    const bool is_turn = norm(turn) > norm(shift);
    const Vec3d axis = is_turn ? unit(turn) : norm(shift) > 0 ? unit(shift) : shift;
    return fmt::format("{} ({:.3g}, {:.3g}, {:.3g}) of {}", is_turn ? "turn about" : "translation along", axis.x,
                       axis.y, axis.z, rod);
}

Unknown NeutralMotions::Piece::part_of(const Unknown& all) const {
    Unknown own(motion.rows());
    for (Eigen::Index r = 0; r < own.size(); ++r) own[r] = all[unknowns[static_cast<std::size_t>(r)]];
    return own;
}

std::vector<int> NeutralMotions::pins() const {
    std::vector<int> all;
    for (const Piece& piece : pieces) {
        const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(piece.motion.transpose());
        for (Eigen::Index m = 0; m < piece.motion.cols(); ++m)
            all.push_back(piece.unknowns[static_cast<std::size_t>(qr.colsPermutation().indices()[m])]);
    }
    return all;
}

Eigen::Index NeutralMotions::count() const {
    Eigen::Index all = 0;
    for (const Piece& piece : pieces) all += piece.motion.cols();
    return all;
}

void NeutralMotions::take_out(Unknown& from) const {
    for (const Piece& piece : pieces) {
        Unknown own = piece.part_of(from);
        own -= piece.motion * (piece.motion.transpose() * own);
        for (Eigen::Index r = 0; r < own.size(); ++r) from[piece.unknowns[static_cast<std::size_t>(r)]] = own[r];
    }
}

} // namespace skein
