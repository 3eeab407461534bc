// The cilia farm, stepped by Skein and by the textbook (bench/textbook) in one run: time, and the difference of the two results
// at the end, so that a speed never stands without the error at which it holds.
//   bench_farm [--cilia 111797] [--elements 25] [--steps 100] [--textbook 4000] [--repeats 5] [--csv FILE]
// Each repeat times every row once, in turn, so that a busy machine slows all rows alike; the table holds medians of wall time
// and of core time (processor time of all threads, which other programs disturb least).
#include "core/timer.hpp"
#include "measure.hpp"
#include "support/scenes_for_tests.hpp"
#include "textbook/textbook_rods.hpp"

#include <CLI/CLI.hpp>
#include <fmt/os.h>
#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace {

using namespace skein;
using bench::core_seconds;
using bench::processor;
using test::Stage;

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

struct Row {
    std::string code;
    int threads;
    std::int64_t per_visit;      ///< steps that a rod or tile makes before the next one's turn
    std::int64_t element_steps;  ///< in one repeat
    std::function<void(std::int64_t until)> advance;
    std::vector<double> wall_s, core_s; ///< per repeat

    double wall_ns() const { return 1e9 * median(wall_s) / static_cast<double>(element_steps); }
    double core_ns() const { return 1e9 * median(core_s) / static_cast<double>(element_steps); }
};

/// Largest distance between nodes of the two codes' rods at synchronised time, over the rods' length.
double difference(const Stage& stage, const bench::TextbookRods& textbook) {
    double most = 0;
    std::vector<Slot<1>> other(static_cast<std::size_t>(stage.groups[0].slots()));
    for (std::size_t i = 0; i < textbook.count(); ++i) {
        textbook.state(i, other);
        const auto own = stage.state(i);
        for (std::size_t k = 0; k < own.size(); ++k) most = std::max(most, norm(lane(own[k].position, 0) - lane(other[k].position, 0)));
    }
    return most / stage.scene.rods[0].shape.length;
}

/// Largest distance of a rod's nodes from where they started, over its length: what the difference is to be judged against.
double motion(const Stage& stage, std::size_t rods) {
    double most = 0;
    std::vector<Slot<1>> start(static_cast<std::size_t>(stage.groups[0].slots()));
    for (std::size_t i = 0; i < rods; ++i) {
        stage.groups[0].start_state(stage.rods->local()[i].index, start);
        const auto now = stage.state(i);
        for (std::size_t k = 0; k < now.size(); ++k) most = std::max(most, norm(lane(now[k].position, 0) - lane(start[k].position, 0)));
    }
    return most / stage.scene.rods[0].shape.length;
}

} // namespace

int main(int argc, char** argv) {
    long cilia = 111797, elements = 25, steps = 100, subset = 4000, repeats = 5;
    std::string csv;
    CLI::App app{"Skein against a textbook code on the cilia farm"};
    app.add_option("--cilia", cilia, "rods of the scene")->check(CLI::PositiveNumber);
    app.add_option("--elements", elements, "elements per rod")->check(CLI::Range(2, 10000));
    app.add_option("--steps", steps, "steps per repeat")->check(CLI::PositiveNumber);
    app.add_option("--textbook", subset, "rods that the textbook steps: the scene's first; time is per element-step")->check(CLI::PositiveNumber);
    app.add_option("--repeats", repeats, "repeats, of which the table shows the median")->check(CLI::PositiveNumber);
    app.add_option("--csv", csv, "file for the table");
    CLI11_PARSE(app, argc, argv);
    subset = std::min(subset, cilia);

    const SceneSpec scene = test::cilia_scene(cilia, elements);
    Stage one(scene, 8, 1), two(scene, 8, 2);
    bench::TextbookRods textbook(one.groups[0], one.plan.groups[0], one.plan.dt, subset);
    Clock textbook_clock(one.plan.dt, 0);

    const auto advance_textbook = [&](std::int64_t until, std::int64_t per_visit) {
        while (textbook_clock.done() < until) {
            const auto batch = textbook_clock.next(std::min(until, textbook_clock.done() + per_visit));
            textbook.visit(batch);
            textbook_clock.advance(batch);
        }
    };
    std::vector<Row> rows;
    for (const std::int64_t per_visit : {std::int64_t{1}, std::int64_t{Clock::largest_batch}}) {
        rows.push_back({"textbook", 1, per_visit, subset * elements * steps, [&, per_visit](std::int64_t until) { advance_textbook(until, per_visit); }, {}, {}});
        rows.push_back({"skein", 1, per_visit, cilia * elements * steps, [&, per_visit](std::int64_t until) { one.advance(until, per_visit); }, {}, {}});
        rows.push_back({"skein", 2, per_visit, cilia * elements * steps, [&, per_visit](std::int64_t until) { two.advance(until, per_visit); }, {}, {}});
    }
    // All rods of a code go through the same steps: its rows take turns at them.
    for (long repeat = 0; repeat < repeats; ++repeat)
        for (Row& row : rows) {
            const std::int64_t turns_done = 2 * repeat + (row.per_visit > 1 ? 1 : 0);
            const double wall = wall_seconds(), core = core_seconds();
            row.advance((turns_done + 1) * steps);
            row.wall_s.push_back(wall_seconds() - wall);
            row.core_s.push_back(core_seconds() - core);
        }

    const double apart = difference(one, textbook), moved = motion(one, textbook.count());
    const bool agree = one.rods->digest() == two.rods->digest();
    const auto bytes_of = [&](const Row& row) {
        return row.code == "skein" ? static_cast<double>((row.threads == 1 ? one : two).rods->bytes()) / static_cast<double>(cilia * elements)
                                   : static_cast<double>(textbook.bytes()) / static_cast<double>(subset * elements);
    };
    const auto digest_of = [&](const Row& row) {
        return row.code == "skein" ? fmt::format("{:016x}", (row.threads == 1 ? one : two).rods->digest()) : std::string("-");
    };
    // A row is compared with the textbook that takes as many steps per visit.
    const auto twin_of = [&](const Row& row) -> const Row& {
        return *std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.code == "textbook" && r.per_visit == row.per_visit; });
    };

    fmt::print("{}; ns per element-step\n{} cilia x {} elements ({} by the textbook), {} repeats of {} steps, dt = {:.4g} s\n\n", processor(), cilia, elements, subset,
               repeats, steps, one.plan.dt);
    fmt::print("{:<9} {:>7} {:>11} {:>8} {:>7} {:>8} {:>7} {:>13}  {}\n", "code", "threads", "steps/visit", "wall ns", "ratio", "core ns", "ratio",
               "bytes/element", "digest");
    for (const Row& row : rows)
        fmt::print("{:<9} {:>7} {:>11} {:>8.2f} {:>7.2f} {:>8.2f} {:>7.2f} {:>13.1f}  {}\n", row.code, row.threads, row.per_visit, row.wall_ns(),
                   twin_of(row).wall_ns() / row.wall_ns(), row.core_ns(), twin_of(row).core_ns() / row.core_ns(), bytes_of(row), digest_of(row));
    fmt::print("\nafter {} steps: rods moved {:.3g} L; largest difference between Skein and the textbook {:.2g} L; digests {}\n", 2 * repeats * steps, moved,
               apart, agree ? "agree" : "DIFFER");
    if (!csv.empty()) {
        auto file = fmt::output_file(csv);
        file.print("cpu,cilia,elements,steps,code,threads,steps_per_visit,wall_ns,wall_ratio,core_ns,core_ratio,bytes_per_element,digest,difference_over_length\n");
        for (const Row& row : rows)
            file.print("\"{}\",{},{},{},{},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.5g},{},{:.3g}\n", processor(), cilia, elements, steps, row.code,
                       row.threads, row.per_visit, row.wall_ns(), twin_of(row).wall_ns() / row.wall_ns(), row.core_ns(),
                       twin_of(row).core_ns() / row.core_ns(), bytes_of(row), digest_of(row), apart);
    }
    return agree ? 0 : 1;
}
