// What end weights do to the error in space: statics by Newton's method and frequencies by inverse iteration, so that nothing else
// is in it. No case may be worse for them by more than a tenth.
#include "loads/gravity.hpp"
#include "support/euler_buckling.hpp"
#include "support/large_rotation.hpp"
#include "support/statics.hpp"
#include "support/timoshenko_cantilever.hpp"
#include "validation/study.hpp"

#include <functional>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
constexpr test::TimoshenkoBeam beam{1, 0.05, 1, 1, 1.0 / 3};

RodSpec weighted(RodSpec rod, EndWeights weights) {
    rod.shape.end_weights = weights;
    return rod;
}
RodGroup group_of(const RodSpec& rod) { return RodGroup(rod, 0, 0, ""); }

/// Largest over the nodes, or of the last one, over the deflection of the tip.
double thick_cantilever(EndWeights weights, long n, bool line) {
    using namespace test::timoshenko_cantilever;
    const RodGroup group = group_of(weighted(clamped_rod(test::timoshenko_cantilever::beam, n), weights));
    test::Statics rod(group);
    rod.loads = {EndForce{.end = {force, 0, 0}}};
    rod.rest();
    double error = 0;
    for (std::size_t i = line ? 0 : rod.state.size() - 1; i < rod.state.size(); ++i) {
        const double s = 3 * static_cast<double>(i) / static_cast<double>(n);
        error =
            std::max(error, std::abs(lane(rod.state[i].position, 0).x - test::timoshenko_cantilever::beam.deflection(force, s)));
    }
    return error / test::timoshenko_cantilever::beam.deflection(force, 3);
}

/// Of the tip, over the length.
double large_rotation(EndWeights weights, long n, const test::large_rotation::TipLoad& load) {
    RodSpec spec = weighted(test::clamped_unit_rod(n, test::large_rotation::radius), weights);
    spec.shape.rest_curvature = load.rest_curvature;
    const RodGroup group = group_of(spec);
    test::Statics rod(group);
    rod.loads = {EndForce{.end = test::large_rotation::bending * load.force}};
    rod.rest();
    return norm(lane(rod.state.back().position, 0) - test::large_rotation::tip(Law::incompressible, load));
}

/// Deflection of the tip under a small weight w per length: w L^4/(8 E I) + w L^2/(2 alpha_c G A).
double under_weight(EndWeights weights, long n) {
    const RodGroup group = group_of(weighted(test::clamped_rod(beam, n), weights));
    test::Statics rod(group);
    constexpr double g = 1e-6;
    rod.loads = {Gravity{.acceleration = {g, 0, 0}}};
    rod.rest();
    const double w = g * beam.density * beam.area, exact = w / (8 * beam.youngs * beam.second_moment) + w / (2 * beam.shearing);
    return std::abs(lane(rod.state.back().position, 0).x / exact - 1);
}

/// A spring of one turn, curved at rest and so plain: clamped and pulled, against the plain rod's limit, which is known to the
/// fourth order.
double spring(EndWeights weights, long n) {
    const auto tip = [](EndWeights kind, long elements) {
        RodSpec spec = weighted(test::clamped_unit_rod(elements, 0.03), kind);
        spec.shape.rest_curvature = {4, 0, 5};
        const RodGroup group = group_of(spec);
        test::Statics rod(group);
        rod.loads = {EndForce{.end = {2 * test::large_rotation::bending, 0, test::large_rotation::bending}}};
        rod.rest();
        return lane(rod.state.back().position, 0);
    };
    static const Vec3d exact = (1.0 / 3) * (4.0 * tip(EndWeights::plain, 120) - tip(EndWeights::plain, 60));
    return norm(tip(weights, n) - exact);
}

/// Rolled up by a couple on its end, which the incompressible law makes a circular arc of the curvature m e^3/B, with
/// E A (1 - 1/e) = (3/2) e^2 m^2/B.
double rolled_up(EndWeights weights, long n) {
    const RodGroup group = group_of(weighted(test::clamped_unit_rod(n, test::large_rotation::radius), weights));
    test::Statics rod(group);
    const double m = pi * test::large_rotation::bending; // a quarter turn and more: sideways
    rod.end_couple = {m, 0, 0};
    rod.rest();
    double e = 1;
    for (int i = 0; i < 40; ++i) e = 1 / (1 - 1.5 * e * e * m * m / (test::large_rotation::bending * test::large_rotation::area));
    const double kappa = e * e * e * m / test::large_rotation::bending;
    const Vec3d exact{0, -(1 - std::cos(kappa)) * e / kappa, std::sin(kappa) * e / kappa};
    return norm(lane(rod.state.back().position, 0) - exact);
}

/// Load at which the stiffness loses its sign, against the closed form.
double buckling(EndWeights weights, long n) {
    using namespace test::euler_buckling;
    RodSpec spec = weighted(test::clamped_unit_rod(n, radius), weights);
    spec.section.bending_stiffness = {bending, 2 * bending}; // two planes with one load would leave the determinant its sign
    const RodGroup group = group_of(spec);
    test::Statics rod(group);
    const double exact = critical_load(Law::incompressible);
    double low = 0.98 * exact, high = 1.02 * exact;
    for (int i = 0; i < 14; ++i) {
        const double load = 0.5 * (low + high);
        rod.loads = {EndForce{.end = {0, 0, -load}}};
        rod.rest();
        (rod.stability() > 0 ? low : high) = load;
    }
    return std::abs(low / exact - 1);
}

struct Held {
    const char* name;
    EndKind start, end;
    test::TimoshenkoBeam::Ends left_over;
};
constexpr Held clamped_free{"clamped-free", EndKind::clamped, EndKind::free, {}};
constexpr Held ends[] = {clamped_free,
                         {"free-free", EndKind::free, EndKind::free, {{0, 1}, {2, 3}}},
                         {"pinned-pinned", EndKind::pinned, EndKind::pinned, {{1, 3}, {0, 2}}},
                         {"clamped-pinned", EndKind::clamped, EndKind::pinned, {{2, 3}, {0, 2}}},
                         {"clamped-clamped", EndKind::clamped, EndKind::clamped, {{2, 3}, {0, 1}}},
                         {"pinned-free", EndKind::pinned, EndKind::free, {{1, 3}, {2, 3}}}};

RodGroup held(const Held& held, EndWeights weights, long n) {
    RodSpec spec = weighted(test::clamped_rod(beam, n), weights);
    spec.start = held.start, spec.end = held.end;
    return group_of(spec);
}
double bending_frequency(const Held& ends, std::size_t mode, EndWeights weights, long n) {
    const double exact = beam.frequencies<3>(ends.left_over)[mode];
    const RodGroup group = held(ends, weights, n);
    const auto across = [](bool turns, int axis) { return axis == (turns ? 1 : 0); };
    return std::abs(test::Statics(group).frequency_near(exact, across) / exact - 1);
}
/// Waves of speed c between a clamp and a free end.
double wave_frequency(bool torsion, int mode, EndWeights weights, long n) {
    const double speed = std::sqrt((torsion ? beam.shear : beam.youngs) / beam.density);
    const double exact = (mode + 0.5) * pi * speed;
    const RodGroup group = held(clamped_free, weights, n);
    const auto along = [&](bool turns, int axis) { return turns == torsion && axis == 2; };
    return std::abs(test::Statics(group).frequency_near(exact, along) / exact - 1);
}

struct Case {
    std::string name;
    std::function<double(EndWeights, long)> error;
};

std::vector<Case> cases() {
    std::vector<Case> all = {
        {"thick cantilever, line", [](EndWeights w, long n) { return thick_cantilever(w, n, true); }},
        {"thick cantilever, tip", [](EndWeights w, long n) { return thick_cantilever(w, n, false); }},
        {"cantilever under its weight", under_weight},
        {"large rotation, straight", [](EndWeights w, long n) { return large_rotation(w, n, test::large_rotation::straight); }},
        {"larger rotation, straight",
         [](EndWeights w, long n) {
             return large_rotation(w, n, {{0, 0, 0}, {10, 3, 0}});
         }},
        {"large rotation, bend", [](EndWeights w, long n) { return large_rotation(w, n, test::large_rotation::bend); }},
        {"helical spring", spring},
        {"rolled up by a couple", rolled_up},
        {"Euler load, clamped-free", buckling}};
    for (const Held& h : ends)
        for (std::size_t mode = 0; mode < 3; ++mode)
            all.push_back({"frequency " + std::to_string(mode) + ", " + h.name,
                           [&h, mode](EndWeights w, long n) { return bending_frequency(h, mode, w, n); }});
    for (const int mode : {0, 1, 2}) {
        for (const bool torsion : {false, true})
            all.push_back({(torsion ? "torsional wave " : "axial wave ") + std::to_string(mode),
                           [torsion, mode](EndWeights w, long n) { return wave_frequency(torsion, mode, w, n); }});
    }
    return all;
}

TEST(EndWeights, LoseNoCaseByMoreThanATenth) {
    test::ErrorTable table("end_weights");
    for (const Case& c : cases())
        for (const long n : {10, 20, 40}) {
            const double plain = c.error(EndWeights::plain, n), gregory = c.error(EndWeights::gregory, n);
            table.add(c.name + ", plain", n, 0, plain);
            table.add(c.name + ", gregory", n, 0, gregory);
            EXPECT_LE(gregory, 1.1 * plain) << c.name << ", n " << n;
        }
}

} // namespace
} // namespace skein
