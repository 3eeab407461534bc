// Messages that are the same in every step, and a question put to all ranks while they go on working.
#pragma once

#include "parallel/communicator.hpp"

#include <cstddef>
#include <memory>
#include <span>

namespace skein {

/// Between this rank and some others: set up once, started and awaited many times.
class RepeatedMessages {
public:
    struct Part {
        int rank;
        std::span<std::byte> bytes; ///< must stay where they are
    };
    RepeatedMessages();
    RepeatedMessages(const Communicator& comm, std::span<const Part> sent, std::span<const Part> received);
    RepeatedMessages(RepeatedMessages&&) noexcept;
    RepeatedMessages& operator=(RepeatedMessages&&) noexcept;
    ~RepeatedMessages();

    /// Starts all messages. Until finish(), sent memory must not change and received memory must not be read.
    void start();
    /// Lets messages progress.
    void poll();
    void finish();

private:
    struct Requests;
    std::unique_ptr<Requests> requests_; ///< null where there are none
};

/// Vote of all ranks: true where all say yes.
class Vote {
public:
    explicit Vote(const Communicator& comm);
    Vote(const Vote&) = delete;
    Vote& operator=(const Vote&) = delete;
    ~Vote();

    void start(bool yes);
    /// Lets the vote progress.
    void poll();
    bool finish();

private:
    struct Ballot;
    std::unique_ptr<Ballot> ballot_;
};

/// Delays messages and votes from now on: they take at least so long from start to finish, s. Studies find with it how
/// much of them work hides.
void delay_messages(double seconds);

} // namespace skein
