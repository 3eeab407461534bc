// The wish that a run stop, which a signal tells and long work looks at.
#pragma once

#include "skein/core/error.hpp"

namespace skein {

/// Asks every run of this process to stop at its next event with a checkpoint. Safe in a signal handler.
void request_stop();
bool stop_requested();

/// Work that was given up because a stop was asked for.
struct Stopped : Error {
    explicit Stopped(const std::string& m) : Error(Exit::limit, m) {}
};

/// Throws Stopped, saying what was going on, where a stop was asked for. Costs a load: for inner loops of set-up.
inline void stop_where_asked(const char* work) {
    if (stop_requested()) throw Stopped(std::string("stopped by a signal while ") + work + "; nothing was written");
}

} // namespace skein
