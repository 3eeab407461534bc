#include "parallel/messages.hpp"

#include "core/timer.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <mpi.h>

#include <limits>
#include <string>
#include <vector>

namespace skein {

namespace {

constexpr int tag = 1;
double least_delay = 0; // s

MPI_Comm native_of(const Communicator& comm) { return MPI_Comm_f2c(comm.handle()); }

/// Waits for requests until they are done, and not before the delay of a study is over.
void wait(std::span<MPI_Request> requests, double started) {
    while (least_delay > 0 && wall_seconds() < started + least_delay) {
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

} // namespace

struct RepeatedMessages::Requests {
    std::vector<MPI_Request> all;
    std::int64_t bytes = 0, messages = 0; ///< sent
    double started = 0;                   ///< wall time, s
    Requests() = default;
    Requests(const Requests&) = delete;
    ~Requests() {
        for (MPI_Request& request : all) MPI_Request_free(&request);
    }
};

RepeatedMessages::RepeatedMessages() = default;
RepeatedMessages::RepeatedMessages(RepeatedMessages&&) noexcept = default;
RepeatedMessages& RepeatedMessages::operator=(RepeatedMessages&&) noexcept = default;
RepeatedMessages::~RepeatedMessages() = default;

RepeatedMessages::RepeatedMessages(const Communicator& comm, std::span<const Part> sent,
                                   std::span<const Part> received) {
    if (sent.empty() && received.empty()) return;
    requests_ = std::make_unique<Requests>();
    for (const auto parts : {sent, received})
        for (const Part& part : parts)
            if (part.bytes.size() > to_index(std::numeric_limits<int>::max()))
                throw Error(Exit::internal, "a message of " + std::to_string(part.bytes.size()) + " bytes to rank " +
                                                std::to_string(part.rank) +
                                                " is longer than MPI can count; use more ranks");
    for (const Part& part : received)
        MPI_Recv_init(part.bytes.data(), static_cast<int>(part.bytes.size()), MPI_BYTE, part.rank, tag, native_of(comm),
                      &requests_->all.emplace_back());
    for (const Part& part : sent) {
        MPI_Send_init(part.bytes.data(), static_cast<int>(part.bytes.size()), MPI_BYTE, part.rank, tag, native_of(comm),
                      &requests_->all.emplace_back());
        if (part.rank == comm.rank()) continue;
        requests_->bytes += static_cast<std::int64_t>(part.bytes.size());
        ++requests_->messages;
    }
}

void RepeatedMessages::start() {
    if (!requests_) return;
    requests_->started = wall_seconds();
    MPI_Startall(static_cast<int>(requests_->all.size()), requests_->all.data());
    Communicator::count_messages(requests_->bytes, requests_->messages);
}

void RepeatedMessages::poll() {
    int done = 0;
    if (requests_)
        MPI_Testall(static_cast<int>(requests_->all.size()), requests_->all.data(), &done, MPI_STATUSES_IGNORE);
}

void RepeatedMessages::finish() {
    if (requests_) wait(requests_->all, requests_->started);
}

struct Vote::Ballot {
    MPI_Comm comm;
    MPI_Request request = MPI_REQUEST_NULL;
    int no = 0, any_no = 0;
    double started = 0;
};

Vote::Vote(const Communicator& comm) : ballot_(std::make_unique<Ballot>()) { ballot_->comm = native_of(comm); }
Vote::~Vote() = default;

void Vote::start(bool yes) {
    Ballot& b = *ballot_;
    b.no = !yes;
    b.started = wall_seconds();
    MPI_Iallreduce(&b.no, &b.any_no, 1, MPI_INT, MPI_MAX, b.comm, &b.request);
    Communicator::count_call();
}

void Vote::poll() {
    int done = 0;
    MPI_Test(&ballot_->request, &done, MPI_STATUS_IGNORE);
}

bool Vote::finish() {
    wait({&ballot_->request, 1}, ballot_->started);
    return ballot_->any_no == 0;
}

void delay_messages(double seconds) { least_delay = seconds; }

} // namespace skein
