// Internal loads are the negative gradient of the energy, and conserve momentum.
#include "diagnostics/observables.hpp"
#include "mechanics/drift.hpp"
#include "mechanics/elastic.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

using test::crooked_rod;
using test::shaken_state;
using test::simple_rod;
using test::tile_of;

std::vector<SlotLoad<1>> internal_loads(const RodGroup& group, std::vector<Slot<1>>& state) {
    std::vector<SlotLoad<1>> load(state.size());
    if (group.closed()) close_ring(tile_of(group, state));
    with_energy_law(group.law(), [&]<class L>(L) {
        ElasticPass<L, 1>(ends_of(group)).run(tile_of(group, state), load.data(), Step{});
    });
    if (group.closed()) load[0].force += load.back().force;
    return load;
}

/// dU/ds of moving one degree of freedom by s, from five energies; error O(h^4).
template <class Move>
double derivative(const RodGroup& group, const std::vector<Slot<1>>& state, double h, Move&& move) {
    const auto energy = [&](double s) {
        std::vector<Slot<1>> moved = state;
        move(moved, s);
        if (group.closed()) close_ring(tile_of(group, moved));
        return rod_energy(group, moved).elastic();
    };
    return (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
}

double component(const Vec3d& a, int axis) { return axis == 0 ? a.x : axis == 1 ? a.y : a.z; }
Vec3d unit(int axis, double s) { return {axis == 0 ? s : 0, axis == 1 ? s : 0, axis == 2 ? s : 0}; }

struct Case {
    const char* name;
    RodSpec spec;
    double turn; ///< rad, rms of the random turns
};

std::vector<Case> cases() {
    std::vector<Case> all = {
        {"straight", simple_rod(), 0.2}, {"crooked", crooked_rod(), 0.2}, {"wild", crooked_rod(), 0.6}};
    all.push_back({"clamped", crooked_rod(), 0.2});
    all.back().spec.start = all.back().spec.end = EndKind::clamped;
    all.push_back({"clamped straight", simple_rod(2), 0.4});
    all.back().spec.start = EndKind::clamped;
    all.push_back({"weighted ends", simple_rod(8), 0.3});
    all.back().spec.start = EndKind::clamped;
    all.back().spec.shape.end_weights = EndWeights::gregory;
    RodSpec ring = simple_rod(9);
    ring.shape.closed = true;
    all.push_back({"ring", ring, 0.2});
    std::vector<Case> of_all_laws;
    for (const Law law : test::energy_laws())
        for (Case c : all) {
            c.spec.material.law = law;
            of_all_laws.push_back(std::move(c));
        }
    return of_all_laws;
}

TEST(Elastic, LoadsAreTheNegativeGradientOfTheEnergy) {
    for (const Case& c : cases())
        for (unsigned seed = 1; seed <= 10; ++seed) {
            const RodGroup group(c.spec, 0, 0, "");
            const double dl = group.element[0].rest_length;
            std::vector<Slot<1>> state = shaken_state(group, 0.08 * dl, c.turn, 0, seed);
            const auto load = internal_loads(group, state);
            double force_scale = 0, couple_scale = 0, force_error = 0, couple_error = 0;
            const std::size_t nodes = group.closed() ? state.size() - 1 : state.size();
            for (std::size_t k = 0; k < nodes; ++k)
                for (int axis = 0; axis < 3; ++axis) {
                    const double force = component(lane(load[k].force, 0), axis);
                    const double from_energy = -derivative(group, state, 1e-4 * dl, [&](auto& s, double d) {
                        set_lane(s[k].position, 0, lane(s[k].position, 0) + unit(axis, d));
                    });
                    force_scale = std::max(force_scale, std::abs(force));
                    force_error = std::max(force_error, std::abs(force - from_energy));
                    if (k + 1 == state.size()) continue;
                    const double couple = component(lane(load[k].couple, 0), axis);
                    const double couple_from_energy = -derivative(group, state, 1e-4, [&](auto& s, double d) {
                        set_lane(s[k].director, 0, rotation(unit(axis, d)) * lane(s[k].director, 0));
                    });
                    couple_scale = std::max(couple_scale, std::abs(couple));
                    couple_error = std::max(couple_error, std::abs(couple - couple_from_energy));
                }
            const std::string law = test::name_of(c.spec.material.law);
            EXPECT_LT(force_error, 1e-9 * force_scale) << c.name << ", " << law << ", seed " << seed;
            EXPECT_LT(couple_error, 1e-9 * couple_scale) << c.name << ", " << law << ", seed " << seed;
        }
}

TEST(Elastic, FreeRodsConserveMomentumAndAngularMomentum) {
    const RodGroup group(crooked_rod(), 0, 0, "");
    std::vector<Slot<1>> state = shaken_state(group, 0.01, 0.4, 0);
    const auto load = internal_loads(group, state);
    Vec3d force{0, 0, 0}, moment{0, 0, 0};
    double force_scale = 0, moment_scale = 0;
    for (std::size_t k = 0; k < state.size(); ++k) {
        const Vec3d f = lane(load[k].force, 0), arm = lane(state[k].position, 0);
        force += f;
        moment += cross(arm, f);
        if (k + 1 < state.size()) moment += transpose_times(lane(state[k].director, 0), lane(load[k].couple, 0));
        force_scale = std::max(force_scale, norm(f));
        moment_scale = std::max(moment_scale, norm(cross(arm, f)));
    }
    EXPECT_LT(norm(force), 1e-14 * force_scale);
    EXPECT_LT(norm(moment), 1e-13 * moment_scale);
}

TEST(Elastic, RestShapeCarriesNoLoad) {
    for (const Law law : test::energy_laws()) {
        RodSpec spec = crooked_rod();
        spec.material.law = law;
        spec.start = spec.end = EndKind::clamped;
        const RodGroup group(spec, 0, 0, "");
        std::vector<Slot<1>> state = shaken_state(group, 0, 0, 0);
        const auto load = internal_loads(group, state);
        for (const auto& l : load) {
            EXPECT_LT(norm(lane(l.force, 0)), 1e-11 * group.element[0].stiffness.z) << test::name_of(law);
            EXPECT_LT(norm(lane(l.couple, 0)), 1e-11 * group.element[0].bending.x * 8) << test::name_of(law);
        }
    }
}

} // namespace
} // namespace skein
