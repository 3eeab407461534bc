// What end weights do to the error in space of rods that are held in any way: frequencies, buckling loads and waves. No
// case may be worse for them by more than a tenth.
#include "validation/end_weights.hpp"
#include "support/euler_buckling.hpp"
#include "support/timoshenko_beam.hpp"

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
constexpr test::TimoshenkoBeam beam{1, 0.05, 1, 1, 1.0 / 3};

using test::euler_buckling::Column;
constexpr Column pinned{"pinned column", "z", pi, pi* pi / 3.5160, 0.5};

/// Load at which the stiffness loses its sign, against the closed form.
double buckling(const Column& column, EndWeights weights, long n) {
    using namespace test::euler_buckling;
    RodSpec spec = test::clamped_unit_rod(n, radius);
    spec.section.bending_stiffness = {2 * bending,
                                      bending}; // two planes with one load would leave the determinant its sign
    spec.end_free = column.end_free;
    if (&column == &pinned) spec.start = spec.end = EndKind::pinned;
    else if (!spec.end_free.empty()) spec.end = EndKind::clamped;
    const RodGroup group = test::group_of(spec, weights);
    test::Statics rod(group);
    if (&column == &pinned) rod.hold_turn(0, 2);
    const double exact = critical_load(Law::incompressible, column);
    double low = 0.9 * exact, high = 1.1 * exact;
    for (int i = 0; i < 17; ++i) {
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
    const char* end_free = "";
};
constexpr Held clamped_free{"clamped-free", EndKind::clamped, EndKind::free, {}},
    sliding{"sliding", EndKind::clamped, EndKind::clamped, {}, "z"};
constexpr Held ends[] = {clamped_free,
                         {"free-free", EndKind::free, EndKind::free, {{0, 1}, {2, 3}}},
                         {"pinned-pinned", EndKind::pinned, EndKind::pinned, {{1, 3}, {0, 2}}},
                         {"clamped-pinned", EndKind::clamped, EndKind::pinned, {{2, 3}, {0, 2}}},
                         {"clamped-clamped", EndKind::clamped, EndKind::clamped, {{2, 3}, {0, 1}}},
                         {"pinned-free", EndKind::pinned, EndKind::free, {{1, 3}, {2, 3}}},
                         {"clamped-guided", EndKind::clamped, EndKind::clamped, {{2, 3}, {1, 3}}, "x"},
                         {"pinned-guided", EndKind::pinned, EndKind::clamped, {{1, 3}, {1, 3}}, "x"},
                         {"free-guided", EndKind::free, EndKind::clamped, {{0, 1}, {1, 3}}, "x"}};

RodGroup held(const Held& held, EndWeights weights, long n) {
    RodSpec spec = test::clamped_rod(beam, n);
    spec.start = held.start;
    spec.end = held.end;
    spec.end_free = held.end_free;
    return test::group_of(spec, weights);
}
double bending_frequency(const Held& ends, std::size_t mode, EndWeights weights, long n) {
    const double exact = beam.frequencies<3>(ends.left_over)[mode];
    const RodGroup group = held(ends, weights, n);
    const auto across = [](bool turns, int axis) { return axis == (turns ? 1 : 0); };
    return std::abs(test::Statics(group).frequency_near(exact, across) / exact - 1);
}
/// Waves of speed c between a clamp and an end that is free to go or turn along the rod.
double wave_frequency(const Held& ends, bool torsion, int mode, EndWeights weights, long n) {
    const double speed = std::sqrt((torsion ? beam.shear : beam.youngs) / beam.density);
    const double exact = (mode + 0.5) * pi * speed;
    const RodGroup group = held(ends, weights, n);
    const auto along = [&](bool turns, int axis) { return turns == torsion && axis == 2; };
    return std::abs(test::Statics(group).frequency_near(exact, along) / exact - 1);
}

std::vector<test::WeightedCase> cases() {
    std::vector<test::WeightedCase> all;
    for (const Column* c :
         {&test::euler_buckling::cantilever, &pinned, &test::euler_buckling::guided, &test::euler_buckling::sliding})
        all.push_back(
            {std::string("Euler load, ") + c->name, [c](EndWeights w, long n) { return buckling(*c, w, n); }});
    for (const Held& h : ends)
        for (std::size_t mode = 0; mode < 3; ++mode)
            all.push_back({"frequency " + std::to_string(mode) + ", " + h.name,
                           [&h, mode](EndWeights w, long n) { return bending_frequency(h, mode, w, n); }});
    for (const int mode : {0, 1, 2}) {
        const std::string number = std::to_string(mode);
        for (const bool torsion : {false, true})
            all.push_back(
                {(torsion ? "torsional wave " : "axial wave ") + number,
                 [torsion, mode](EndWeights w, long n) { return wave_frequency(clamped_free, torsion, mode, w, n); }});
        all.push_back({"axial wave " + number + ", sliding",
                       [mode](EndWeights w, long n) { return wave_frequency(sliding, false, mode, w, n); }});
    }
    return all;
}

TEST(EndWeights, LoseNoFrequencyAndNoBucklingLoadByMoreThanATenth) {
    test::ErrorTable table("end_weights");
    for (const test::WeightedCase& c : cases()) EXPECT_LE(test::compare_weights(table, c), 1.1) << c.name;
}

} // namespace
} // namespace skein
