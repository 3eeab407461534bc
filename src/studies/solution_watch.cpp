#include "studies/solution_watch.hpp"

#include "core/timer.hpp"
#include "simulation/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace skein {

namespace {

constexpr double quick = 1;                   ///< s: solutions that take less tell nothing
constexpr double seconds_between_looks = 0.2; ///< of a line that is rewritten

} // namespace

double factor_bytes(std::string_view factor, double entries) {
    return entries * (factor.starts_with("sparse") ? sizeof(double) + sizeof(int) : sizeof(double));
}

std::string to_text(const SolutionPlan& plan) {
    return fmt::format("Plan: {} unknowns in {} pieces; {} of {:.2g} MB; {:.2g} s a correction\n", plan.unknowns,
                       plan.pieces, plan.factor, 1e-6 * plan.factor_bytes, plan.seconds);
}

SolutionWatch::SolutionWatch(bool shown, std::int64_t pieces, std::int64_t unknowns)
    : shown_(shown), rewrites_(isatty(STDOUT_FILENO) != 0 && !under_launcher()), plan_{.pieces = pieces,
                                                                                       .unknowns = unknowns,
                                                                                       .factor = {}},
      began_(wall_seconds()), last_(began_) {}

SolutionWatch::~SolutionWatch() {
    if (open_) std::printf("\n");
}

void SolutionWatch::see(const NewtonProgress& now) {
    const std::lock_guard<std::mutex> own(one_);
    ++corrections_;
    if (const double bytes = factor_bytes(now.factor, now.factor_entries); bytes > plan_.factor_bytes) {
        plan_.factor = now.factor;
        plan_.factor_bytes = bytes;
        plan_.seconds = now.seconds;
    }
    if (shown_) show(now);
}

void SolutionWatch::show(const NewtonProgress& now) {
    const double time = wall_seconds(), elapsed = time - began_;
    if (elapsed < quick || time - last_ < (rewrites_ ? seconds_between_looks : seconds_between_lines(elapsed))) return;
    last_ = time;
    if (!told_plan_) std::printf("%s", to_text(plan_).c_str());
    told_plan_ = true;
    std::printf("%s", fmt::format("{}{:>9}  {} corrections, {:.3g} s each  load {:.1f} %{}  residual {:.2e}{}",
                                  rewrites_ ? "\r\033[K" : "  ", clock_text(elapsed), corrections_,
                                  elapsed / static_cast<double>(corrections_), 100 * now.share,
                                  now.downhill ? ", downhill" : "", now.residual, rewrites_ ? "" : "\n")
                          .c_str());
    std::fflush(stdout);
    open_ = rewrites_;
}

} // namespace skein
