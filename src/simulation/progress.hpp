// The line that tells how a run is doing: on a terminal one line, rewritten; in a file one line every few per cent.
#pragma once

#include <cstdint>
#include <string>

namespace skein {

/// "3 min 05 s"
std::string clock_text(double seconds);

class Progress {
public:
    Progress(bool shown, std::int64_t first_step, std::int64_t last_step, double dt, double elements);
    void show(std::int64_t step);
    void finish();

private:
    bool shown_, terminal_, open_ = false;
    std::int64_t first_, last_;
    double dt_, elements_, started_, last_shown_;
    double next_share_ = 0;
};

} // namespace skein
