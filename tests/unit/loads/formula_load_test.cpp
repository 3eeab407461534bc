// Loads as formulas: named loads written as such, ends, places, what is told at the start, and the limits of the step.
#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

namespace skein {
namespace {

FormulaScope scope_of(double duration = 4) {
    FormulaScope scope;
    scope.constants = {{"k", 3.0, "N/m^2"}, {"c", 0.7, "N s/m^2"}};
    scope.duration = duration;
    return scope;
}

FormulaLoad formula(FormulaLoad load, const FormulaScope& scope = scope_of()) {
    load.use(scope);
    return load;
}

using Loads = std::vector<SlotLoad<1>>;

/// What one load adds, at time t, to a shaken rod on which something acts already.
Loads applied(const Load& load, const RodGroup& group, double t) {
    std::vector<Slot<1>> state = test::shaken_state(group, 0.01, 0.4, 1);
    Loads loads(state.size());
    for (std::size_t i = 0; i < loads.size(); ++i) {
        set_lane(loads[i].force, 0, {0.1 * static_cast<double>(i), -0.3, 0.7});
        set_lane(loads[i].couple, 0, {0.2, 0.01 * static_cast<double>(i), -0.5});
    }
    const RodTile<1> tile = test::tile_of(group, state);
    const auto pass = make_pass<1>(load, group);
    pass->bind(tile);
    const Step step{.index = 1, .dt = 1, .drift = 1, .time = t, .slot = 3};
    pass->prepare(std::span(&step, 1));
    pass->run(tile, loads.data(), step);
    return loads;
}

double largest_difference(const Loads& a, const Loads& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, norm(lane(a[i].force, 0) - lane(b[i].force, 0)) / (1 + norm(lane(a[i].force, 0))));
        largest =
            std::max(largest, norm(lane(a[i].couple, 0) - lane(b[i].couple, 0)) / (1 + norm(lane(a[i].couple, 0))));
    }
    return largest;
}

RodSpec magnetised(RodSpec spec) {
    spec.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
    return spec;
}

struct Twin {
    Load named;
    Load written;
    bool same_bits;
};

/// Named loads as formulas.
std::vector<Twin> twins() {
    const auto of = [](std::vector<std::string> force, FormulaPer per, FormulaAt at = FormulaAt::rod) {
        return FormulaLoad{.force = std::move(force), .per = per, .at = at};
    };
    const auto turning = [](std::vector<std::string> couple) {
        return FormulaLoad{.couple = std::move(couple), .per = FormulaPer::rod};
    };
    constexpr auto rod = FormulaPer::rod, length = FormulaPer::length;
    return {
        {Gravity{{0.3, 1, -9.81}}, of({"0.3", "1", "-9.81"}, FormulaPer::mass), true},
        {UniformForce{.force = {8, 0, -1}}, of({"8", "0", "-1"}, rod), true},
        {UniformForce{.force = {8, 0, -1}, .ramp = {2}}, of({"8*ramp(t, 2)", "0", "-1*ramp(t, 2)"}, rod), false},
        {UniformCouple{.couple = {1, 2, 3}}, turning({"1", "2", "3"}), true},
        {UniformCouple{.couple = {1, 2, 3}, .ramp = {5}}, turning({"1*ramp(t, 5)", "2*ramp(t, 5)", "3*ramp(t, 5)"}),
         false},
        {EndForce{.start = {0, 4, 3}}, of({"0", "4", "3"}, length, FormulaAt::start), true},
        {EndForce{.end = {-4, 0, 0.5}}, of({"-4", "0", "0.5"}, length, FormulaAt::end), true},
        {EndForce{.end = {-4, 0, 0.5}, .ramp = {2}},
         of({"-4*ramp(t, 2)", "0", "0.5*ramp(t, 2)"}, length, FormulaAt::end), true},
        {SinusoidalEndForce{.end = 3, .period = 4},
         of({"3*cos(2*pi/4*t)", "3*sin(2*pi/4*t)", "0"}, length, FormulaAt::end), false},
        {MagneticField{.constant = {0, 8e-4, 0.01}}, MagneticFormula{{"0", "8e-4", "0.01"}}, true},
        {MagneticField{.constant = {0, 8e-4, 0}, .rotating = 0.08, .period = 72, .ramp = {10}},
         MagneticFormula{{"ramp(t, 10)*0.08*sin(2*pi/72*t)", "8e-4*ramp(t, 10)", "ramp(t, 10)*0.08*cos(2*pi/72*t)"}},
         false},
        {MuscleWave{
             .amplitude = 0.3, .period = 2, .wavelength = 0.8, .phase = 0.4, .direction = {0, 0.6, 0.8}, .ramp = {1}},
         MuscleFormula{{"0", "0.6*ramp(t, 1)*0.3*sin(pi*t - 2*pi*s/0.8 + 0.4)",
                        "0.8*ramp(t, 1)*0.3*sin(pi*t - 2*pi*s/0.8 + 0.4)"},
                       LoadFrame::lab},
         false},
        {MuscleWave{
             .amplitude = 0.3, .period = 2, .wavelength = 0.8, .direction = {0, 0.6, 0.8}, .frame = LoadFrame::body},
         MuscleFormula{{"0", "0.18*sin(pi*t - 2*pi*s/0.8)", "0.24*sin(pi*t - 2*pi*s/0.8)"}}, false},
    };
}

Load read(Load load) {
    load.use(scope_of());
    return load;
}

RodSpec clamped() {
    RodSpec rod = magnetised(test::crooked_rod());
    rod.start = rod.end = EndKind::clamped;
    return rod;
}
RodSpec ring() {
    RodSpec rod = magnetised(test::simple_rod(12));
    rod.shape.closed = true;
    return rod;
}

TEST(FormulaLoads, AreTheNamedOnes) {
    const std::vector<Twin> all = twins();
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const RodSpec& spec :
             {magnetised(test::simple_rod(40)), magnetised(test::crooked_rod()), clamped(), ring()})
            for (const double t : {0.0, 0.7, 3.3}) {
                if (spec.shape.closed && (all[i].named.get_if<EndForce>() || all[i].named.get_if<SinusoidalEndForce>()))
                    continue;
                const RodGroup group(spec, 0, 0, "");
                const Loads named = applied(all[i].named, group, t), written = applied(read(all[i].written), group, t);
                EXPECT_LT(largest_difference(named, written), 1e-13) << i << " at " << t;
                const bool same = std::memcmp(named.data(), written.data(), named.size() * sizeof named[0]) == 0;
                EXPECT_TRUE(same || !all[i].same_bits) << i << " at " << t;
            }
}

TEST(FormulaLoads, KnowPlacesVelocitiesAndTables) {
    FormulaScope scope = scope_of();
    scope.tables.push_back({.name = "gust", .at = {0, 2}, .value = {1, 5}, .unit = "m/s"});
    const RodGroup group(test::crooked_rod(), 0, 0, "");
    const auto state = test::shaken_state(group, 0.01, 0.4, 1);
    const FormulaLoad wind = formula({.force = {"c*(gust(t) - vx)", "-k*(y - Y)", "k*s*s/L"},
                                      .couple = {"1*x", "1*vy*s", "0"},
                                      .frame = LoadFrame::body},
                                     scope);
    const Loads loads = applied(wind, group, 0.5);
    std::vector<Slot<1>> start(state.size());
    group.start_state(0, start);
    double s = 0;
    for (std::size_t i = 0; i < loads.size(); ++i) {
        const Vec3d x = lane(state[i].position, 0), v = lane(state[i].velocity, 0);
        const double w = group.node_length[i], l = group.spec().shape.length;
        const Vec3d expected = Vec3d{0.1 * static_cast<double>(i), -0.3, 0.7} +
                               w * Vec3d{0.7 * (2 - v.x), -3 * (x.y - lane(start[i].position, 0).y), 3 * s * s / l};
        EXPECT_LT(norm(lane(loads[i].force, 0) - expected), 1e-13);
        if (i + 1 == loads.size()) break;
        const double length = group.element[i].rest_length;
        const Vec3d middle = 0.5 * (x + lane(state[i + 1].position, 0)),
                    rate = 0.5 * (v + lane(state[i + 1].velocity, 0));
        const Vec3d couple =
            Vec3d{0.2, 0.01 * static_cast<double>(i), -0.5} + length * Vec3d{middle.x, rate.y * (s + 0.5 * length), 0};
        EXPECT_LT(norm(lane(loads[i].couple, 0) - couple), 1e-13);
        s += length;
    }
}

/// The same everywhere, of time alone, of place alone, and of all, at each step of a batch; on all of a rod and at its
/// ends, where no other node or element feels anything, not even in the sign of a zero.
class FormulaLoadsOf : public testing::TestWithParam<int> {};
TEST_P(FormulaLoadsOf, ManyPlacesAreOfTheirPlaceAndTheirStep) {
    struct Case {
        std::vector<std::string> texts;
        std::function<Vec3d(double t, double s, const Vec3d& x)> value;
    };
    const Case cases[] = {{{"0.3", "-2", "5"},
                           [](double, double, const Vec3d&) {
                               return Vec3d{0.3, -2, 5};
                           }},
                          {{"3*t", "0", "1*cos(2*t)"},
                           [](double t, double, const Vec3d&) {
                               return Vec3d{3 * t, 0, std::cos(2 * t)};
                           }},
                          {{"3*s", "0", "1*exp(-(2*s))"},
                           [](double, double s, const Vec3d&) {
                               return Vec3d{3 * s, 0, std::exp(-2 * s)};
                           }},
                          {{"3*s*t", "4", "2*t"},
                           [](double t, double s, const Vec3d&) {
                               return Vec3d{3 * s * t, 4, 2 * t};
                           }},
                          {{"2*x*t + 3*s", "1*s", "7"}, [](double t, double s, const Vec3d& x) {
                               return Vec3d{2 * x.x * t + 3 * s, s, 7};
                           }}};
    const RodGroup group(GetParam() == 0 ? test::crooked_rod() : test::simple_rod(GetParam()), 0, 0, "");
    std::vector<Slot<1>> state = test::shaken_state(group, 0.01, 0.4, 1);
    const RodTile<1> tile = test::tile_of(group, state);
    const double rod_length = group.spec().shape.length;
    const int n = group.elements();
    const std::vector<Step> steps = {{.index = 1, .time = 0.2, .slot = 0},
                                     {.index = 2, .time = 1.1, .slot = 1},
                                     {.index = 3, .time = 2.9, .slot = 2}};
    for (const Case& c : cases)
        for (const FormulaAt at : {FormulaAt::rod, FormulaAt::start, FormulaAt::end})
            for (const FormulaPer per : {FormulaPer::length, FormulaPer::mass, FormulaPer::rod}) {
                const auto pass = make_pass<1>(
                    formula({.force = c.texts, .couple = c.texts, .per = per, .at = at, .frame = LoadFrame::body}),
                    group);
                pass->bind(tile);
                pass->prepare(steps);
                for (const Step& step : {steps[2], steps[0], steps[1]}) {
                    Loads loads(state.size());
                    for (SlotLoad<1>& load : loads) load.force = load.couple = nothing<1>();
                    pass->run(tile, loads.data(), step);
                    double s = 0;
                    for (int i = 0; i <= n; ++i) {
                        const auto k = static_cast<std::size_t>(i);
                        const auto expect = [&](const Vec3<Pack<1>>& got, double weight, const Vec3d& value) {
                            EXPECT_LT(norm(lane(got, 0) - weight * value), 1e-13 * (1 + norm(value)))
                                << c.texts[0] << " at " << i << ", " << step.time;
                            if (weight == 0) {
                                EXPECT_TRUE(std::signbit(got.x[0]) && std::signbit(got.y[0]) && std::signbit(got.z[0]));
                            }
                        };
                        const Vec3d x = lane(state[k].position, 0);
                        const auto share = [&](double length, double mass, int last) {
                            if (at != FormulaAt::rod) return i == (at == FormulaAt::start ? 0 : last) ? 1.0 : 0.0;
                            return per == FormulaPer::length ? length
                                   : per == FormulaPer::mass ? mass
                                                             : length / rod_length;
                        };
                        expect(loads[k].force, share(group.node_length[k], group.node_mass[k], n),
                               c.value(step.time, s, x));
                        if (i == n) break;
                        const ElementConstants& element = group.element[k];
                        const double length = element.rest_length,
                                     mass = group.spec().material.density * element.volume;
                        expect(loads[k].couple, share(length, mass, n - 1),
                               c.value(step.time, s + 0.5 * length, 0.5 * (x + lane(state[k + 1].position, 0))));
                        s += length;
                    }
                }
            }
}

/// A crooked rod, and rods of whole strips and not.
INSTANTIATE_TEST_SUITE_P(Elements, FormulaLoadsOf, testing::Values(0, strip<1>, 2 * strip<1> + 37));

TEST(FormulaLoads, SayWhereTheyAreNotFinite) {
    RodSpec spec = test::simple_rod(8);
    spec.placement = {.kind = PlacementKind::line, .counts = {4}, .spacing = {0.5}};
    const RodGroup group(spec, 0, 0, "");
    const auto fault = [&](std::vector<std::string> force, double duration = 4) {
        return formula({.force = std::move(force)}, scope_of(duration)).fault_at_start(group);
    };
    EXPECT_EQ(fault({"0", "1", "2*x"}), "");
    EXPECT_EQ(fault({"0", "1/(z - 0.25)", "0"}),
              "'force': \"1/(z - 0.25)\" divides by 0 at t = 0 s at node 2 of rod 0 of 'rod', "
              "where x, y, z = 0, 0, 0.25 m and s = 0.25 m");
    EXPECT_EQ(fault({"0", "0", "sqrt(0.9 - x)"}),
              "'force': \"sqrt(0.9 - x)\" is the root of a negative number at t = 0 s at node "
              "0 of rod 2 of 'rod', where x, y, z = 1, 0, 0 m and s = 0 m");
    EXPECT_NE(fault({"0", "0", "1/(s + 0.3 - 0.5 - 0.05)"}).find("divides by 0 at t = 0 s at node 2"),
              std::string::npos)
        << "but for round-off";
    EXPECT_EQ(fault({"if(x > 0, 1/x, 0)", "0", "0"}), "") << "what is not chosen does not count";
    EXPECT_NE(fault({"1/(t - 4)", "0", "0"}).find("divides by 0 at t = 4 s"), std::string::npos);
    EXPECT_EQ(fault({"1/(t - 4)", "0", "0"}, 3), "");
}

/// Against the largest eigenvalue of the one matrix that there is.
TEST(FormulaLoads, BoundTheirStiffnessAndTheirRate) {
    const RodGroup group(test::simple_rod(8), 0, 0, "");
    const double per_mass = group.node_length[3] / group.node_mass[3];
    const auto spring = formula({.force = {"-k*x", "-2*k*y", "0"}});
    EXPECT_NEAR(spring.largest_stiffness(group).value, 2 * 3 * per_mass, 1e-9);
    EXPECT_EQ(spring.largest_rate(group).value, 0);
    const auto drag = formula({.force = {"-c*vx", "0", "-c*(vz - vx)*exp(-(3*s))"}});
    EXPECT_NEAR(drag.largest_rate(group).value, 2 * 0.7 * per_mass, 1e-9);
    EXPECT_EQ(drag.largest_rate(group).element, 0);
    EXPECT_EQ(drag.largest_stiffness(group).value, 0);
    const auto accelerated = formula({.force = {"-100*x", "0", "0"}, .per = FormulaPer::mass});
    EXPECT_NEAR(accelerated.largest_stiffness(group).value, 100, 1e-9);
    const auto at_end = formula({.force = {"0", "-5*y", "0"}, .at = FormulaAt::end});
    EXPECT_NEAR(at_end.largest_stiffness(group).value, 5 / group.node_mass[8], 1e-9);
    EXPECT_EQ(at_end.largest_stiffness(group).element, 7);
    const auto later = formula({.force = {"-k*x*t/4", "0", "0"}});
    EXPECT_NEAR(later.largest_stiffness(group).value, 3 * per_mass, 1e-9) << "largest at the end of the run";
}

/// U = -sum V_k m_k . Q_k B(y_k, t) and its differences; m along the rod as a scene says, or as a formula.
class MagneticFormulas : public testing::TestWithParam<bool> {};

TEST_P(MagneticFormulas, ExertMinusTheGradientOfTheirEnergy) {
    const bool by_formula = GetParam();
    const RodGroup group(by_formula ? test::crooked_rod() : magnetised(test::crooked_rod()), 0, 0, "");
    MagneticFormula load{{"0.3*x*z + 0.1*sin(2*pi*t)", "0.2*y*y - 0.1*x*s", "0.4*exp(-(2*x)^2)*cos(3*z) + 0.2*y"}};
    if (by_formula) load.magnetisation = {"2e3*s/L", "-1e3", "5e3*cos(2*pi*s/L)"};
    load.use(scope_of());
    const double t = 0.3;
    const auto field = [&](const Vec3d& x, double s) {
        return Vec3d{0.3 * x.x * x.z + 0.1 * std::sin(2 * M_PI * t), 0.2 * x.y * x.y - 0.1 * x.x * s,
                     0.4 * std::exp(-4 * x.x * x.x) * std::cos(3 * x.z) + 0.2 * x.y};
    };
    const auto energy = [&](const std::vector<Slot<1>>& state) {
        double u = 0, s = 0;
        for (std::size_t k = 0; k < group.element.size(); ++k) {
            const double share = (s + 0.5 * group.element[k].rest_length) / group.spec().shape.length;
            const Vec3d m = by_formula ? Vec3d{2e3 * share, -1e3, 5e3 * std::cos(2 * M_PI * share)}
                                       : 5e3 * (group.start_directors()[k] * group.magnetisation(0));
            const Vec3d y = 0.5 * (lane(state[k].position, 0) + lane(state[k + 1].position, 0));
            u -= group.element[k].volume *
                 dot(m, lane(state[k].director, 0) * field(y, s + 0.5 * group.element[k].rest_length));
            s += group.element[k].rest_length;
        }
        return u;
    };
    const std::vector<Slot<1>> state = test::shaken_state(group, 0.01, 0.4, 1);
    Loads loads(state.size(), SlotLoad<1>{});
    std::vector<Slot<1>> copy = state;
    const RodTile<1> tile = test::tile_of(group, copy);
    const auto pass = make_pass<1>(load, group);
    pass->bind(tile);
    const Step step{.index = 1, .dt = 1, .drift = 1, .time = t, .slot = 0};
    pass->prepare(std::span(&step, 1));
    pass->run(tile, loads.data(), step);
    const double h = 1e-5;
    const auto difference = [&](auto change) {
        std::vector<Slot<1>> up = state, down = state;
        change(up, h);
        change(down, -h);
        return (energy(up) - energy(down)) / (2 * h);
    };
    double largest_force = 0, largest_couple = 0;
    for (const SlotLoad<1>& l : loads) {
        largest_force = std::max(largest_force, norm(lane(l.force, 0)));
        largest_couple = std::max(largest_couple, norm(lane(l.couple, 0)));
    }
    ASSERT_GT(largest_force, 0);
    for (std::size_t i = 0; i < state.size(); ++i)
        for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
            const double slope = difference([&](std::vector<Slot<1>>& s, double d) {
                set_lane(s[i].position, 0, lane(s[i].position, 0) + d * axis);
            });
            EXPECT_NEAR(dot(lane(loads[i].force, 0), axis), -slope, 1e-8 * largest_force) << i;
            if (i + 1 == state.size()) continue;
            const double turn = difference([&](std::vector<Slot<1>>& s, double d) {
                set_lane(s[i].director, 0, rotation(d * axis) * lane(s[i].director, 0));
            });
            EXPECT_NEAR(dot(lane(loads[i].couple, 0), axis), -turn, 1e-8 * largest_couple) << i;
        }
}

INSTANTIATE_TEST_SUITE_P(Magnetisation, MagneticFormulas, testing::Bool());

} // namespace
} // namespace skein
