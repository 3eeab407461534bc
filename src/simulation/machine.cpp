#include "simulation/machine.hpp"

#include "core/level.hpp"
#include "kernels/kernels.hpp"
#include "parallel/threads.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <unistd.h>

#include <algorithm>

namespace skein {

std::string host_name() {
    char host[256] = "";
    ::gethostname(host, sizeof host - 1);
    return host;
}

int ranks_of_this_machine(const Communicator& comm) {
    const std::string mine = host_name();
    const auto hosts = comm.all_gather(mine);
    return static_cast<int>(std::count(hosts.begin(), hosts.end(), mine));
}

int lanes_for(int asked) {
    const int served = asked > 0 ? served_lanes(asked) : widest_lanes();
    try {
        return kernels(served).lanes;
    } catch (const InputError&) { // a plan for other processors needs no kernels here
        return served;
    }
}

int lanes_to_choose_from(int asked, int lanes) { return asked > 0 || lanes_for(1) == lanes ? 0 : lanes; }

Machine machine_of(const Communicator& comm, int threads, int lanes_wanted, Mapping mapping) {
    const std::string cores = Threads::available_core_list();
    const auto bindings = comm.all_gather(host_name() + ':' + cores);
    const int sharing = static_cast<int>(std::count(bindings.begin(), bindings.end(), nth(bindings, comm.rank())));
    const int own = std::max(1, Threads::available_cores() / sharing);
    std::string which = cores;
    if (sharing > 1) {
        which += " shared by " + std::to_string(sharing);
    } else {
        constexpr std::size_t shown = 8;
        for (std::size_t r = 1; r < std::min(shown, bindings.size()); ++r)
            which += " | " + bindings[r].substr(bindings[r].rfind(':') + 1);
        if (bindings.size() > shown) which += " | ...";
    }
    // Equal on all ranks, those of an older processor too.
    const auto lanes = static_cast<int>(comm.min(static_cast<std::int64_t>(lanes_for(lanes_wanted))));
    return {.ranks = comm.size(),
            .threads = threads > 0 ? threads : own,
            .cores = own,
            .lanes = lanes,
            .which_cores = which,
            .mapping = mapping,
            .most_lanes = lanes_to_choose_from(lanes_wanted, lanes)};
}

} // namespace skein
