// Messages that take longer, and how much longer a step takes for it: ghosts travel while contacts that need none are
// worked out. The delay of every exchange is made, the bits are those of any run.
//   mpirun -n 2 build/bin/overlap apps/nest/nest_1536.toml --from out
#include "core/timer.hpp"
#include "parallel/messages.hpp"
#include "skein/run.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <string>
#include <vector>

int main(int argc, char** argv) try {
    CLI::App app("Time of a step against the time that messages between ranks take.");
    std::string scene, from;
    std::vector<double> delays = {0, 10, 20, 50, 100, 200, 500};
    long steps = 200, rounds = 9;
    int threads = 1;
    app.add_option("SCENE", scene)->required();
    app.add_option("--from", from, "directory of a run, whose newest checkpoint is gone on from; it is left as it is");
    app.add_option("--delays", delays, "us from the start of an exchange to its end, at least")->delimiter(',');
    app.add_option("--steps", steps, "of each measurement")->check(CLI::PositiveNumber);
    app.add_option("--rounds", rounds, "through all delays, in turn")->check(CLI::PositiveNumber);
    app.add_option("--threads", threads, "per rank")->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);

    const skein::Session session(argc, argv);
    skein::Run run{skein::Scene(scene), {.out = from, .threads = threads}};
    std::vector<std::vector<double>> times(delays.size()); // s of a step, by round
    for (long round = -1; round < rounds; ++round)         // one that does not count
        for (std::size_t d = 0; d < delays.size(); ++d) {
            skein::delay_messages(1e-6 * delays[d]);
            const double began = skein::wall_seconds();
            run.advance(run.step() + steps);
            if (round >= 0) times[d].push_back((skein::wall_seconds() - began) / static_cast<double>(steps));
        }
    if (session.rank() != 0) return 0;
    fmt::print("{} ranks of {} thread{}, {} rounds of {} steps each\n{:>12}{:>14}{:>14}{:>14}\n", session.ranks(),
               threads, threads == 1 ? "" : "s", rounds, steps, "delay us", "step us", "rise us", "rise %");
    double first = 0;
    for (std::size_t d = 0; d < delays.size(); ++d) {
        std::nth_element(times[d].begin(), times[d].begin() + static_cast<std::ptrdiff_t>(times[d].size() / 2),
                         times[d].end());
        const double median = 1e6 * times[d][times[d].size() / 2];
        if (d == 0) first = median;
        fmt::print("{:>12g}{:>14.1f}{:>14.1f}{:>14.1f}\n", delays[d], median, median - first,
                   100 * (median / first - 1));
    }
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 2;
}
