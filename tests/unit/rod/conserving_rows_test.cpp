// Loads of a step whose work is the change of energy, their momenta and their stiffness, and steps of free rods.
#include "diagnostics/observables.hpp"
#include "implicit/conserving_pass.hpp"
#include "support/rods_for_tests.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace skein {
namespace {

using P = Pack<1>;
using V = Vec3<P>;
using Q = Quaternion<P>;
using State = std::vector<Slot<1>>;

struct Case {
    std::string name;
    RodSpec spec;
};

std::vector<Case> cases() {
    std::vector<Case> all = {{"straight", test::simple_rod()}, {"crooked", test::crooked_rod()}};
    all.push_back({"clamped", test::crooked_rod()});
    all.back().spec.start = all.back().spec.end = EndKind::clamped;
    all.push_back({"one element", test::simple_rod(1)});
    all.back().spec.start = EndKind::clamped;
    all.push_back({"weighted ends", test::simple_rod(8)});
    all.back().spec.start = EndKind::clamped;
    all.back().spec.shape.end_weights = EndWeights::gregory;
    all.push_back({"ring", test::simple_rod(9)});
    all.back().spec.shape.closed = true;
    std::vector<Case> of_all_laws;
    for (const Law law : test::energy_laws())
        for (Case c : all) {
            c.spec.material.law = law;
            c.name += ", " + test::name_of(law);
            of_all_laws.push_back(std::move(c));
        }
    return of_all_laws;
}

/// A step from one random state to another, with the loads of the laws of a group.
struct Stepped {
    Stepped(const RodSpec& spec, double shift, double turn, unsigned seed)
        : group(spec, 0, 0, ""), start(test::shaken_state(group, shift * group.element[0].rest_length, turn, 0, seed)),
          end(start) {
        const State other = test::shaken_state(group, shift * group.element[0].rest_length, turn, 0, seed + 1000);
        for (std::size_t k = 0; k < end.size(); ++k) {
            end[k].position = other[k].position;
            if (k < group.element.size()) end[k].director = other[k].director;
        }
        close();
        carry();
    }

    void close() {
        if (!group.closed()) return;
        close_ring(test::tile_of(group, start));
        close_ring(test::tile_of(group, end));
    }
    std::size_t nodes() const { return to_index(group.nodes()); }
    std::size_t elements() const { return group.element.size(); }

    /// Carries the strains of the present step.
    void carry() {
        carried.assign(elements(), V{P(0.0), P(0.0), P(1.0)});
        with_rows([&](auto& rows, auto& work) {
            loads_of(rows, work);
            for (std::size_t k = 0; k < elements(); ++k) carried[k] = work.element[k].strain;
        });
    }
    template <class F> void with_rows(F&& f) {
        const StepWalls<1> walls(group, std::make_shared<EndWalls<1>>());
        with_energy_law(group.law(), [&]<class L>(L) {
            ConservingRows<L, 1> rows(ends_of(group), walls);
            typename ConservingRows<L, 1>::Work work;
            f(rows, work);
        });
    }
    /// Forces on nodes and couples on elements, lab.
    template <class Rows, class Work> void loads_of(Rows& rows, Work& work) {
        const RodTile<1> tile = test::tile_of(group, end);
        std::vector<V> displacement, by_element(end.size());
        std::vector<Q> director;
        std::vector<SlotLoad<1>> load(end.size());
        for (std::size_t k = 0; k < end.size(); ++k) {
            displacement.push_back(P(0.5) * (end[k].position - start[k].position));
            director.push_back(end[k].director);
        }
        rows.begin(tile, start.data(), Step{}, work);
        rows.loads(tile, displacement.data(), director.data(), carried.data(), load.data(), by_element.data(), work);
        if (group.closed()) load[0].force += load.back().force;
        force.clear();
        couple.clear();
        for (std::size_t k = 0; k < nodes(); ++k) force.push_back(lane(load[k].force, 0));
        for (std::size_t k = 0; k < elements(); ++k) couple.push_back(lane(by_element[k], 0));
    }
    void compute() {
        with_rows([&](auto& rows, auto& work) { loads_of(rows, work); });
    }
    Vec3d moved(std::size_t k) const { return lane(end[k].position, 0) - lane(start[k].position, 0); }
    Vec3d mean(std::size_t k) const { return 0.5 * (lane(end[k].position, 0) + lane(start[k].position, 0)); }
    /// Cayley vector of an element, lab.
    Vec3d turned(std::size_t k) const {
        const Quaterniond by = lane(end[k].director, 0) * inverse(lane(start[k].director, 0));
        return transpose_times(lane(start[k].director, 0), (2 / by.w) * by.v);
    }

    RodGroup group;
    State start, end;
    std::vector<V> carried;
    std::vector<Vec3d> force, couple;
};

TEST(ConservingRows, DoTheWorkThatTheEnergyChangesBy) {
    for (const Case& c : cases())
        for (const double turn : {1e-4, 0.05, 0.3})
            for (unsigned seed = 1; seed <= 5; ++seed) {
                Stepped step(c.spec, 0.2 * turn, turn, seed);
                step.compute();
                double work = 0, scale = 0;
                for (std::size_t k = 0; k < step.nodes(); ++k) {
                    work += dot(step.force[k], step.moved(k));
                    scale += norm(step.force[k]) * norm(step.moved(k));
                }
                for (std::size_t k = 0; k < step.elements(); ++k) {
                    work += dot(step.couple[k], step.turned(k));
                    scale += norm(step.couple[k]) * norm(step.turned(k));
                }
                const double before = rod_energy(step.group, step.start).elastic(),
                             after = rod_energy(step.group, step.end).elastic();
                EXPECT_GT(scale, 1e-3 * before) << c.name;
                // places are rounded at 1e-16 of the length, strains at 1e-15
                EXPECT_NEAR(work, before - after, 1e-12 * scale + 1e-15 / turn * scale)
                    << c.name << ", turns of " << turn;
            }
}

TEST(ConservingRows, KeepMomenta) {
    for (const Case& c : cases()) {
        if (c.spec.start != EndKind::free) continue;
        for (unsigned seed = 1; seed <= 5; ++seed) {
            Stepped step(c.spec, 0.06, 0.3, seed);
            step.compute();
            Vec3d force{0, 0, 0}, couple{0, 0, 0};
            double force_scale = 0, couple_scale = 0;
            for (std::size_t k = 0; k < step.nodes(); ++k) {
                force += step.force[k];
                couple += cross(step.mean(k), step.force[k]);
                force_scale += norm(step.force[k]);
                couple_scale += norm(step.mean(k)) * norm(step.force[k]);
            }
            for (const Vec3d& one : step.couple) {
                couple += one;
                couple_scale += norm(one);
            }
            EXPECT_LT(norm(force), 1e-14 * force_scale) << c.name;
            EXPECT_LT(norm(couple), 1e-14 * couple_scale) << c.name;
        }
    }
}

/// Stiffness at a step, with a column for each unknown: a displacement at the middle, or half a turn at the end.
Eigen::MatrixXd matrix_of_rows(Stepped& step) {
    const int count = step.group.nodes();
    const bool ring = step.group.closed();
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(6 * count, 6 * count);
    step.with_rows([&](auto& rows, auto& work) {
        step.loads_of(rows, work);
        const auto take = [&](int k, BlockRow<1>& row) {
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) {
                    all(6 * k + i, 6 * k + j) += row.diagonal[i][j][0];
                    if (k > 0 || ring) all(6 * k + i, 6 * ((k + count - 1) % count) + j) += row.before[i][j][0];
                    if (k + 1 < count || ring) all(6 * k + i, 6 * ((k + 1) % count) + j) += row.after[i][j][0];
                }
        };
        rows.stiffness(test::tile_of(step.group, step.end), step.carried.data(), count - 1, work, take);
    });
    return all;
}

/// Central differences of the loads, with the strains following.
Eigen::MatrixXd matrix_of_differences(const Stepped& step) {
    const int count = step.group.nodes(), elements = step.group.elements();
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(6 * count, 6 * count);
    for (int k = 0; k < count; ++k)
        for (int j = 0; j < (k < elements ? row_size : 3); ++j) {
            const double h = j < 3 ? 1e-5 * step.group.element[0].rest_length : 1e-5;
            const auto moved = [&](double s) {
                Stepped to = step;
                Slot<1>& slot = to.end[to_index(k)];
                const Vec3d twice{j % 3 == 0 ? 2 * s : 0, j % 3 == 1 ? 2 * s : 0, j % 3 == 2 ? 2 * s : 0};
                const V by = broadcast<1>(twice);
                if (j < 3) slot.position += by;
                else slot.director = rotation(slot.director * by) * slot.director;
                to.close();
                to.carry();
                to.compute();
                return to;
            };
            const Stepped up = moved(h), down = moved(-h);
            for (int r = 0; r < count; ++r) {
                const Vec3d f = (-0.5 / h) * (nth(up.force, r) - nth(down.force, r)),
                            c = r < elements ? (-0.5 / h) * (nth(up.couple, r) - nth(down.couple, r)) : Vec3d{0, 0, 0};
                const double rows[row_size] = {f.x, f.y, f.z, c.x, c.y, c.z};
                for (int i = 0; i < row_size; ++i) all(6 * r + i, 6 * k + j) = rows[i];
            }
        }
    return all;
}

/// Largest difference, over the largest entry of its kind: force or couple, by displacement or turn.
double error_of_rows(Stepped step) {
    const Eigen::MatrixXd rows = matrix_of_rows(step), differences = matrix_of_differences(step);
    Eigen::Matrix2d scale = Eigen::Matrix2d::Zero(), error = scale;
    const auto has = [&](Eigen::Index i) { return i % 6 < 3 || i / 6 < step.group.elements(); };
    for (Eigen::Index r = 0; r < rows.rows(); ++r)
        for (Eigen::Index c = 0; c < rows.cols(); ++c) {
            if (!has(r) || !has(c)) continue;
            const int a = r % 6 >= 3, b = c % 6 >= 3;
            scale(a, b) = std::max(scale(a, b), std::abs(differences(r, c)));
            error(a, b) = std::max(error(a, b), std::abs(differences(r, c) - rows(r, c)));
        }
    return error.cwiseQuotient(scale).maxCoeff();
}

/// What is left out goes with the turns between elements, in a step that turns elements by large angles, too.
TEST(ConservingRows, HaveTheSlopesOfTheLoads) {
    for (const Case& c : cases())
        for (const double turn : {0.1, 0.01, 1e-3})
            for (unsigned seed = 1; seed <= 3; ++seed)
                EXPECT_LT(error_of_rows(Stepped(c.spec, 0.02 * turn, turn, seed)), turn)
                    << c.name << ", turns of " << turn;
}

/// A free rod, or a body, on its way by steps that do not resolve its fast motion.
struct Flight {
    explicit Flight(const RodSpec& spec, double dt) : group(spec, 0, 0, ""), h(0.5 * dt) {
        state.resize(to_index(group.slots()));
        group.start_state(0, state);
        with_energy_law(group.law(), [&]<class L>(L) {
            pass = std::make_unique<ConservingPass<L, 1>>(
                ImplicitParts<1>{group, group.law(), {}, std::make_shared<EndWalls<1>>(), {}, {}, true});
        });
        pass->expect(1);
        pass->bind(tile());
        load.resize(state.size());
    }
    RodTile<1> tile() { return test::tile_of(group, state); }
    void step() {
        const double begin = static_cast<double>(2 * done) * h;
        const Step one{.index = ++done, .dt = 2 * h, .drift = h, .kick = h, .time = begin + h, .begin = begin};
        pass->prepare(std::span<const Step>(&one, 1));
        pass->run(tile(), load.data(), one);
    }
    double energy() const {
        const RodEnergy u = rod_energy(group, state);
        return u.translation + u.rotation + u.elastic();
    }

    RodGroup group;
    double h;
    std::int64_t done = 0;
    State state;
    std::unique_ptr<TilePass<1>> pass;
    std::vector<SlotLoad<1>> load;
};

RodSpec tumbling(RodSpec spec) {
    spec.shape.rest_curvature = {3, 1, 2};
    spec.shape.start_curvature = Vec3d{2, 0.5, 0};
    spec.shape.angular_velocity = {3, 5, 1};
    spec.shape.velocity = {0.3, 0.2, 0.1};
    return spec;
}

/// The midpoint rule gains 1e-3 of the energy in the first of these rods, and loses the second.
TEST(ConservingPass, KeepsTheEnergyAndMomentaOfFreeRods) {
    for (const Law law : test::energy_laws())
        for (const double times : {20.0, 60.0}) {
            RodSpec spec = tumbling(test::simple_rod(8));
            spec.material.law = law;
            spec.section.radius = 0.01;
            spec.shape.length = 0.5;
            Flight flight(spec, times * 3.2e-4); // of the largest explicit step
            const double energy = flight.energy();
            const test::Momenta momenta = test::momenta(flight.group, flight.state);
            for (int i = 0; i < 500; ++i) flight.step();
            const test::Momenta now = test::momenta(flight.group, flight.state);
            const std::string which = test::name_of(law) + ", " + std::to_string(times) + " times the explicit step";
            EXPECT_NEAR(flight.energy(), energy, 1e-10 * energy) << which;
            EXPECT_LT(norm(now.linear - momenta.linear), 1e-12 * norm(momenta.linear)) << which;
            EXPECT_LT(norm(now.angular - momenta.angular), 1e-9 * norm(momenta.angular)) << which;
        }
}

TEST(ConservingPass, KeepsTheEnergyAndMomentaOfTops) {
    RodSpec spec = test::crooked_body();
    spec.shape.angular_velocity = {3, 5, 1};
    Flight flight(spec, 0.1); // turns by 0.6 rad
    const double energy = flight.energy();
    const test::Momenta momenta = test::momenta(flight.group, flight.state);
    for (int i = 0; i < 1000; ++i) flight.step();
    EXPECT_NEAR(flight.energy(), energy, 1e-11 * energy);
    EXPECT_LT(norm(test::momenta(flight.group, flight.state).angular - momenta.angular), 1e-11 * norm(momenta.angular));
}

} // namespace
} // namespace skein
