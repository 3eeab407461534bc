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

    /// What is to be sent must not change, nor what is to come be read, until finish().
    void start();
    /// Lets them move on.
    void poll();
    void finish();

private:
    struct Requests;
    std::unique_ptr<Requests> requests_; ///< null where there are none
};

/// Whether all ranks say yes.
class Vote {
public:
    explicit Vote(const Communicator& comm);
    Vote(const Vote&) = delete;
    Vote& operator=(const Vote&) = delete;
    ~Vote();

    void start(bool yes);
    /// Lets it move on.
    void poll();
    bool finish();

private:
    struct Ballot;
    std::unique_ptr<Ballot> ballot_;
};

/// From now on messages and votes take at least so long from start to finish, s; for studies of how much of it is
/// hidden by work.
void delay_messages(double seconds);

} // namespace skein
