// Reactions of a run to signals.
#pragma once

namespace skein {

/// SIGUSR1, SIGTERM, SIGINT and SIGHUP ask for a stop (core/stop.hpp); a second SIGINT ends the process at once. A
/// SIGHUP that was ignored before, as by nohup, stays so. SIGPIPE and SIGXFSZ are ignored: a reader that has gone, or a
/// limit of file size, is told by the call that writes.
void stop_on_signals();

} // namespace skein
