#include "parallel/threads.hpp"

#include "skein/core/index.hpp"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <sched.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace skein {

struct Threads::Arena {
    explicit Arena(int count) : limit(tbb::global_control::max_allowed_parallelism, to_index(count)), arena(count) {}

    tbb::global_control limit;
    tbb::task_arena arena;
};

int Threads::available_cores() {
    cpu_set_t mask;
    CPU_ZERO(&mask);
    return sched_getaffinity(0, sizeof mask, &mask) == 0 ? CPU_COUNT(&mask) : 1;
}

std::string Threads::available_core_list() {
    cpu_set_t mask;
    CPU_ZERO(&mask);
    if (sched_getaffinity(0, sizeof mask, &mask) != 0) return {};
    std::string list;
    for (int core = 0; core < CPU_SETSIZE; ++core) {
        if (!CPU_ISSET(core, &mask)) continue;
        int last = core;
        while (last + 1 < CPU_SETSIZE && CPU_ISSET(last + 1, &mask)) ++last;
        if (!list.empty()) list += ',';
        list += std::to_string(core);
        if (last > core) list.append("-").append(std::to_string(last));
        core = last;
    }
    return list;
}

Threads::Threads(int count, unsigned shuffle) : count_(count > 0 ? count : available_cores()), shuffle_(shuffle) {
    if (count_ > 1) arena_ = std::make_unique<Arena>(count_);
}

Threads::~Threads() = default;

void Threads::for_each(std::size_t n, const std::function<void(std::size_t i, int thread)>& body) const {
    if (shuffle_ == 0) return run(n, body);
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::minstd_rand(++shuffle_));
    run(n, [&](std::size_t i, int thread) { body(order[i], thread); });
}

void Threads::run(std::size_t n, const std::function<void(std::size_t i, int thread)>& body) const {
    if (!arena_) {
        for (std::size_t i = 0; i < n; ++i) body(i, 0);
        return;
    }
    // A task costs a tenth of a microsecond, a tile one or more. Tasks have some tiles where there are many, and the
    // end is balanced.
    const std::size_t grain = std::clamp<std::size_t>(n / (64 * to_index(count_)), 1, 16);
    arena_->arena.execute([n, grain, &body] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, n, grain),
            [&body](const tbb::blocked_range<std::size_t>& range) {
                const int thread = tbb::this_task_arena::current_thread_index();
                for (std::size_t i = range.begin(); i != range.end(); ++i) body(i, thread);
            },
            tbb::simple_partitioner());
    });
}

void Threads::set_poll(std::function<void()> poll) const {
    poller_ = std::this_thread::get_id();
    poll_ = std::move(poll);
}

} // namespace skein
