// A request that a run stop, made by a signal and read by long work.
#pragma once

#include "skein/core/error.hpp"

namespace skein {

/// Asks every run of this process to stop at its next event with a checkpoint. Safe in a signal handler.
void request_stop();
bool stop_requested();

/// Exception of work that was given up because a stop was requested.
struct Stopped : Error {
    explicit Stopped(const std::string& m) : Error(Exit::limit, m) {}
};

/// Throws Stopped, which names the work, where a stop was requested. Cost: one load, so that inner loops of set-up can
/// afford it.
inline void stop_where_asked(const char* work) {
    if (stop_requested()) throw Stopped(std::string("stopped by a signal while ") + work + "; nothing was written");
}

} // namespace skein
