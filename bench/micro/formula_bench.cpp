// What loads cost as formulas: each named load beside its twin, with the largest difference of what they add, and
// formulas of ten operations, over rods that lie in the second cache, turn about in one run. Medians of 21 turns; ns
// per element-step of one core, at the widest level of this machine.
//   bench_formulas [--elements N]
#include "loads/load_passes.hpp"
#include "measure.hpp"
#include "micro/working_set.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <cstring>

namespace {

using namespace skein;
using namespace skein::bench;

#if defined(__AVX512F__)
constexpr int W = 8;
#elif defined(__AVX__)
constexpr int W = 4;
#else
constexpr int W = 2;
#endif

/// ns per element-step of each pass, and its ratio to the first in the same turns.
struct Times {
    std::vector<double> ns, ratio;
};

Times time_of(const RodGroup& group, const std::vector<Load>& loads) {
    WorkingSet<W> set(group, 256e3);
    TilePasses<W> passes;
    for (const Load& load : loads) {
        passes.push_back(make_pass<W>(load, group));
        for (const RodTile<W>& tile : set.tiles()) passes.back()->bind(tile);
    }
    Clock clock(1e-5, 1);
    const auto steps = clock.next(1 + 16);
    const int rounds = std::max(1, static_cast<int>(4e6 / (set.elements() * static_cast<double>(steps.size()))));
    const double work = set.elements() * static_cast<double>(steps.size()) * rounds;
    std::vector<std::vector<double>> ns(loads.size()), ratio(loads.size());
    for (int turn = 0; turn < 22; ++turn)
        for (std::size_t p = 0; p < passes.size(); ++p) {
            const double start = core_seconds();
            for (int round = 0; round < rounds; ++round) {
                passes[p]->prepare(steps);
                for (const RodTile<W>& tile : set.tiles())
                    for (const Step& step : steps) passes[p]->run(tile, set.load(), step);
            }
            const double one = (core_seconds() - start) / work * 1e9;
            if (turn == 0) continue; // warms up
            ns[p].push_back(one);
            ratio[p].push_back(one / ns[0].back());
        }
    Times times;
    for (std::size_t p = 0; p < passes.size(); ++p) {
        times.ns.push_back(median(ns[p]));
        times.ratio.push_back(median(ratio[p]));
    }
    return times;
}

/// What a load adds to the first tile in a batch of steps: its forces, then its couples.
std::vector<Vec3d> added_by(const RodGroup& group, const Load& load) {
    WorkingSet<W> set(group, 1);
    const RodTile<W>& tile = set.tiles()[0];
    const auto pass = make_pass<W>(load, group);
    pass->bind(tile);
    Clock clock(1e-5, 1);
    const auto steps = clock.next(1 + 16);
    pass->prepare(steps);
    AlignedVector<SlotLoad<W>> sum(static_cast<std::size_t>(group.slots()));
    std::memset(static_cast<void*>(sum.data()), 0, sum.size() * sizeof sum[0]);
    for (const Step& step : steps) pass->run(tile, sum.data(), step);
    std::vector<Vec3d> added;
    for (const bool forces : {true, false})
        for (const SlotLoad<W>& l : sum)
            for (int i = 0; i < W; ++i) added.push_back(lane(forces ? l.force : l.couple, i));
    return added;
}

/// Largest difference over the largest that is added.
double difference_of(const RodGroup& group, const Load& named, const Load& written) {
    const auto a = added_by(group, named), b = added_by(group, written);
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, norm(a[i]));
        difference = std::max(difference, norm(a[i] - b[i]));
    }
    return difference / largest;
}

FormulaLoad force(std::vector<std::string> texts, FormulaPer per = FormulaPer::length, FormulaAt at = FormulaAt::rod) {
    return {.force = std::move(texts), .per = per, .at = at};
}
FormulaLoad couple(std::vector<std::string> texts) { return {.couple = std::move(texts), .per = FormulaPer::rod}; }

Load read(Load load) {
    load.use({{}, {}, 1.0});
    return load;
}

} // namespace

int main(int argc, char** argv) {
    const long elements = argc > 2 ? std::atol(argv[2]) : 25;
    RodSpec spec = test::simple_rod(elements);
    spec.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
    const RodGroup group(spec, 0, 0, "");
    constexpr auto length = FormulaPer::length, rod = FormulaPer::rod;
    const auto at_end = FormulaAt::end;
    const std::vector<std::pair<Load, Load>> twins = {
        {Gravity{{0.3, 1, -9.81}}, force({"0.3", "1", "-9.81"}, FormulaPer::mass)},
        {UniformForce{.force = {8, 0, -1}}, force({"8", "0", "-1"}, rod)},
        {UniformForce{.force = {8, 0, -1}, .ramp = {2}}, force({"8*ramp(t, 2)", "0", "-1*ramp(t, 2)"}, rod)},
        {UniformCouple{.couple = {1, 2, 3}}, couple({"1", "2", "3"})},
        {UniformCouple{.couple = {1, 2, 3}, .ramp = {5}}, couple({"1*ramp(t, 5)", "2*ramp(t, 5)", "3*ramp(t, 5)"})},
        {EndForce{.start = {0, 4, 3}}, force({"0", "4", "3"}, length, FormulaAt::start)},
        {EndForce{.end = {-4, 0, 0.5}, .ramp = {2}}, force({"-4*ramp(t, 2)", "0", "0.5*ramp(t, 2)"}, length, at_end)},
        {SinusoidalEndForce{.end = 3, .period = 4}, force({"3*cos(2*pi/4*t)", "3*sin(2*pi/4*t)", "0"}, length, at_end)},
        {MagneticField{.constant = {0, 8e-4, 0.01}}, MagneticFormula{{"0", "8e-4", "0.01"}}},
        {MagneticField{.constant = {0, 8e-4, 0}, .rotating = 0.08, .period = 72, .ramp = {10}},
         MagneticFormula{{"ramp(t, 10)*0.08*sin(2*pi/72*t)", "8e-4*ramp(t, 10)", "ramp(t, 10)*0.08*cos(2*pi/72*t)"}}}};
    fmt::print("{}, {} lanes, {} elements\n{:<24}{:>10}{:>10}{:>8}{:>12}\n", processor(), W, elements, "load",
               "named ns", "formula", "ratio", "difference");
    for (const auto& [named, written] : twins) {
        const Load formula = read(written);
        const Times t = time_of(group, {named, formula});
        fmt::print("{:<24}{:>10.3f}{:>10.3f}{:>8.2f}{:>12.1e}\n", named.kind(), t.ns[0], t.ns[1], t.ratio[1],
                   difference_of(group, named, formula));
    }
    const std::pair<const char*, Load> longer[] = {
        {"10 operations", force({"(x*y - 3*z)*(2*x + y*z) - (x + 0.5)*(z - y)", "0", "0"})},
        {"10 with a division", force({"(x*y - 3*z)/(2 + y*z*y) - (x + 0.5)*(z - y)", "0", "0"})},
        {"10 with sin and exp", force({"sin(2*x + 3*y*z - t)*exp(-(2*x)^2)*(z - 0.5)", "0", "0"})},
        {"10 with tanh", force({"(x*y - 3*z)*(2*x + y*z) - tanh(x + 0.5)*(z - y)", "0", "0"})},
        {"10 with atan2", force({"(x*y - 3*z)*(2*x + y*z) - atan2(x + 0.5, z - y)", "0", "0"})},
        {"10 with a power", force({"(x*y - 3*z)*(2*x + y*z) - (x*x + 0.5)^1.7*(z - y)", "0", "0"})},
        {"30 in three components",
         force({"(x*y - 3*z)*(2*x + y*z) - (x + 0.5)*(z - y)", "(y*z - 3*x)*(2*y + z*x) - (y + 0.5)*(x - z)",
                "(z*x - 3*y)*(2*z + x*y) - (z + 0.5)*(y - x)"})}};
    for (const auto& [name, load] : longer) fmt::print("{:<24}{:>20.3f}\n", name, time_of(group, {read(load)}).ns[0]);
}
