// The whole step of the cilia (drift, elastic, magnetic field, kick with rates that follow the stretch) at W = 1, 2, 4,
// 8 and in the textbook code, plain and vectorised (bench/textbook); state in L1 (where a tile fits), L2, L3 or DRAM;
// one step per visit of a tile, or as many as a run takes.
//   names: step/<code>/n<elements>/<where the state lies>/visit<steps>
// After the rows follow, from this run, the time of both textbooks over Skein's of the same scene and visit.
#include "support/scenes_for_tests.hpp"
#include "textbook/textbook_rods.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <map>
#include <optional>

namespace {

using namespace skein;
using test::Stage;

struct Residence {
    const char* name;
    double state_bytes; ///< of Skein's state; the textbook's stored intermediates take five times as much
};
constexpr Residence residences[] = {{"L1", 24e3}, {"L2", 384e3}, {"L3", 8e6}, {"DRAM", 96e6}};

/// Rods of n elements whose state fills so many bytes, whole tiles of 8.
long rods_for(double state_bytes, long elements) {
    const double rod_bytes = static_cast<double>(sizeof(Slot<1>)) * static_cast<double>(elements + 1);
    return std::max(8L, 8 * static_cast<long>(state_bytes / (8 * rod_bytes)));
}

using bench::TextbookBuild;

/// A code of one row: Skein at a width, or a textbook (width 0).
struct Code {
    const char* name;
    int width;
    TextbookBuild build = TextbookBuild::plain;
};
constexpr Code codes[] = {
    {"textbook", 0}, {"vectorised", 0, TextbookBuild::vectorised}, {"W1", 1}, {"W2", 2}, {"W4", 4}, {"W8", 8}};

/// What one row steps.
struct Subject {
    Stage stage;
    std::optional<bench::TextbookRods> textbook;

    Subject(Code code, long elements, long rods)
        : stage(test::cilia_scene(code.width == 0 ? std::min(rods, 8 * textbook_share) : rods, elements),
                std::max(1, code.width)) {
        if (code.width == 0)
            textbook.emplace(stage.groups[0], stage.plan.groups[0], stage.plan.dt, stage.groups[0].count(), code.build);
    }
    std::int64_t element_count() const { return stage.groups[0].count() * stage.groups[0].elements(); }
    void visit(std::int64_t steps) {
        const auto batch = stage.clock.next(stage.clock.done() + steps);
        if (textbook) textbook->advance(batch);
        else stage.rods->advance(batch, false);
        stage.clock.advance(batch);
    }

    static constexpr long textbook_share =
        1250; ///< tiles' worth of rods beyond which the textbook's time per element no longer changes
};

void run_step(benchmark::State& state, Code code, long elements, Residence residence, std::int64_t steps) {
    Subject subject(code, elements, rods_for(residence.state_bytes, elements));
    subject.visit(1);
    for (auto _ : state) subject.visit(steps);
    const double work = static_cast<double>(subject.element_count()) * static_cast<double>(steps);
    state.counters["per element-step"] =
        benchmark::Counter(work, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["element-steps"] = benchmark::Counter(work, benchmark::Counter::kIsIterationInvariantRate);
}

/// Prints the rows as they come and, at the end, how many times faster than the plain textbook each code is, and the
/// widest one than the vectorised textbook.
class RatioReporter final : public benchmark::ConsoleReporter {
public:
    void ReportRuns(const std::vector<Run>& runs) override {
        ConsoleReporter::ReportRuns(runs);
        for (const Run& run : runs) {
            if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
            const std::string name = run.run_name.function_name;
            const std::size_t code = name.find('/') + 1, rest = name.find('/', code);
            ns_[name.substr(rest + 1)][name.substr(code, rest - code)] =
                1e9 * run.counters.at("per element-step").value;
        }
    }
    void Finalize() override {
        fmt::print("\n{:<16} {:>11} {:>10} {:>8} {:>8} {:>8} {:>8} {:>20}   (times faster than the textbook)\n", "",
                   "textbook ns", "vectorised", "W1", "W2", "W4", "W8", "W8 over vectorised");
        const auto ratio = [](const auto& of_code, double time, const char* code) {
            const auto own = of_code.find(code);
            return own == of_code.end() ? "-" : fmt::format("{:.2f}", time / own->second);
        };
        for (const auto& [place, of_code] : ns_) {
            const auto textbook = of_code.find("textbook");
            if (textbook == of_code.end()) continue;
            fmt::print("{:<16} {:>11.1f} {:>10}", place, textbook->second,
                       ratio(of_code, textbook->second, "vectorised"));
            for (const char* code : {"W1", "W2", "W4", "W8"})
                fmt::print(" {:>8}", ratio(of_code, textbook->second, code));
            const auto vectorised = of_code.find("vectorised");
            fmt::print(" {:>20}\n", vectorised == of_code.end() ? "-" : ratio(of_code, vectorised->second, "W8"));
        }
    }

private:
    std::map<std::string, std::map<std::string, double>> ns_; ///< place -> code -> ns per element-step
};

} // namespace

int main(int argc, char** argv) {
    for (const long elements : {20L, 50L, 100L})
        for (const Residence& residence : residences) {
            if (8 * (elements + 1) * static_cast<long>(sizeof(Slot<1>)) > static_cast<long>(residence.state_bytes))
                continue;
            for (const int steps : {1, Clock::largest_batch})
                for (const Code& code : codes)
                    benchmark::RegisterBenchmark(
                        fmt::format("step/{}/n{}/{}/visit{}", code.name, elements, residence.name, steps).c_str(),
                        run_step, code, elements, residence, steps)
                        ->Unit(benchmark::kMillisecond);
        }
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    RatioReporter reporter;
    benchmark::RunSpecifiedBenchmarks(&reporter);
    return 0;
}
