// MPI behind a few verbs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Records of one type out of the bytes that they arrived in.
template <class T> std::vector<T> records_of(std::span<const std::byte> bytes) {
    std::vector<T> records(bytes.size() / sizeof(T));
    if (!records.empty()) std::memcpy(static_cast<void*>(records.data()), bytes.data(), bytes.size());
    return records;
}

/// All ranks of the run. Cheap to copy; collective calls are made by the main thread only (MPI_THREAD_FUNNELED).
class Communicator {
public:
    /// MPI_COMM_WORLD; MPI must have been initialised (see MpiSession).
    static Communicator world();
    /// This process by itself.
    static Communicator alone();

    /// Copy of the communicator with messages of its own; free() ends it. Both are collective.
    Communicator duplicate() const;
    void free();

    int rank() const { return rank_; }
    int size() const { return size_; }
    bool root() const { return rank_ == 0; }

    void barrier() const;
    std::int64_t sum(std::int64_t value) const;
    std::uint64_t sum_wrapping(std::uint64_t value) const; ///< modulo 2^64
    std::int64_t max(std::int64_t value) const;
    std::int64_t min(std::int64_t value) const;
    double max(double value) const;
    double min(double value) const;
    void sum(std::span<std::int64_t> values) const; ///< element by element, in place
    void max(std::span<double> values) const;
    /// Root's bytes (text, number) on every rank.
    void broadcast(std::span<std::byte> bytes) const;
    std::string broadcast(std::string text) const;
    std::int64_t broadcast(std::int64_t value) const;
    /// Every rank's value, by rank, on all ranks.
    std::vector<std::int64_t> all_gather(std::int64_t value) const;
    std::vector<std::string> all_gather(const std::string& text) const;
    /// Every rank's numbers, counts[r] of rank r, in rank order on all ranks.
    void all_gather(std::span<const double> mine, std::span<const std::int64_t> counts, std::span<double> all) const;
    /// Gathers records, bytes that stay together; `all` has room for those of all ranks.
    void all_gather(std::span<const std::byte> mine, std::size_t record_bytes, std::span<const std::int64_t> counts,
                    std::span<std::byte> all) const;
    /// Gathers numbers where only the rank itself knows how many it has.
    std::vector<double> all_gather(std::span<const double> mine) const;
    /// Sends send_counts[r] records of `record_bytes` each, packed in rank order, to every rank r; returns what
    /// arrived, in rank order, with its counts in `receive_counts`. At most 2^31 - 1 records each way; throws on all
    /// ranks alike beyond.
    std::vector<std::byte> all_to_all(std::span<const std::byte> records, std::size_t record_bytes,
                                      std::span<const std::int64_t> send_counts,
                                      std::vector<std::int64_t>& receive_counts) const;

    /// The text of the lowest rank that has one (empty: none has). For errors found on some rank only.
    std::string first_text(const std::string& mine) const;

    /// For io, for the library of multigrid, and within this module: MPI_Comm_f2c(handle()) is the MPI_Comm.
    int handle() const { return handle_; }

    /// Traffic of this rank so far: bytes and messages to single others, by all_to_all, all_gather and messages, and
    /// the number of collective calls of any kind.
    struct Traffic {
        std::int64_t bytes = 0, calls = 0, messages = 0;
    };
    static Traffic traffic();
    static void count_messages(std::int64_t bytes, std::int64_t messages);
    static void count_call();

private:
    int handle_ = 0; ///< as MPI numbers it for Fortran: an int with every MPI library
    int rank_ = 0, size_ = 1;
};

/// Session of MPI for the life of the object. An MPI error, lack of memory and an exception that nobody catches end
/// every rank through abort(), as does unwinding past the object. A rank that left alone would leave the others
/// waiting.
class MpiSession {
public:
    MpiSession(int& argc, char**& argv);
    ~MpiSession();
    MpiSession(const MpiSession&) = delete;
    MpiSession& operator=(const MpiSession&) = delete;
    /// True while MPI is initialised, by whomever.
    static bool running();
    /// Prints rank and message to stderr and ends all ranks.
    [[noreturn]] static void abort(const std::string& message, int code);

private:
    int exceptions_at_start_;
};

} // namespace skein
