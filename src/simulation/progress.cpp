#include "simulation/progress.hpp"

#include "core/timer.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <utility>

namespace skein {

namespace {

constexpr double seconds_between_bars = 0.2;

std::string name_of(const std::string& column) { return column.substr(0, column.find('[')); }

} // namespace

std::string clock_text(double seconds) {
    char text[64];
    const long s = static_cast<long>(seconds + 0.5);
    if (seconds < 10) std::snprintf(text, sizeof text, "%.1f s", seconds);
    else if (s < 60) std::snprintf(text, sizeof text, "%ld s", s);
    else if (s < 3600) std::snprintf(text, sizeof text, "%ld min %02ld s", s / 60, s % 60);
    else std::snprintf(text, sizeof text, "%ld h %02ld min", s / 3600, s / 60 % 60);
    return text;
}

std::string share_done(std::int64_t step, std::int64_t steps) {
    if (step <= steps)
        return fmt::format("{:.1f} % done", 100.0 * static_cast<double>(step) / static_cast<double>(steps));
    return fmt::format("beyond the {} steps of the present time.duration: the run kept here is a longer one; a longer "
                       "time.duration continues it, another --out or --overwrite begins a shorter one",
                       steps);
}

bool under_launcher() {
    constexpr const char* names[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"};
    return std::any_of(std::begin(names), std::end(names),
                       [](const char* name) { return std::getenv(name) != nullptr; });
}

std::vector<std::size_t> columns_of(std::string_view key, std::span<const std::string> wanted,
                                    std::span<const std::string> all) {
    std::vector<std::size_t> places;
    for (const std::string& name : wanted) {
        const auto found =
            std::find_if(all.begin(), all.end(), [&](const std::string& column) { return name_of(column) == name; });
        if (found == all.end()) {
            std::vector<std::string> names;
            for (const std::string& column : all) names.push_back(name_of(column));
            throw InputError(
                fmt::format("{}: this scene's series has no '{}'; it has {}", key, name, fmt::join(names, ", ")));
        }
        places.push_back(static_cast<std::size_t>(found - all.begin()));
    }
    return places;
}

double seconds_between_lines(double elapsed) { return std::clamp(0.02 * elapsed, 2.0, 600.0); }

Progress::Progress(bool shown, ProgressStyle style, std::int64_t first_step, std::int64_t last_step, double dt,
                   double elements, std::vector<std::string> columns, std::optional<PlaceAmongRuns> place)
    : shown_(shown), bar_(style == ProgressStyle::bar ||
                          (style == ProgressStyle::automatic && isatty(STDOUT_FILENO) != 0 && !under_launcher())),
      first_(first_step), last_(last_step), dt_(dt), elements_(elements), started_(wall_seconds()),
      last_shown_(started_), columns_(std::move(columns)), place_(std::move(place)) {}

bool Progress::due(std::int64_t step) const {
    if (!shown_ || step == first_) return false;
    const double now = wall_seconds();
    return step >= last_ || now - last_shown_ >= (bar_ ? seconds_between_bars : seconds_between_lines(now - started_));
}

void Progress::show(std::int64_t step, std::span<const double> values, std::string_view more) {
    if (!values.empty()) {
        values_.clear();
        for (std::size_t i = 0; i < columns_.size(); ++i) values_ += fmt::format("  {} {:.4g}", columns_[i], values[i]);
    }
    if (!due(step) || (!bar_ && !columns_.empty() && values.empty())) return; // a line has the values of its step
    const double now = wall_seconds(), elapsed = now - started_;
    last_shown_ = now;
    const double share = static_cast<double>(step) / static_cast<double>(last_);
    const double done = static_cast<double>(step - first_), left = static_cast<double>(last_ - step);
    const double to_come = place_ ? elapsed / done * (left + place_->to_come * static_cast<double>(last_)) : 0;
    const std::string text =
        fmt::format("{}{}step {}/{}  {:5.1f} %  t {:.4g} s  {:.3g} {}/s  ETA {}{}{}{}{}", bar_ ? "\r\033[K" : "",
                    place_ ? place_->name + "  " : "", step, last_, 100 * share, static_cast<double>(step) * dt_,
                    done * (elements_ > 0 ? elements_ : 1) / elapsed, elements_ > 0 ? "element-steps" : "steps",
                    clock_text(elapsed / done * left), place_ ? fmt::format(", all runs {}", clock_text(to_come)) : "",
                    values_, more, bar_ ? "" : "\n");
    errno = 0;
    if ((std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) && !told_) {
        told_ = true;
        std::fprintf(stderr, "note: standard output is gone (%s); the run continues\n", std::strerror(errno));
    }
    open_ = bar_;
}

void Progress::finish() {
    if (open_) std::printf("\n");
    open_ = false;
}

} // namespace skein
