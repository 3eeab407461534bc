// What end weights do to the error in space of rods at rest under every kind of load. What no case may be worse by, and
// what is.
#include "loads/end_couple.hpp"
#include "loads/formula_load.hpp"
#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"
#include "support/axial_stretching.hpp"
#include "support/catenary.hpp"
#include "support/large_rotation.hpp"
#include "support/magnetised_elastica.hpp"
#include "support/timoshenko_cantilever.hpp"
#include "validation/end_weights.hpp"

namespace skein {
namespace {

using test::group_of;
constexpr double pi = std::numbers::pi;
constexpr test::TimoshenkoBeam beam{1, 0.05, 1, 1, 1.0 / 3};

Vec3d tip_of(const test::Statics& rod) { return lane(rod.state.back().position, 0); }
test::Statics at_rest(const RodGroup& group, std::vector<Load> loads) {
    test::Statics rod(group);
    rod.loads = std::move(loads);
    rod.rest();
    return rod;
}

/// Largest over the nodes, or of the last one, over the deflection of the tip.
double thick_cantilever(EndWeights weights, long n, bool line) {
    using namespace test::timoshenko_cantilever;
    const auto& thick = test::timoshenko_cantilever::beam;
    const RodGroup group = group_of(clamped_rod(thick, n), weights);
    const test::Statics rod = at_rest(group, {EndForce{.end = {force, 0, 0}}});
    double error = 0;
    for (std::size_t i = line ? 0 : rod.state.size() - 1; i < rod.state.size(); ++i) {
        const double s = 3 * static_cast<double>(i) / static_cast<double>(n);
        error = std::max(error, std::abs(lane(rod.state[i].position, 0).x - thick.deflection(force, s)));
    }
    return error / thick.deflection(force, 3);
}

/// Of the tip, over the length.
double large_rotation(EndWeights weights, long n, const test::large_rotation::TipLoad& load) {
    const RodGroup group = group_of(test::clamped_unit_rod(n, test::large_rotation::radius), weights);
    const test::Statics rod = at_rest(group, {EndForce{.end = test::large_rotation::bending * load.force}});
    return norm(tip_of(rod) - test::large_rotation::tip(Law::incompressible, load));
}

/// Small deflection of the tip under a load across, along x, which the beam makes `exact`.
double small_load(EndWeights weights, long n, Load load, double exact) {
    const RodGroup group = group_of(test::clamped_rod(beam, n), weights);
    return std::abs(tip_of(at_rest(group, {std::move(load)})).x / exact - 1);
}
/// w L^4/(8 E I) + w L^2/(2 alpha_c G A).
double under_weight(EndWeights weights, long n) {
    constexpr double g = 1e-6, w = g * beam.density * beam.area;
    return small_load(weights, n, Gravity{.acceleration = {g, 0, 0}},
                      w / (8 * beam.youngs * beam.second_moment) + w / (2 * beam.shearing));
}
/// A load per length that falls from w to 0 along the rod: w L^4/(30 E I) + w L^2/(6 alpha_c G A).
double under_formula(EndWeights weights, long n) {
    constexpr double w = 1e-8;
    FormulaLoad load{.force = {"1e-8*(1 - s)", "0", "0"}};
    load.use({.duration = 1});
    return small_load(weights, n, load, w / (30 * beam.youngs * beam.second_moment) + w / (6 * beam.shearing));
}
/// A guided end under a force to the side: F L^3/(12 E I) + F L/(alpha_c G A).
double guided(EndWeights weights, long n) {
    constexpr double f = 1e-8;
    RodSpec spec = test::clamped_rod(beam, n);
    spec.end = EndKind::clamped;
    spec.end_free = "x";
    const RodGroup group = group_of(spec, weights);
    const double exact = f / (12 * beam.youngs * beam.second_moment) + f / beam.shearing;
    return std::abs(tip_of(at_rest(group, {EndForce{.end = {f, 0, 0}}})).x / exact - 1);
}

/// Rolled up by a couple on its end, which the incompressible law makes a circular arc of the curvature m e^3/B, with
/// E A (1 - 1/e) = (3/2) e^2 m^2/B.
double rolled_up(EndWeights weights, long n, LoadFrame frame) {
    using namespace test::large_rotation;
    const RodGroup group = group_of(test::clamped_unit_rod(n, radius), weights);
    const double m = pi * bending; // half a turn
    const test::Statics rod = at_rest(group, {EndCouple{.end = {m, 0, 0}, .frame = frame}});
    double e = 1;
    for (int i = 0; i < 40; ++i) e = 1 / (1 - 1.5 * e * e * m * m / (bending * area));
    const double kappa = e * e * e * m / bending;
    return norm(tip_of(rod) - Vec3d{0, -(1 - std::cos(kappa)) * e / kappa, std::sin(kappa) * e / kappa});
}

/// Largest distance of a node, over the length.
double stretched(EndWeights weights, long n) {
    using namespace test::axial_stretching;
    const RodGroup group = group_of(test::clamped_unit_rod(n, radius), weights);
    const test::Statics rod = at_rest(group, {UniformForce{.force = {0, 0, load}}, EndForce{.end = {0, 0, end_load}}});
    double error = 0;
    for (std::size_t i = 0; i < rod.state.size(); ++i) {
        const double s = static_cast<double>(i) / static_cast<double>(n);
        error = std::max(error, std::abs(lane(rod.state[i].position, 0).z - place(Law::incompressible, s)));
    }
    return error;
}
/// The same of a chain between two pins.
double catenary(EndWeights weights, long n) {
    using namespace test::catenary;
    SceneSpec scene = test::catenary::scene(n);
    const double b = 0.25 * area * radius * radius;
    scene.rods[0].section.bending_stiffness = {2 * b, b}; // of a round rod nothing would resist a spin of all sections
    const RodGroup group = group_of(scene.rods[0], weights);
    const test::Statics rod = at_rest(group, {scene.loads[0].load});
    const auto exact = line(Law::incompressible, horizontal_tension(Law::incompressible), n);
    double error = 0;
    for (std::size_t i = 0; i < rod.state.size(); ++i) {
        const Vec3d x = lane(rod.state[i].position, 0);
        error = std::max(error, std::hypot(x.x - exact[i][0], x.z - exact[i][1]));
    }
    return error;
}

/// Of the tip, over its way.
double magnetised(EndWeights weights, long n, double bond) {
    const RodGroup group = group_of(test::magnetised_rod(bond, n), weights);
    const Vec3d tip = tip_of(at_rest(group, {MagneticField{.constant = test::magnetising_field}}));
    const test::MagnetisedTip exact = test::magnetised_tip(bond, test::magnetised_slenderness);
    return std::hypot(tip.x - exact.x, tip.z - exact.z) / std::hypot(exact.x, 1 - exact.z);
}

/// Turn of the last element, whose middle is at L - l/2, over that of the end: under a force F (s - s^2/2)/(E I), under
/// a couple m s/(E I) or, along the rod, m s/(G J).
double last_turn(EndWeights weights, long n, const Load& load, double Vec3d::*axis, double (*exact)(double s)) {
    const RodGroup group = group_of(test::clamped_rod(beam, n), weights);
    const test::Statics rod = at_rest(group, {load});
    const auto last = static_cast<std::size_t>(n - 1);
    const double turn = relative_rotation(lane(rod.state[last].director, 0), group.frame()).*axis;
    return std::abs(turn - exact(1 - 0.5 / static_cast<double>(n))) / exact(1);
}
constexpr double small = 1e-9;
double turn_under_force(EndWeights weights, long n) {
    return last_turn(weights, n, EndForce{.end = {small, 0, 0}}, &Vec3d::y,
                     [](double s) { return small * (s - 0.5 * s * s) / (beam.youngs * beam.second_moment); });
}
double turn_under_couple(EndWeights weights, long n) {
    return last_turn(weights, n, EndCouple{.end = {0, small, 0}}, &Vec3d::y,
                     [](double s) { return small * s / (beam.youngs * beam.second_moment); });
}
double twist_under_couple(EndWeights weights, long n) {
    return last_turn(weights, n, EndCouple{.end = {0, 0, small}}, &Vec3d::z,
                     [](double s) { return small * s / (2 * beam.shear * beam.second_moment); });
}

/// A rod that is curved at rest and has weights all the same, which scenes refuse: (B/2 D_w) (phi - D_w kappa0)^2.
RodGroup curved(RodSpec spec, const Vec3d& curvature, EndWeights weights) {
    spec.shape.start_curvature = curvature;
    RodGroup group = group_of(spec, weights);
    group.start_wall.rest_curvature = cell_weight(group, 0) * curvature;
    for (std::size_t k = 0; k < group.voronoi.size(); ++k)
        group.voronoi[k].rest_curvature = cell_weight(group, k + 1) * curvature;
    return group;
}
/// The bend of 45 degrees; of the tip, over the length.
double bend(EndWeights weights, long n) {
    using namespace test::large_rotation;
    const auto& load = test::large_rotation::bend;
    const RodGroup group = curved(test::clamped_unit_rod(n, radius), load.rest_curvature, weights);
    return norm(tip_of(at_rest(group, {EndForce{.end = bending * load.force}})) - tip(Law::incompressible, load));
}
/// A spring of one turn under a force on its tip, against the plain rod's limit, which is known to the fourth order.
class Spring {
public:
    explicit Spring(const Vec3d& force)
        : force_(force), exact_((1.0 / 3) * (4.0 * tip(EndWeights::plain, 80) - tip(EndWeights::plain, 40))) {}
    double operator()(EndWeights weights, long n) const { return norm(tip(weights, n) - exact_); }

private:
    Vec3d tip(EndWeights weights, long n) const {
        const RodGroup group = curved(test::clamped_unit_rod(n, 0.03), {4, 0, 5}, weights);
        return tip_of(at_rest(group, {EndForce{.end = test::large_rotation::bending * force_}}));
    }
    Vec3d force_, exact_;
};

TEST(EndWeights, LoseNoPlaceByMoreThanATenth) {
    test::ErrorTable table("end_weight_loads");
    const std::vector<test::WeightedCase> cases = {
        {"thick cantilever, line", [](EndWeights w, long n) { return thick_cantilever(w, n, true); }},
        {"thick cantilever, tip", [](EndWeights w, long n) { return thick_cantilever(w, n, false); }},
        {"cantilever under its weight", under_weight},
        {"guided end under a force", guided},
        {"large rotation", [](EndWeights w, long n) { return large_rotation(w, n, test::large_rotation::straight); }},
        {"larger rotation",
         [](EndWeights w, long n) {
             return large_rotation(w, n, {{0, 0, 0}, {10, 3, 0}});
         }},
        {"rolled up by a couple", [](EndWeights w, long n) { return rolled_up(w, n, LoadFrame::lab); }},
        {"rolled up by a follower couple", [](EndWeights w, long n) { return rolled_up(w, n, LoadFrame::body); }},
        {"catenary", catenary},
        {"magnetised, bond number 1", [](EndWeights w, long n) { return magnetised(w, n, 1); }},
        {"magnetised, bond number 10", [](EndWeights w, long n) { return magnetised(w, n, 10); }},
        {"turn of the last element under a force", turn_under_force},
        {"curved: bend of 45 degrees", bend}};
    for (const test::WeightedCase& c : cases) EXPECT_LE(test::compare_weights(table, c), 1.1) << c.name;
}

// Why they are not the default: plain errors that cancel, ends that a couple turns, and rods that are curved at rest.
TEST(EndWeights, LoseTheseCases) {
    test::ErrorTable table("end_weight_losses");
    const std::vector<test::WeightedCase> cases = {{"axial stretching", stretched},
                                                   {"cantilever under a load that falls to 0", under_formula},
                                                   {"turn of the last element under a couple", turn_under_couple},
                                                   {"twist of the last element under a couple", twist_under_couple},
                                                   {"curved: spring pulled", Spring({2, 0, 1})},
                                                   {"curved: spring pushed aside", Spring({0, 2, 0})}};
    for (const test::WeightedCase& c : cases) EXPECT_GE(test::compare_weights(table, c), 1.1) << c.name;
}

} // namespace
} // namespace skein
