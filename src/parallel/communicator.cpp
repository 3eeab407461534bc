#include "parallel/communicator.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iterator>
#include <limits>
#include <new>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace skein {

namespace {

constexpr std::int64_t largest_count = std::numeric_limits<int>::max();

Communicator::Traffic counted;

MPI_Comm native(int handle) { return MPI_Comm_f2c(handle); }

template <class T> MPI_Datatype datatype();
template <> MPI_Datatype datatype<std::int64_t>() { return MPI_INT64_T; }
template <> MPI_Datatype datatype<std::uint64_t>() { return MPI_UINT64_T; }
template <> MPI_Datatype datatype<double>() { return MPI_DOUBLE; }

template <class T> void reduce(int handle, std::span<T> values, MPI_Op op) {
    for (std::size_t done = 0; done < values.size();) {
        const auto count = std::min<std::size_t>(values.size() - done, largest_count);
        MPI_Allreduce(MPI_IN_PLACE, values.data() + done, static_cast<int>(count), datatype<T>(), op, native(handle));
        ++counted.calls;
        done += count;
    }
}

template <class T> T reduced(int handle, T value, MPI_Op op) {
    reduce(handle, std::span<T>(&value, 1), op);
    return value;
}

void send_from(int source, int handle, std::span<std::byte> bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        const auto count = std::min<std::size_t>(bytes.size() - done, largest_count);
        MPI_Bcast(bytes.data() + done, static_cast<int>(count), MPI_BYTE, source, native(handle));
        ++counted.calls;
        done += count;
    }
}

std::string text_from(int source, int handle, std::string text) {
    auto length = static_cast<std::int64_t>(text.size());
    send_from(source, handle, std::as_writable_bytes(std::span(&length, 1)));
    text.resize(to_index(length));
    send_from(source, handle, std::as_writable_bytes(std::span(text)));
    return text;
}

/// Counts and offsets as MPI wants them, in records.
struct Layout {
    std::vector<int> counts, offsets;

    explicit Layout(std::span<const std::int64_t> records) : counts(records.size()), offsets(records.size()) {
        std::int64_t offset = 0;
        for (std::size_t r = 0; r < records.size(); ++r) {
            counts[r] = static_cast<int>(records[r]);
            offsets[r] = static_cast<int>(offset);
            offset += records[r];
        }
    }
};

/// Bytes that stay together: counts are in records, so that only their number, not their bytes, has to fit an int.
struct Record {
    MPI_Datatype type;

    explicit Record(std::size_t bytes) {
        MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &type);
        MPI_Type_commit(&type);
    }
    Record(const Record&) = delete;
    ~Record() { MPI_Type_free(&type); }
};

std::int64_t total(std::span<const std::int64_t> counts) {
    return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

} // namespace

Communicator Communicator::world() {
    Communicator comm;
    comm.handle_ = MPI_Comm_c2f(MPI_COMM_WORLD);
    MPI_Comm_rank(MPI_COMM_WORLD, &comm.rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &comm.size_);
    return comm;
}

Communicator Communicator::alone() {
    Communicator comm;
    comm.handle_ = MPI_Comm_c2f(MPI_COMM_SELF);
    return comm;
}

Communicator Communicator::duplicate() const {
    Communicator comm(*this);
    MPI_Comm duplicate;
    MPI_Comm_dup(native(handle_), &duplicate);
    comm.handle_ = MPI_Comm_c2f(duplicate);
    return comm;
}

void Communicator::free() {
    MPI_Comm comm = native(handle_);
    MPI_Comm_free(&comm);
}

void Communicator::barrier() const {
    MPI_Barrier(native(handle_));
    ++counted.calls;
}

std::int64_t Communicator::sum(std::int64_t value) const { return reduced(handle_, value, MPI_SUM); }
std::uint64_t Communicator::sum_wrapping(std::uint64_t value) const { return reduced(handle_, value, MPI_SUM); }
std::int64_t Communicator::max(std::int64_t value) const { return reduced(handle_, value, MPI_MAX); }
std::int64_t Communicator::min(std::int64_t value) const { return reduced(handle_, value, MPI_MIN); }
double Communicator::max(double value) const { return reduced(handle_, value, MPI_MAX); }
double Communicator::min(double value) const { return reduced(handle_, value, MPI_MIN); }
void Communicator::sum(std::span<std::int64_t> values) const { reduce(handle_, values, MPI_SUM); }
void Communicator::max(std::span<double> values) const { reduce(handle_, values, MPI_MAX); }

void Communicator::broadcast(std::span<std::byte> bytes) const { send_from(0, handle_, bytes); }
std::string Communicator::broadcast(std::string text) const { return text_from(0, handle_, std::move(text)); }
std::int64_t Communicator::broadcast(std::int64_t value) const {
    send_from(0, handle_, std::as_writable_bytes(std::span(&value, 1)));
    return value;
}

std::vector<std::int64_t> Communicator::all_gather(std::int64_t value) const {
    std::vector<std::int64_t> values(to_index(size_));
    MPI_Allgather(&value, 1, MPI_INT64_T, values.data(), 1, MPI_INT64_T, native(handle_));
    ++counted.calls;
    return values;
}

std::vector<std::string> Communicator::all_gather(const std::string& text) const {
    const Layout layout(all_gather(static_cast<std::int64_t>(text.size())));
    std::string all(to_index(layout.offsets.back() + layout.counts.back()), '\0');
    MPI_Allgatherv(text.data(), static_cast<int>(text.size()), MPI_CHAR, all.data(), layout.counts.data(),
                   layout.offsets.data(), MPI_CHAR, native(handle_));
    ++counted.calls;
    std::vector<std::string> texts;
    for (std::size_t r = 0; r < layout.counts.size(); ++r)
        texts.push_back(all.substr(to_index(layout.offsets[r]), to_index(layout.counts[r])));
    return texts;
}

void Communicator::all_gather(std::span<const double> mine, std::span<const std::int64_t> counts,
                              std::span<double> all) const {
    const Layout layout(counts);
    MPI_Allgatherv(mine.data(), static_cast<int>(mine.size()), MPI_DOUBLE, all.data(), layout.counts.data(),
                   layout.offsets.data(), MPI_DOUBLE, native(handle_));
    ++counted.calls;
    counted.bytes += static_cast<std::int64_t>(mine.size_bytes()) * (size_ - 1);
}

void Communicator::all_gather(std::span<const std::byte> mine, std::size_t record_bytes,
                              std::span<const std::int64_t> counts, std::span<std::byte> all) const {
    const Layout layout(counts);
    const Record record(record_bytes);
    MPI_Allgatherv(mine.data(), static_cast<int>(mine.size() / record_bytes), record.type, all.data(),
                   layout.counts.data(), layout.offsets.data(), record.type, native(handle_));
    ++counted.calls;
    counted.bytes += static_cast<std::int64_t>(mine.size_bytes()) * (size_ - 1);
}

std::vector<double> Communicator::all_gather(std::span<const double> mine) const {
    const auto counts = all_gather(static_cast<std::int64_t>(mine.size()));
    std::vector<double> all(to_index(total(counts)));
    all_gather(mine, counts, all);
    return all;
}

std::vector<std::byte> Communicator::all_to_all(std::span<const std::byte> records, std::size_t record_bytes,
                                                std::span<const std::int64_t> send_counts,
                                                std::vector<std::int64_t>& receive_counts) const {
    receive_counts.resize(to_index(size_));
    MPI_Alltoall(send_counts.data(), 1, MPI_INT64_T, receive_counts.data(), 1, MPI_INT64_T, native(handle_));
    ++counted.calls;

    const std::int64_t sent = total(send_counts), received = total(receive_counts);
    const std::int64_t largest = max(std::max({sent, received, static_cast<std::int64_t>(record_bytes)}));
    if (largest > largest_count)
        throw Error(Exit::internal, "all_to_all: " + std::to_string(largest) +
                                        " records on one rank are more than MPI can count; use more ranks");

    std::vector<std::byte> arrived(to_index(received) * record_bytes);
    const Layout out(send_counts), in(receive_counts);
    const Record record(record_bytes);
    MPI_Alltoallv(records.data(), out.counts.data(), out.offsets.data(), record.type, arrived.data(), in.counts.data(),
                  in.offsets.data(), record.type, native(handle_));
    ++counted.calls;
    counted.bytes += (sent - nth(send_counts, rank_)) * static_cast<std::int64_t>(record_bytes);
    return arrived;
}

std::string Communicator::first_text(const std::string& mine) const {
    const std::int64_t speaker = min(mine.empty() ? static_cast<std::int64_t>(size_) : rank_);
    return speaker == size_ ? std::string() : text_from(static_cast<int>(speaker), handle_, mine);
}

Communicator::Traffic Communicator::traffic() { return counted; }
void Communicator::count_messages(std::int64_t bytes, std::int64_t messages) {
    counted.bytes += bytes;
    counted.messages += messages;
}
void Communicator::count_call() { ++counted.calls; }

namespace {

void on_mpi_error(MPI_Comm*, int* code, ...) {
    char text[MPI_MAX_ERROR_STRING];
    int length = 0;
    MPI_Error_string(*code, text, &length);
    MpiSession::abort("MPI: " + std::string(text, to_index(length)), static_cast<int>(Exit::internal));
}

/// std::bad_alloc on one rank could be caught on the way to a collective call that the others are in.
void on_out_of_memory() { MpiSession::abort("out of memory", static_cast<int>(Exit::internal)); }

[[noreturn]] void on_terminate() {
    std::string message = "terminated without an exception";
    int code = static_cast<int>(Exit::internal);
    if (const auto exception = std::current_exception()) {
        try {
            std::rethrow_exception(exception);
        } catch (const Error& error) {
            message = error.what();
            code = static_cast<int>(error.code());
        } catch (const std::exception& error) {
            message = error.what();
        } catch (...) {
            message = "an exception of unknown type";
        }
    }
    MpiSession::abort(message, code);
}

/// True where a launcher has started this process, and its MPI library is to find the others.
bool launched() {
    constexpr const char* names[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMIX_NAMESPACE", "PMI_RANK", "PMI_FD"};
    return std::any_of(std::begin(names), std::end(names), [](const char* name) { return std::getenv(name); });
}

/// Settings of Open MPI while a process by itself initialises. It would start a daemon and look for networks, for most
/// of a second. All such processes have one job number without the daemon, so they must not share a directory of the
/// session either. What the user has set stays; other libraries do not read these. Afterwards the environment is as it
/// was but for the setting of files, as the library leaves variables there with which mpirun would fail in a process
/// that this one starts.
class AloneSettings {
public:
    AloneSettings() {
        for (char** variable = environ; *variable; ++variable) before_.insert(name_of(*variable));
        for (const auto& [name, value] :
             {std::pair("ess_singleton_isolated", "1"), std::pair("orte_create_session_dirs", "0"),
              std::pair("pml", "ob1"), std::pair("btl", "self"), std::pair(read_later, "individual")})
            setenv((prefix + std::string(name)).c_str(), value, 0);
    }
    ~AloneSettings() {
        std::vector<std::string> added;
        for (char** variable = environ; *variable; ++variable)
            if (const std::string name = name_of(*variable); !before_.contains(name) && name != prefix + read_later)
                added.push_back(name);
        for (const std::string& name : added) unsetenv(name.c_str());
    }
    AloneSettings(const AloneSettings&) = delete;
    AloneSettings& operator=(const AloneSettings&) = delete;

private:
    static inline const std::string prefix = "OMPI_MCA_";
    static constexpr const char* read_later = "sharedfp"; ///< when a file is opened
    static std::string name_of(const char* variable) { return {variable, std::strcspn(variable, "=")}; }

    std::set<std::string> before_;
};

} // namespace

MpiSession::MpiSession(int& argc, char**& argv) : exceptions_at_start_(std::uncaught_exceptions()) {
    std::optional<AloneSettings> alone;
    if (!launched()) alone.emplace();
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    if (provided < MPI_THREAD_FUNNELED)
        abort("this MPI library does not work beside threads", static_cast<int>(Exit::internal));
    MPI_Errhandler handler;
    MPI_Comm_create_errhandler(on_mpi_error, &handler);
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, handler);
    MPI_Errhandler_free(&handler);
    std::set_terminate(on_terminate);
    std::set_new_handler(on_out_of_memory);
}

MpiSession::~MpiSession() {
    // The others may wait for this rank in a collective call; MPI_Finalize would wait for them.
    if (std::uncaught_exceptions() > exceptions_at_start_)
        abort("left by an exception", static_cast<int>(Exit::internal));
    MPI_Finalize();
}

bool MpiSession::running() {
    int begun = 0, ended = 0;
    MPI_Initialized(&begun);
    MPI_Finalized(&ended);
    return begun && !ended;
}

void MpiSession::abort(const std::string& message, int code) {
    int rank = 0;
    const bool initialised = running();
    if (initialised) MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    std::fflush(stdout);
    std::fprintf(stderr, "rank %d: %s\n", rank, message.c_str());
    std::fflush(stderr);
    if (initialised) MPI_Abort(MPI_COMM_WORLD, code);
    std::_Exit(code);
}

} // namespace skein
