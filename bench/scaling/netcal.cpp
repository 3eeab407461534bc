// What messages cost on this machine, into a machine file that `skein plan --ranks P --machine FILE` reads.
//   mpirun -n RANKS netcal [--out machine.toml] [--threads T] [--pairs 28] [--batches 15]
// Start it as a run is started: as many ranks per node, as many threads, the same binding. Two ranks at least; on two
// nodes at least where runs take several, as the file then holds what goes between nodes (the table on the screen has
// both). link.hpp says what latency, overhead and bandwidth are.
#include "scaling/link.hpp"
#include "skein/core/index.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/os.h>
#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

using namespace skein::bench;

constexpr int ghosts = 256 << 10;        ///< bytes, as long as a message of many ghosts is
constexpr std::size_t copied = 32 << 20; ///< bytes that a core copies: more than its share of the caches

/// Of a core, B/s, each byte read once and written once; the least over ranks while `threads` of each copy at once.
double copy_bandwidth(int threads, int batches) {
    std::vector<std::vector<char>> from(static_cast<std::size_t>(threads)), to(from.size());
    const auto with_all = [&](const std::function<void(std::size_t)>& act) {
        std::vector<std::thread> others;
        for (std::size_t t = 1; t < from.size(); ++t) others.emplace_back(act, t);
        act(0);
        for (std::thread& other : others) other.join();
    };
    with_all([&](std::size_t t) { // who touches a page first has it near
        from[t].assign(copied, 1);
        to[t].assign(copied, 0);
    });
    double seconds = time_of(MPI_COMM_WORLD, batches, [&] {
        with_all([&](std::size_t t) { std::memcpy(to[t].data(), from[t].data(), copied); });
    });
    MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return static_cast<double>(copied) / seconds;
}

/// The machine, and what all ranks do at once.
struct All {
    int ranks = 0, nodes = 0, ranks_per_node = 0, cores_per_node = 0, threads = 0;
    double bandwidth = 0, allreduce = 0, copy = 0, copy_all = 0; ///< of a rank, B/s; s; of a core, B/s
};

/// The figures of the slowest rank. The same on all ranks.
void measure_all(All& all, int batches) {
    const int rank = rank_of(MPI_COMM_WORLD), far = all.ranks / 2;
    double number = rank, sum = 0;
    double reduced =
        time_of(MPI_COMM_WORLD, batches, [&] { MPI_Allreduce(&number, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD); });
    Exchange exchange(MPI_COMM_WORLD, (rank + far) % all.ranks, (rank + all.ranks - far) % all.ranks, 1, ghosts);
    double exchanged = time_of(MPI_COMM_WORLD, batches, std::ref(exchange));
    for (double* seconds : {&reduced, &exchanged})
        MPI_Allreduce(MPI_IN_PLACE, seconds, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    all.allreduce = reduced;
    all.bandwidth = ghosts / exchanged;
    all.copy = copy_bandwidth(1, batches);
    all.copy_all = copy_bandwidth(all.threads, batches);
}

/// Numbers of cores: those that this rank may use, and those that the ranks of its node may use.
std::pair<int, int> cores_of(MPI_Comm node) {
    cpu_set_t own, all;
    if (sched_getaffinity(0, sizeof own, &own) != 0) return {1, size_of(node)};
    MPI_Allreduce(&own, &all, sizeof own, MPI_BYTE, MPI_BOR, node);
    return {CPU_COUNT(&own), CPU_COUNT(&all)};
}

/// Number of the node of each rank: the least rank on it.
std::vector<int> nodes_of_ranks(MPI_Comm node) {
    int first = rank_of(MPI_COMM_WORLD);
    MPI_Bcast(&first, 1, MPI_INT, 0, node);
    std::vector<int> nodes(static_cast<std::size_t>(size_of(MPI_COMM_WORLD)));
    MPI_Allgather(&first, 1, MPI_INT, nodes.data(), 1, MPI_INT, MPI_COMM_WORLD);
    return nodes;
}

/// Broadcasts a link. Ranks that wait for it sleep in between: a pair that is measured may need their cores.
void broadcast(Link& link, int from) {
    MPI_Request request;
    MPI_Ibcast(&link, sizeof link, MPI_BYTE, from, MPI_COMM_WORLD, &request);
    for (int done = 0; !done;) {
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (!done) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

/// Links of pairs within nodes and between them, one pair after the other. The same on all ranks.
std::array<std::vector<Link>, 2> measure_links(const std::vector<int>& nodes, int most_pairs, int batches) {
    std::array<std::vector<Link>, 2> links;
    const int rank = rank_of(MPI_COMM_WORLD);
    for (const auto& [a, b] : pairs_of(size_of(MPI_COMM_WORLD), most_pairs)) {
        MPI_Comm pair;
        MPI_Comm_split(MPI_COMM_WORLD, rank == a || rank == b ? 0 : MPI_UNDEFINED, rank, &pair);
        Link link;
        if (pair != MPI_COMM_NULL) {
            link = measure_link(pair, batches);
            MPI_Comm_free(&pair);
        }
        broadcast(link, a);
        links[skein::nth(nodes, a) == skein::nth(nodes, b) ? 0 : 1].push_back(link);
    }
    return links;
}

std::string list_of(const auto& values, const char* format) {
    std::string text;
    for (const auto value : values) text += (text.empty() ? "" : ", ") + fmt::format(fmt::runtime(format), value);
    return "[" + text + "]";
}

void show(const char* where, std::size_t pairs, const Link& link) {
    fmt::print(
        "{} ({} pair{}): latency {:.2f} us, overhead {:.2f} us a message, bandwidth {:.2f} GB/s, misfit {:.2f}\n\n",
        where, pairs, pairs == 1 ? "" : "s", 1e6 * link.latency, 1e6 * link.overhead, 1e-9 * link.bandwidth,
        link.misfit);
    fmt::print("{:>10}{:>12}{:>12}{:>10}{:>26}\n", "bytes", "us", "GB/s", "ratio", "to latency + n/bandwidth");
    for (std::size_t k = 0; k < link.times.size(); ++k) {
        const double bytes = message_bytes[k];
        fmt::print("{:>10}{:>12.2f}{:>12.3f}{:>10.2f}\n", bytes, 1e6 * link.times[k], 1e-9 * bytes / link.times[k],
                   link.times[k] / (link.latency + bytes / link.bandwidth));
    }
    fmt::print("\n");
}

/// `where`: between which ranks `link` is.
void write_machine(const std::string& file, const char* where, const Link& link, const All& all) {
    fmt::output_file(file).print(
        "# Messages {}, as netcal measured them; read by skein plan --ranks P --machine FILE.\n"
        "[network]\n"
        "latency_s = {:.4g}\n"
        "overhead_s = {:.4g} # a message sent and one received, beyond the first\n"
        "bandwidth_B_per_s = {:.4g} # one pair of ranks alone\n"
        "bandwidth_all_B_per_s = {:.4g} # a rank, while all send and receive at once\n"
        "allreduce_s = {:.4g} # one number, over all ranks\n"
        "misfit = {:.4g} # largest ratio of message_s to latency_s + message_bytes / bandwidth_B_per_s\n"
        "message_bytes = {}\n"
        "message_s = {} # one way\n"
        "[machine]\n"
        "processor = '{}'\n"
        "ranks = {}\n"
        "nodes = {}\n"
        "ranks_per_node = {}\n"
        "cores_per_node = {} # that the ranks of a node may use\n"
        "threads_per_rank = {}\n"
        "copy_B_per_s = {:.4g} # by one core of each rank, from memory to memory\n"
        "copy_all_B_per_s = {:.4g} # by each of all cores at once\n",
        where, link.latency, link.overhead, link.bandwidth, all.bandwidth, all.allreduce, link.misfit,
        list_of(message_bytes, "{}"), list_of(link.times, "{:.4g}"), processor(), all.ranks, all.nodes,
        all.ranks_per_node, all.cores_per_node, all.threads, all.copy, all.copy_all);
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app(
        "Measures messages between ranks and writes a machine file. Start it under mpirun as a run is started.");
    std::string out = "machine.toml";
    int threads = 0, most_pairs = 28, batches = 15;
    app.add_option("--out", out, "machine file")->take_last()->capture_default_str();
    app.add_option("--threads", threads, "threads per rank; default: its share of the cores that it may use")
        ->check(CLI::PositiveNumber);
    app.add_option("--pairs", most_pairs, "pairs of ranks that are measured, at most")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("--batches", batches, "measurements of each figure")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);

    int level = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
    const int rank = rank_of(MPI_COMM_WORLD), ranks = size_of(MPI_COMM_WORLD);
    const auto leave = [&](int code, const std::string& message) {
        if (rank == 0 && !message.empty()) fmt::print(stderr, "error: {}\n", message);
        MPI_Finalize();
        return code;
    };
    if (ranks < 2) return leave(2, "two ranks are needed: mpirun -n 2 netcal, or as many as a run has");

    int writes = rank != 0 || std::ofstream(out, std::ios::app).good(); // said now, not after a minute
    MPI_Bcast(&writes, 1, MPI_INT, 0, MPI_COMM_WORLD);
    if (!writes) return leave(5, fmt::format("{}: {}", out, std::strerror(errno)));

    MPI_Comm node;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank, MPI_INFO_NULL, &node);
    const std::vector<int> nodes = nodes_of_ranks(node);
    const auto [own_cores, node_cores] = cores_of(node);
    int per_node = size_of(node), cores_per_node = node_cores;
    int own =
        std::max(1, std::min(own_cores, node_cores / per_node)); // ranks that are bound to the same cores share them
    MPI_Allreduce(MPI_IN_PLACE, &per_node, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &cores_per_node, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &own, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (threads == 0) threads = own;
    MPI_Comm_free(&node);

    const auto links = measure_links(nodes, most_pairs, batches);
    All all{
        .ranks = ranks, .nodes = 0, .ranks_per_node = per_node, .cores_per_node = cores_per_node, .threads = threads};
    for (int r = 0; r < ranks; ++r) all.nodes += skein::nth(nodes, r) == r;
    measure_all(all, batches);
    if (rank != 0) return leave(0, "");

    const char* const names[] = {"within a node", "between nodes"};
    const std::size_t used = links[1].empty() ? 0 : 1;
    for (std::size_t where : {0u, 1u})
        if (!links[where].empty()) show(names[where], links[where].size(), median_of(links[where]));
    const Link link = median_of(links[used]);
    fmt::print("all ranks at once, {} kB each way: {:.2f} GB/s a rank and direction; all-reduce of a number over {} "
               "ranks: {:.2f} us\n"
               "copies of {} MB: {:.2f} GB/s by one core of each rank, {:.2f} GB/s a core by {} of each\n",
               ghosts >> 10, 1e-9 * all.bandwidth, ranks, 1e6 * all.allreduce, copied >> 20, 1e-9 * all.copy,
               1e-9 * all.copy_all, threads);
    if (!(link.overhead > 0)) return leave(1, "32 messages took no longer than one: other programs disturb; try again");
    write_machine(out, names[used], link, all);
    fmt::print("{} is written\n", out);
    return leave(0, "");
}
