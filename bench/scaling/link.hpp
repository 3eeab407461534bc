// The cost of messages between two ranks: latency, overhead, bandwidth, and how well these three describe it.
//
// A rank that starts m messages at once, of n bytes in all, has them after latency + (m - 1) overhead + n / bandwidth:
//   latency    half a round trip of 8 B between two ranks, while the others wait
//   overhead   what one more message to send and one more to receive, of 8 B each, add to an exchange of persistent
//   messages bandwidth  such that latency + n / bandwidth is nearest to half round trips of 8 B to 8 MB: the largest
//   ratio of the two, the
//              misfit, is least. Libraries send short and long messages by different ways, so 2 is usual and 4 is much.
// Medians over batches of some 2 ms, then over pairs of ranks.
#pragma once

#include "measure.hpp"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace skein::bench {

constexpr std::array<int, 8> message_bytes = {8, 64, 512, 4 << 10, 32 << 10, 256 << 10, 2 << 20, 8 << 20};
constexpr int small = 8; ///< bytes
constexpr int many = 32; ///< messages at once
constexpr double batch_s = 2e-3;
using Times = std::array<double, message_bytes.size()>; ///< s, one way

/// Of one pair of ranks, or the medians of many.
struct Link {
    double latency = 0, overhead = 0, bandwidth = 0, misfit = 0;
    Times times{};
};

inline int rank_of(MPI_Comm comm) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    return rank;
}

inline int size_of(MPI_Comm comm) {
    int size = 0;
    MPI_Comm_size(comm, &size);
    return size;
}

/// Median time [s] of `act`, which all ranks of `comm` do together; that of its rank 0.
inline double time_of(MPI_Comm comm, int batches, const std::function<void()>& act) {
    std::vector<double> seconds;
    int repeats = 1;
    const auto batch = [&] {
        MPI_Barrier(comm);
        const double begin = MPI_Wtime();
        for (int i = 0; i < repeats; ++i) act();
        return MPI_Wtime() - begin;
    };
    batch(); // first messages set up their ways
    for (double last = 0; last < 0.5 * batch_s && repeats < (1 << 16);) {
        repeats *= 2;
        last = batch();
        MPI_Bcast(&last, 1, MPI_DOUBLE, 0, comm);
    }
    for (int b = 0; b < batches; ++b) seconds.push_back(batch() / repeats);
    return median(seconds);
}

/// Persistent messages, as runs have them: `count` to one rank and as many from another, of `bytes` each.
class Exchange {
public:
    Exchange(MPI_Comm comm, int to, int from, int count, int bytes)
        : out_(data(count, bytes)), in_(data(count, bytes)) {
        for (int i = 0; i < count; ++i) {
            const auto at = static_cast<std::ptrdiff_t>(i) * bytes;
            MPI_Recv_init(in_.data() + at, bytes, MPI_BYTE, from, i, comm, &requests_.emplace_back());
            MPI_Send_init(out_.data() + at, bytes, MPI_BYTE, to, i, comm, &requests_.emplace_back());
        }
    }
    ~Exchange() {
        for (MPI_Request& request : requests_) MPI_Request_free(&request);
    }
    Exchange(const Exchange&) = delete;
    Exchange& operator=(const Exchange&) = delete;

    void operator()() {
        MPI_Startall(static_cast<int>(requests_.size()), requests_.data());
        MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    }

private:
    static std::vector<char> data(int count, int bytes) {
        return std::vector<char>(static_cast<std::size_t>(count) * static_cast<std::size_t>(bytes), 1);
    }
    std::vector<char> out_, in_;
    std::vector<MPI_Request> requests_;
};

/// Largest ratio of a measured time to latency + n / bandwidth, or its inverse.
inline double misfit(double latency, double bandwidth, const Times& times) {
    double most = 1;
    for (std::size_t k = 0; k < times.size(); ++k) {
        const double ratio = times[k] / (latency + message_bytes[k] / bandwidth);
        most = std::max({most, ratio, 1 / ratio});
    }
    return most;
}

/// The bandwidth of least misfit, by a search over seven decades in steps of 1 %.
inline double fitted_bandwidth(double latency, const Times& times) {
    double best = 1e6;
    for (double b = 1e6; b < 1e13; b *= 1.01)
        if (misfit(latency, b, times) < misfit(latency, best, times)) best = b;
    return best;
}

inline Link measure_link(MPI_Comm pair, int batches) {
    Link link;
    const int me = rank_of(pair), other = 1 - me;
    std::vector<char> data(message_bytes.back(), 1);
    for (std::size_t k = 0; k < message_bytes.size(); ++k) {
        const int bytes = message_bytes[k];
        link.times[k] = 0.5 * time_of(pair, batches, [&] {
                            if (me == 0) MPI_Send(data.data(), bytes, MPI_BYTE, other, 0, pair);
                            MPI_Recv(data.data(), bytes, MPI_BYTE, other, 0, pair, MPI_STATUS_IGNORE);
                            if (me == 1) MPI_Send(data.data(), bytes, MPI_BYTE, other, 0, pair);
                        });
    }
    Exchange one(pair, other, other, 1, small), more(pair, other, other, many, small);
    for (int tries = 0; link.overhead <= 0 && tries < 5;
         ++tries) { // a moment of other programs can outlast 31 messages
        link.overhead = (time_of(pair, batches, std::ref(more)) - time_of(pair, batches, std::ref(one))) / (many - 1);
        MPI_Bcast(&link.overhead, 1, MPI_DOUBLE, 0, pair);
    }
    link.latency = link.times[0];
    link.bandwidth = fitted_bandwidth(link.latency, link.times);
    return link;
}

/// At most `most` pairs of ranks, spread evenly over all.
inline std::vector<std::pair<int, int>> pairs_of(int ranks, int most) {
    std::vector<std::pair<int, int>> all, some;
    for (int a = 0; a < ranks; ++a)
        for (int b = a + 1; b < ranks; ++b) all.emplace_back(a, b);
    const std::size_t wanted = std::min(all.size(), static_cast<std::size_t>(most));
    for (std::size_t i = 0; i < wanted; ++i) some.push_back(all[i * all.size() / wanted]);
    return some;
}

inline Link median_of(const std::vector<Link>& links) {
    const auto over = [&](const std::function<double(const Link&)>& part) {
        std::vector<double> values;
        for (const Link& link : links) values.push_back(part(link));
        return median(values);
    };
    Link found;
    for (std::size_t k = 0; k < found.times.size(); ++k)
        found.times[k] = over([k](const Link& l) { return l.times[k]; });
    found.latency = found.times[0];
    found.overhead = over([](const Link& l) { return l.overhead; });
    found.bandwidth = fitted_bandwidth(found.latency, found.times);
    found.misfit = misfit(found.latency, found.bandwidth, found.times);
    return found;
}

} // namespace skein::bench
