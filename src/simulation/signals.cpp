#include "simulation/signals.hpp"

#include "core/stop.hpp"

#include <csignal>
#include <ctime>

namespace skein {

namespace {

/// Two SIGINTs closer than this are one: launchers send it to a process and to its group.
constexpr double one_interrupt_s = 0.3;

volatile std::sig_atomic_t interrupted = 0;
timespec first_interrupt;

double seconds_since(const timespec& then) {
    timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now); // safe in a handler
    return static_cast<double>(now.tv_sec - then.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec - then.tv_nsec);
}

void on_signal(int number) {
    request_stop();
    if (number != SIGINT) return;
    if (!interrupted) {
        clock_gettime(CLOCK_MONOTONIC, &first_interrupt);
        interrupted = 1;
    } else if (seconds_since(first_interrupt) > one_interrupt_s) {
        std::signal(SIGINT, SIG_DFL);
        std::raise(SIGINT); // comes when the handler returns
    }
}

} // namespace

void stop_on_signals() {
    struct sigaction stop {
    }, ignore{}, before{};
    stop.sa_handler = on_signal;
    ignore.sa_handler = SIG_IGN;
    for (const int number : {SIGUSR1, SIGTERM, SIGINT}) sigaction(number, &stop, nullptr);
    sigaction(SIGHUP, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &stop, nullptr);
    for (const int number : {SIGPIPE, SIGXFSZ}) sigaction(number, &ignore, nullptr);
}

} // namespace skein
