// The cilia farm, stepped by Skein and by the textbook, plain and vectorised (bench/textbook), in one run: time, and
// the difference of the results at the end, so that a speed never stands without the error at which it holds. Skein's
// rows are what its speed is made of, one thing after the other: one sweep with polynomials (W = 1), 2, 4 and 8 rods
// side by side, 64 steps while a tile is in cache, two threads.
//   bench_farm [--cilia 111797] [--elements 25] [--steps 64] [--textbook 4000] [--repeats 5] [--csv FILE]
// Each repeat times every row once, in turn, so that a busy machine slows all rows alike; the table holds medians of
// wall time and of core time (processor time of all threads, which other programs disturb least).
#include "core/timer.hpp"
#include "measure.hpp"
#include "support/scenes_for_tests.hpp"
#include "textbook/textbook_rods.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <memory>
#include <tuple>

namespace {

using namespace skein;
using bench::core_seconds;
using bench::median;
using bench::processor;
using test::Stage;

/// One code in one setting, with rods of its own.
struct Row {
    int lanes, threads;     ///< no lanes: a textbook
    std::int64_t per_visit; ///< steps that a rod or tile makes before the next one's turn
    std::unique_ptr<Stage> stage;
    std::unique_ptr<bench::TextbookRods> textbook;
    Clock textbook_clock;
    std::int64_t elements;
    std::vector<double> wall_s{}, core_s{}; ///< per repeat

    void time(std::int64_t until) {
        const double wall = wall_seconds(), core = core_seconds();
        if (stage) stage->advance(until, per_visit);
        while (textbook && textbook_clock.done() < until) {
            const auto batch = textbook_clock.next(until, per_visit);
            textbook->advance(batch);
            textbook_clock.advance(batch);
        }
        wall_s.push_back(wall_seconds() - wall);
        core_s.push_back(core_seconds() - core);
    }
    double ns(const std::vector<double>& seconds, std::int64_t steps) const {
        return 1e9 * median(seconds) / static_cast<double>(elements * steps);
    }
    bool is(bench::TextbookBuild build) const { return textbook && textbook->build() == build; }
    std::string code() const {
        return !textbook ? "skein" : is(bench::TextbookBuild::plain) ? "textbook" : "textbook vectorised";
    }
    std::string digest() const { return textbook ? "-" : fmt::format("{:016x}", stage->rods->digest()); }
    double bytes_per_element() const {
        return static_cast<double>(textbook ? textbook->bytes() : stage->rods->bytes()) / static_cast<double>(elements);
    }
};

/// Largest distance between nodes of the two codes' rods at synchronised time, over the rods' length.
double difference(const Stage& stage, const bench::TextbookRods& textbook) {
    double most = 0;
    std::vector<Slot<1>> other(static_cast<std::size_t>(stage.groups[0].slots()));
    for (std::size_t i = 0; i < textbook.count(); ++i) {
        textbook.state(i, other);
        const auto own = stage.state(i);
        for (std::size_t k = 0; k < own.size(); ++k)
            most = std::max(most, norm(lane(own[k].position, 0) - lane(other[k].position, 0)));
    }
    return most / stage.scene.rods[0].shape.length;
}

/// The same between two textbooks that step the same rods.
double difference(const bench::TextbookRods& a, const bench::TextbookRods& b, long elements, double length) {
    double most = 0;
    std::vector<Slot<1>> of_a(static_cast<std::size_t>(elements + 1)), of_b = of_a;
    for (std::size_t i = 0; i < a.count(); ++i) {
        a.state(i, of_a);
        b.state(i, of_b);
        for (std::size_t k = 0; k < of_a.size(); ++k)
            most = std::max(most, norm(lane(of_a[k].position, 0) - lane(of_b[k].position, 0)));
    }
    return most / length;
}

/// Largest distance of a rod's nodes from where they started, over its length: what the difference is to be judged
/// against.
double motion(const Stage& stage, std::size_t rods) {
    double most = 0;
    std::vector<Slot<1>> start(static_cast<std::size_t>(stage.groups[0].slots()));
    for (std::size_t i = 0; i < rods; ++i) {
        stage.groups[0].start_state(stage.rods->local()[i].index, start);
        const auto now = stage.state(i);
        for (std::size_t k = 0; k < now.size(); ++k)
            most = std::max(most, norm(lane(now[k].position, 0) - lane(start[k].position, 0)));
    }
    return most / stage.scene.rods[0].shape.length;
}

} // namespace

int main(int argc, char** argv) {
    long cilia = 111797, elements = 25, steps = 64, subset = 4000, repeats = 5;
    std::string csv;
    CLI::App app{"Skein against a textbook code on the cilia farm"};
    app.add_option("--cilia", cilia, "rods of the scene")->check(CLI::PositiveNumber);
    app.add_option("--elements", elements, "elements per rod")->check(CLI::Range(2, 10000));
    app.add_option("--steps", steps, "steps per repeat")->check(CLI::PositiveNumber);
    app.add_option("--textbook", subset, "rods that the textbook steps: the scene's first; time is per element-step")
        ->check(CLI::PositiveNumber);
    app.add_option("--repeats", repeats, "repeats, of which the table shows the median")->check(CLI::PositiveNumber);
    app.add_option("--csv", csv, "file for the table");
    CLI11_PARSE(app, argc, argv);
    subset = std::min(subset, cilia);

    std::vector<Row> rows;
    const auto add_skein = [&](int lanes, int threads, std::int64_t per_visit) {
        auto stage = std::make_unique<Stage>(test::cilia_scene(cilia, elements), lanes, threads);
        const Clock unused(stage->plan.dt, 0);
        rows.push_back({lanes, threads, per_visit, std::move(stage), nullptr, unused, cilia * elements});
    };
    for (const int lanes : {8, 1, 2, 4}) add_skein(lanes, 1, 1);
    add_skein(8, 2, 1);
    add_skein(8, 1, Clock::largest_batch);
    add_skein(8, 2, Clock::largest_batch);
    const Stage& scene = *rows[0].stage;
    for (const std::int64_t per_visit : {std::int64_t{1}, std::int64_t{Clock::largest_batch}})
        for (const auto build : {bench::TextbookBuild::plain, bench::TextbookBuild::vectorised}) {
            auto textbook = std::make_unique<bench::TextbookRods>(scene.groups[0], scene.plan.groups[0], scene.plan.dt,
                                                                  subset, build);
            rows.push_back({0, 1, per_visit, nullptr, std::move(textbook), Clock(scene.plan.dt, 0), subset * elements});
        }
    for (long repeat = 1; repeat <= repeats; ++repeat)
        for (Row& row : rows) row.time(repeat * steps);
    std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
        return std::tuple(a.threads, a.per_visit, a.lanes) < std::tuple(b.threads, b.per_visit, b.lanes);
    });

    const auto row_of = [&](int lanes, std::int64_t per_visit) -> const Row& {
        return *std::find_if(rows.begin(), rows.end(), [&](const Row& r) {
            return r.lanes == lanes && r.threads == 1 && r.per_visit == per_visit &&
                   !r.is(bench::TextbookBuild::vectorised);
        });
    };
    const Stage& one = *row_of(8, 1).stage;
    const bench::TextbookRods& textbook = *row_of(0, 1).textbook;
    const bench::TextbookRods& vectorised = *std::find_if(rows.begin(), rows.end(), [](const Row& r) {
                                                 return r.is(bench::TextbookBuild::vectorised) && r.per_visit == 1;
                                             })->textbook;
    const std::string digest = row_of(8, 1).digest();
    const double apart = difference(one, textbook), moved = motion(one, textbook.count());
    const double textbooks_apart = difference(textbook, vectorised, elements, one.scene.rods[0].shape.length);
    const bool agree =
        std::all_of(rows.begin(), rows.end(), [&](const Row& row) { return row.textbook || row.digest() == digest; });
    // A row is compared with the plain textbook that takes as many steps per visit.
    struct Figures {
        double wall_ns, wall_ratio, core_ns, core_ratio;
    };
    const auto figures = [&](const Row& row) {
        const Row& twin = row_of(0, row.per_visit);
        const double wall = row.ns(row.wall_s, steps), core = row.ns(row.core_s, steps);
        return Figures{wall, twin.ns(twin.wall_s, steps) / wall, core, twin.ns(twin.core_s, steps) / core};
    };

    fmt::print("{}; ns per element-step\n{} cilia x {} elements ({} by the textbook), {} repeats of {} steps, dt = "
               "{:.4g} s\n\n",
               processor(), cilia, elements, subset, repeats, steps, one.plan.dt);
    fmt::print("{:<19} {:>5} {:>7} {:>11} {:>8} {:>7} {:>8} {:>7} {:>13}  {}\n", "code", "lanes", "threads",
               "steps/visit", "wall ns", "ratio", "core ns", "ratio", "bytes/element", "digest");
    for (const Row& row : rows) {
        const auto [wall_ns, wall_ratio, core_ns, core_ratio] = figures(row);
        fmt::print("{:<19} {:>5} {:>7} {:>11} {:>8.2f} {:>7.2f} {:>8.2f} {:>7.2f} {:>13.1f}  {}\n", row.code(),
                   std::max(1, row.lanes), row.threads, row.per_visit, wall_ns, wall_ratio, core_ns, core_ratio,
                   row.bytes_per_element(), row.digest());
    }
    fmt::print("\nafter {} steps: rods moved {:.3g} L; largest difference between Skein and the textbook {:.2g} L, "
               "between the "
               "textbooks {:.2g} L; digests {}\n",
               repeats * steps, moved, apart, textbooks_apart, agree ? "agree" : "DIFFER");
    if (!csv.empty()) {
        auto file = fmt::output_file(csv);
        file.print("cpu,cilia,elements,steps,code,lanes,threads,steps_per_visit,wall_ns,wall_ratio,core_ns,core_ratio,"
                   "bytes_per_"
                   "element,digest,difference_over_length\n");
        for (const Row& row : rows) {
            const auto [wall_ns, wall_ratio, core_ns, core_ratio] = figures(row);
            file.print("\"{}\",{},{},{},{},{},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.5g},{},{:.3g}\n", processor(), cilia,
                       elements, repeats * steps, row.code(), std::max(1, row.lanes), row.threads, row.per_visit,
                       wall_ns, wall_ratio, core_ns, core_ratio, row.bytes_per_element(), row.digest(),
                       row.is(bench::TextbookBuild::vectorised) ? textbooks_apart : apart);
        }
    }
    return agree ? 0 : 1;
}
