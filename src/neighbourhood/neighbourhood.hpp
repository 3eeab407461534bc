// Boundary between ranks. Ghosts of a rank are the elements of others' bodies that may touch its own. They are no halo
// of a domain, so no shape of one can lose a contact. Both ranks work out what such a pair does, so no loads are sent
// back. Ghosts change at rebuilds of candidates only. In between, every step sends the same messages to the same ranks.
#pragma once

#include "neighbourhood/exposure.hpp"
#include "parallel/communicator.hpp"
#include "parallel/messages.hpp"
#include "parallel/threads.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace skein {

/// Figures of the ghosts of this rank, and of the messages it sends in a step.
struct GhostFigures {
    std::int64_t bodies = 0, elements = 0; ///< ghosts here
    std::int64_t neighbours = 0;           ///< ranks that ghosts come from, or go to
    std::int64_t messages = 0, bytes = 0;  ///< sent a step
};

/// Time in which this rank has waited for others since the beginning, s.
struct WaitFigures {
    double vote = 0;    ///< for all ranks to say whether lists hold
    double ghosts = 0;  ///< then, for the ghosts of the step
    double rebuild = 0; ///< for places of all ranks and for visitors, when ghosts are found anew
};

struct Visitors; ///< elements on their way to another rank

class Neighbourhood {
public:
    static constexpr std::uint32_t gone = UINT32_MAX;
    static constexpr std::size_t runs_of_task =
        128; ///< windows whose numbers a thread copies to or from messages at a time

    /// `exposure`: of own bodies. Collective.
    Neighbourhood(const Communicator& comm, const Threads& threads, std::shared_ptr<Exposure> exposure);
    Neighbourhood(const Neighbourhood&) = delete;
    ~Neighbourhood();

    /// Binds the exposure of other own bodies. A rebuild of ghosts must follow.
    void rebind(std::shared_ptr<Exposure> exposure);

    /// Starts to send the exposure of own elements to the ranks whose ghosts they are. Starts a vote on whether lists
    /// of partners hold on all ranks. Loops until arrive() let both progress (Threads::poll).
    void publish(bool holds);
    /// Ghosts are as their owners have exposed them; true where lists hold on all ranks.
    bool arrive();

    /// Own bodies, and all elements of others that may be within `reach` of them, m: places, radii and paces, which are
    /// set from the speeds now. Collective.
    const Exposure& widen(double reach);
    /// Keeps the elements that are wanted, by slot of widen(), as ghosts, and lets them arrive. Returns where each of
    /// its slots is now, or `gone`. Collective.
    std::vector<std::uint32_t> narrow(std::span<const std::uint8_t> wanted);

    const Exposure& exposure() const { return *exposure_; }
    const GhostFigures& figures() const { return figures_; }
    /// Collective.
    std::vector<GhostFigures> figures_of_ranks() const;
    /// Collective.
    std::vector<WaitFigures> waits_of_ranks() const;

private:
    /// Consecutive slots on their way: here, and where they begin in a message.
    struct Run {
        std::uint32_t first_slot, slots;
        std::size_t at;
    };
    /// Runs of slots in one direction, by rank.
    struct Route {
        std::vector<Run> runs;
        std::vector<double> numbers;
        std::vector<RepeatedMessages::Part> parts;

        void begin();
        void add(std::uint32_t first_slot, std::uint32_t slots);
        /// Behind the runs of a rank. Only when all are there have they a place in memory.
        void end_of_rank(int rank);
        void settle();

    private:
        std::size_t size_ = 0, begun_ = 0;
        struct Length {
            int rank;
            std::size_t first, count; ///< numbers
        };
        std::vector<Length> lengths_;
    };
    template <class Copy> void for_numbers(Route& route, Copy&& copy);
    void pack();
    void unpack();
    void make_wide(const Visitors& visitors, std::span<const std::int64_t> runs_of_rank);
    void set_up_messages();

    const Communicator comm_;
    Communicator channel_; ///< communicator of messages and votes
    const Threads& threads_;
    std::shared_ptr<Exposure> exposure_;
    std::unique_ptr<Exposure> wide_; ///< between widen and narrow
    std::vector<int> wide_rank_;     ///< rank of each of its windows
    std::vector<int> rank_of_;       ///< rank of each window of exposure_
    Route sent_, received_;
    RepeatedMessages messages_;
    Vote vote_;
    bool holds_ = false; ///< vote of one rank
    GhostFigures figures_;
    WaitFigures waits_;
};

} // namespace skein
