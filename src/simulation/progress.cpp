#include "simulation/progress.hpp"

#include "core/timer.hpp"

#include <unistd.h>

#include <cstdio>

namespace skein {

std::string clock_text(double seconds) {
    char text[64];
    const long s = static_cast<long>(seconds + 0.5);
    if (seconds < 10) std::snprintf(text, sizeof text, "%.1f s", seconds);
    else if (s < 60) std::snprintf(text, sizeof text, "%ld s", s);
    else if (s < 3600) std::snprintf(text, sizeof text, "%ld min %02ld s", s / 60, s % 60);
    else std::snprintf(text, sizeof text, "%ld h %02ld min", s / 3600, s / 60 % 60);
    return text;
}

Progress::Progress(bool shown, std::int64_t first_step, std::int64_t last_step, double dt, double elements)
    : shown_(shown), terminal_(isatty(STDOUT_FILENO) != 0), first_(first_step), last_(last_step), dt_(dt), elements_(elements),
      started_(wall_seconds()), last_shown_(started_) {}

void Progress::show(std::int64_t step) {
    if (!shown_ || step == first_) return;
    const double now = wall_seconds(), elapsed = now - started_;
    const double share = static_cast<double>(step) / static_cast<double>(last_);
    // A file gets a line every 5 %, but not more than one every two seconds; a terminal five lines a second.
    if (step < last_ && (terminal_ ? now - last_shown_ < 0.2 : share < next_share_ || now - last_shown_ < 2)) return;
    last_shown_ = now;
    next_share_ = share + 0.05;
    const double done = static_cast<double>(step - first_), left = static_cast<double>(last_ - step);
    std::printf("%sstep %lld/%lld  %5.1f %%  t %.4g s  %.3g element-steps/s  ETA %s%s", terminal_ ? "\r\033[K" : "",
                static_cast<long long>(step), static_cast<long long>(last_), 100 * share, static_cast<double>(step) * dt_,
                done * elements_ / elapsed, clock_text(elapsed / done * left).c_str(), terminal_ ? "" : "\n");
    std::fflush(stdout);
    open_ = terminal_;
}

void Progress::finish() {
    if (open_) std::printf("\n");
    open_ = false;
}

} // namespace skein
