// Block rows against dense solutions, and the stiffness of elastic rows against differences of the loads.
#include "implicit/elastic_rows.hpp"
#include "mechanics/drift.hpp"
#include "support/rods_for_tests.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>

namespace skein {
namespace {

using P = Pack<1>;

/// A row of the system as numbers.
struct Numbers { double diagonal[6][6], before[6][6], after[6][6], right[6]; };

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
        ElasticRows<L, 1>(ends_of(group), walls).loads(test::tile_of(group, m.state), m.carried.data(), Step{}, load.data());
    });
    if (group.closed()) load[0].force += load.back().force;
    return load;
}

/// Largest difference between rows and differences of loads, over the largest entry of the kind (force or couple, by
/// displacement or turn).
double worst(const RodSpec& spec, double turn, unsigned seed) {
    const RodGroup group(spec, 0, 0, "");
    const double dl = group.element[0].rest_length;
    Moved m{test::shaken_state(group, 1e-3 * dl, turn, 0, seed), {}};
    if (group.closed()) close_ring(test::tile_of(group, m.state));
    for (int k = 0; k < group.elements(); ++k)
        m.carried.push_back(element_strain<Across<1>>(test::tile_of(group, m.state), k));
    const int last = group.closed() ? group.elements() - 1 : group.elements(), count = last + 1;
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6 * count, 6 * count), differences = rows;
    EndWalls<1> walls;
    walls.bind(test::tile_of(group, m.state));
    with_energy_law(group.law(), [&]<class L>(L) {
        ElasticRows<L, 1>(ends_of(group), walls)
            .stiffness(test::tile_of(group, m.state), m.carried.data(), Step{}, last, [&](int k, BlockRow<1>& row) {
                for (int i = 0; i < 6; ++i)
                    for (int j = 0; j < 6; ++j) {
                        rows(6 * k + i, 6 * k + j) += row.diagonal[i][j][0];
                        if (k > 0 || group.closed()) rows(6 * k + i, 6 * ((k + count - 1) % count) + j) += row.before[i][j][0];
                        if (k < last || group.closed()) rows(6 * k + i, 6 * ((k + 1) % count) + j) += row.after[i][j][0];
                    }
            });
    });
    for (int k = 0; k < count; ++k)
        for (int j = 0; j < 6; ++j) {
            if (k == group.elements() && j >= 3) continue;
            const double h = j < 3 ? 1e-5 * dl : 1e-5;
            const auto moved = [&](double s) {
                Moved to = m;
                Slot<1>& slot = to.state[to_index(k)];
                const Vec3<P> by{P(j % 3 == 0 ? s : 0), P(j % 3 == 1 ? s : 0), P(j % 3 == 2 ? s : 0)};
                if (j < 3) slot.position += by;
                else slot.director = rotation(by) * slot.director;
                if (group.closed()) close_ring(test::tile_of(group, to.state));
                for (int e = 0; e < group.elements(); ++e)
                    to.carried[to_index(e)] = element_strain<Across<1>>(test::tile_of(group, to.state), e);
                return loads_of(group, to);
            };
            const auto up = moved(h), down = moved(-h);
            for (int r = 0; r < count; ++r) {
                const Vec3d f = (-0.5 / h) * (lane(up[to_index(r)].force, 0) - lane(down[to_index(r)].force, 0)),
                            c = (-0.5 / h) * (lane(up[to_index(r)].couple, 0) - lane(down[to_index(r)].couple, 0));
                const double all[6] = {f.x, f.y, f.z, c.x, c.y, c.z};
                for (int i = 0; i < 6; ++i)
                    if (!(r == group.elements() && i >= 3)) differences(6 * r + i, 6 * k + j) = all[i];
            }
        }
    double most = 0;
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) {
            double scale = 0, error = 0;
            for (int r = 0; r < 6 * count; ++r)
                for (int c = 0; c < 6 * count; ++c) {
                    if ((r % 6 >= 3) != (a == 1) || (c % 6 >= 3) != (b == 1)) continue;
                    if (r / 6 == group.elements() && a == 1) continue;
                    if (c / 6 == group.elements() && b == 1) continue;
                    scale = std::max(scale, std::abs(differences(r, c)));
                    error = std::max(error, std::abs(differences(r, c) - rows(r, c)));
                }
            std::printf("  kind %d%d error %.3g\n", a, b, error / scale);
            most = std::max(most, error / scale);
        }
    return most;
}

TEST(ElasticRows, AreTheSlopesOfTheLoads) {
    for (const Law law : test::energy_laws())
        for (const bool ring : {false, true})
            for (const double turn : {0.1, 0.01}) {
                RodSpec spec = test::simple_rod(8);
                spec.material.law = law;
                if (ring) spec.shape.closed = true;
                else spec.start = EndKind::clamped;
                std::printf("law %d ring %d turn %g: %.3g\n", (int)law, ring, turn, worst(spec, turn, 1));
            }
}

} // namespace
} // namespace skein
