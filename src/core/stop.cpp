#include "core/stop.hpp"

#include <csignal>

namespace skein {

namespace {

volatile std::sig_atomic_t asked = 0;

} // namespace

void request_stop() { asked = 1; }
bool stop_requested() { return asked != 0; }

} // namespace skein
