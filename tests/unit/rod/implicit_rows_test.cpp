// Block rows against dense solutions, and the stiffness of elastic rows against differences of the loads.
#include "implicit/elastic_rows.hpp"
#include "mechanics/drift.hpp"
#include "support/rods_for_tests.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace skein {
namespace {

using P = Pack<1>;

/// A row of the system as numbers.
struct Numbers {
    double diagonal[6][6], before[6][6], after[6][6], right[6];
};

std::vector<Numbers> random_rows(int count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    std::vector<Numbers> rows(to_index(count));
    for (Numbers& row : rows)
        for (int i = 0; i < row_size; ++i) {
            for (int j = 0; j < row_size; ++j) {
                row.diagonal[i][j] = any(random) + (i == j ? 12 : 0);
                row.before[i][j] = any(random);
                row.after[i][j] = any(random);
            }
            row.right[i] = any(random);
        }
    return rows;
}

void expect_solution(int count, bool ring) {
    const std::vector<Numbers> rows = random_rows(count);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(6 * count, 6 * count);
    Eigen::VectorXd b(6 * count);
    BlockRows<1> system;
    system.begin(count - 1, ring);
    for (int k = 0; k < count; ++k) {
        const Numbers& n = rows[to_index(k)];
        BlockRow<1> row;
        for (int i = 0; i < row_size; ++i) {
            b(6 * k + i) = n.right[i];
            row.right[i] = P(n.right[i]);
            for (int j = 0; j < row_size; ++j) {
                row.diagonal[i][j] = P(n.diagonal[i][j]);
                row.before[i][j] = P(n.before[i][j]);
                row.after[i][j] = P(n.after[i][j]);
                a(6 * k + i, 6 * k + j) += n.diagonal[i][j];
                if (k > 0 || ring) a(6 * k + i, 6 * ((k + count - 1) % count) + j) += n.before[i][j];
                if (k + 1 < count || ring) a(6 * k + i, 6 * ((k + 1) % count) + j) += n.after[i][j];
            }
        }
        system.add(k, row);
    }
    std::vector<RowVector<1>> u(to_index(count));
    system.solve(u.data());
    const Eigen::VectorXd expected = a.partialPivLu().solve(b);
    for (int k = 0; k < count; ++k)
        for (int i = 0; i < row_size; ++i) EXPECT_NEAR(u[to_index(k)].u[i][0], expected(6 * k + i), 1e-13);
}

TEST(BlockRows, SolveOpenRods) {
    for (const int count : {1, 2, 3, 9}) expect_solution(count, false);
}
TEST(BlockRows, SolveRings) {
    for (const int count : {3, 4, 9}) expect_solution(count, true);
}

struct Moved {
    std::vector<Slot<1>> state;
    std::vector<Vec3<P>> carried;
};

std::vector<SlotLoad<1>> loads_of(const RodGroup& group, Moved& m) {
    std::vector<SlotLoad<1>> load(m.state.size());
    if (group.closed()) close_ring(test::tile_of(group, m.state));
    EndWalls<1> walls;
    walls.bind(test::tile_of(group, m.state));
    with_energy_law(group.law(), [&]<class L>(L) {
        ElasticRows<L, 1>(ends_of(group), walls)
            .loads(test::tile_of(group, m.state), m.carried.data(), Step{}, load.data());
    });
    if (group.closed()) load[0].force += load.back().force;
    return load;
}

/// A strained rod at the strains of its state.
struct Shaken {
    Shaken(const RodSpec& spec, double turn, unsigned seed) : group(spec, 0, 0, "") {
        at.state = test::shaken_state(group, 1e-3 * group.element[0].rest_length, turn, 0, seed);
        carry(at);
    }
    void carry(Moved& m) const {
        if (group.closed()) close_ring(test::tile_of(group, m.state));
        m.carried.clear();
        for (int k = 0; k < group.elements(); ++k)
            m.carried.push_back(element_strain<Across<1>>(test::tile_of(group, m.state), k));
    }
    int rows() const { return group.nodes(); }
    bool has(int row, int i) const { return i < 3 || row < group.elements(); }

    RodGroup group;
    Moved at;
};

Eigen::MatrixXd matrix_of_rows(Shaken& rod) {
    const int count = rod.rows();
    const bool ring = rod.group.closed();
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(6 * count, 6 * count);
    EndWalls<1> walls;
    const RodTile<1> tile = test::tile_of(rod.group, rod.at.state);
    walls.bind(tile);
    const auto take = [&](int k, BlockRow<1>& row) {
        for (int i = 0; i < row_size; ++i)
            for (int j = 0; j < row_size; ++j) {
                all(6 * k + i, 6 * k + j) += row.diagonal[i][j][0];
                if (k > 0 || ring) all(6 * k + i, 6 * ((k + count - 1) % count) + j) += row.before[i][j][0];
                if (k + 1 < count || ring) all(6 * k + i, 6 * ((k + 1) % count) + j) += row.after[i][j][0];
            }
    };
    with_energy_law(rod.group.law(), [&]<class L>(L) {
        ElasticRows<L, 1>(ends_of(rod.group), walls).stiffness(tile, rod.at.carried.data(), Step{}, count - 1, take);
    });
    return all;
}

/// Central differences of the loads, with the strains following.
Eigen::MatrixXd matrix_of_differences(Shaken& rod) {
    const int count = rod.rows();
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(6 * count, 6 * count);
    for (int k = 0; k < count; ++k)
        for (int j = 0; j < row_size && rod.has(k, j); ++j) {
            const double h = j < 3 ? 1e-5 * rod.group.element[0].rest_length : 1e-5;
            const auto moved = [&](double s) {
                Moved to = rod.at;
                Slot<1>& slot = to.state[to_index(k)];
                const Vec3<P> by{P(j % 3 == 0 ? s : 0), P(j % 3 == 1 ? s : 0), P(j % 3 == 2 ? s : 0)};
                if (j < 3) slot.position += by;
                else slot.director = rotation(by) * slot.director;
                rod.carry(to);
                return loads_of(rod.group, to);
            };
            const auto up = moved(h), down = moved(-h);
            for (int r = 0; r < count; ++r) {
                const SlotLoad<1>&more = up[to_index(r)], &less = down[to_index(r)];
                const Vec3d f = (-0.5 / h) * (lane(more.force, 0) - lane(less.force, 0)),
                            c = (-0.5 / h) * (lane(more.couple, 0) - lane(less.couple, 0));
                const double rows[row_size] = {f.x, f.y, f.z, c.x, c.y, c.z};
                for (int i = 0; i < row_size && rod.has(r, i); ++i) all(6 * r + i, 6 * k + j) = rows[i];
            }
        }
    return all;
}

/// Largest difference, over the largest entry of its kind: force or couple, by displacement or turn.
Eigen::Matrix2d errors_of_rows(Shaken rod) {
    const Eigen::MatrixXd rows = matrix_of_rows(rod), differences = matrix_of_differences(rod);
    Eigen::Matrix2d scale = Eigen::Matrix2d::Zero(), error = scale;
    for (int r = 0; r < rows.rows(); ++r)
        for (int c = 0; c < rows.cols(); ++c) {
            if (!rod.has(r / 6, r % 6) || !rod.has(c / 6, c % 6)) continue;
            const int a = r % 6 >= 3, b = c % 6 >= 3;
            scale(a, b) = std::max(scale(a, b), std::abs(differences(r, c)));
            error(a, b) = std::max(error(a, b), std::abs(differences(r, c) - rows(r, c)));
        }
    return error.cwiseQuotient(scale);
}

/// What is left out goes with the strains of bending: the pull of bending on elements, and terms of second order in the
/// turns between elements.
TEST(ElasticRows, AreTheSlopesOfTheLoads) {
    for (const Law law : test::energy_laws())
        for (const bool ring : {false, true})
            for (const double turn : {0.1, 0.01, 1e-3}) {
                RodSpec spec = test::simple_rod(8);
                spec.material.law = law;
                if (ring) spec.shape.closed = true;
                else spec.start = EndKind::clamped;
                for (unsigned seed = 1; seed <= 5; ++seed) {
                    const Eigen::Matrix2d error = errors_of_rows({spec, turn, seed});
                    const std::string which = test::name_of(law) + (ring ? ", ring" : "") + ", turns of " +
                                              std::to_string(turn) + ", seed " + std::to_string(seed);
                    EXPECT_LT(error.maxCoeff(), 0.5 * turn) << which;
                    if (law != Law::linear) continue;
                    EXPECT_LT(std::max({error(0, 0), error(0, 1), error(1, 0)}), 1e-8) << which;
                    EXPECT_LT(error(1, 1), 0.02 * turn) << which;
                }
            }
}

} // namespace
} // namespace skein
