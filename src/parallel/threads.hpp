// Shared-memory loops on oneTBB.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <thread>

namespace skein {

/// A fixed team of threads. Loops run inside it; the caller takes part.
class Threads {
public:
    /// `count` 0: as many as this process may use (its affinity mask). `shuffle` not 0: loops take their numbers in an
    /// order drawn from it, each loop in its own; for checks that no result depends on it.
    explicit Threads(int count, unsigned shuffle = 0);
    ~Threads();
    int count() const { return count_; }
    /// Cores in this process's affinity mask: how many, and which, e.g. "0-3,8".
    static int available_cores();
    static std::string available_core_list();

    /// body(i, thread) for i in [0, n), in any order; `thread` in [0, count()) is unique among concurrent calls. `body`
    /// is called through one indirect call per i, so i is a tile, not an element. The first exception is rethrown.
    /// Loops do not nest.
    void for_each(std::size_t n, const std::function<void(std::size_t i, int thread)>& body) const;

    /// From now on poll() calls this on the thread that does so here, until it is set to nothing; not while a loop
    /// runs. Messages that travel while loops run need it: many MPI libraries move them only inside of calls.
    void set_poll(std::function<void()> poll) const;
    /// For bodies that take long, between pieces of work.
    void poll() const {
        if (poll_ && std::this_thread::get_id() == poller_) poll_();
    }

private:
    struct Arena;
    void run(std::size_t n, const std::function<void(std::size_t i, int thread)>& body) const;

    std::unique_ptr<Arena> arena_;
    int count_;
    mutable unsigned shuffle_;
    mutable std::function<void()> poll_;
    mutable std::thread::id poller_;
};

} // namespace skein
