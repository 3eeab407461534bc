#include "io/checkpoint_records.hpp"

#include "partition/partition.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <future>
#include <optional>

namespace skein {

namespace {

// Consecutive rods of a group that are transferred at a time: enough for full bandwidth, few beside the state.
constexpr std::int64_t slab_bytes_per_rank = 16 << 20;

struct Slab {
    std::int64_t begin, count;
};

Record state_record(const RodGroup& group) {
    return {"/groups/" + group.name() + "/state", static_cast<std::uint64_t>(group.slots()), slot_doubles,
            [](const Rods& rods, std::span<const std::size_t> local, const PutRecord& put) {
                rods.read(local, Copy::canonical, 0, [&](int, std::size_t j, const RodCopy& copy) {
                    put(j, {reinterpret_cast<const double*>(copy.state.data()), copy.state.size() * slot_doubles},
                        copy.hash);
                });
            },
            [](Rods& rods, std::size_t i, std::span<const double> in) {
                rods.import_rod(i, {reinterpret_cast<const Slot<1>*>(in.data()), in.size() / slot_doubles});
            }};
}

/// Record::take of the numbers that numbers_of(rods, i) returns for local rod i.
template <auto numbers_of>
void take_numbers(const Rods& rods, std::span<const std::size_t> local, const PutRecord& put) {
    for (std::size_t j = 0; j < local.size(); ++j) {
        const auto numbers = numbers_of(rods, local[j]);
        put(j, numbers, hash_numbers(rods.local()[local[j]].gid, numbers));
    }
}

std::vector<double> budget_of(const Rods& rods, std::size_t i) {
    const RodBudget w = rods.budget(i);
    std::vector<double> works{w.loads, w.walls, w.dissipated};
    if (rods.budgets_fluid(to_index(rods.local()[i].group))) works.push_back(w.fluid);
    if (rods.budgets_steps(to_index(rods.local()[i].group))) works.push_back(w.numerical);
    return works;
}
std::vector<double> memory_of(const Rods& rods, std::size_t i) { return rods.memory(i); }

Record budget_record(const RodGroup& group, const Rods& rods) {
    const std::size_t of = to_index(group.id());
    const std::uint64_t works = 3 + (rods.budgets_fluid(of) ? 1 : 0) + (rods.budgets_steps(of) ? 1 : 0);
    return {"/groups/" + group.name() + "/works", 1, works, take_numbers<budget_of>,
            [](Rods& to, std::size_t i, std::span<const double> in) {
                const bool in_fluid = to.budgets_fluid(to_index(to.local()[i].group));
                to.set_budget(i, {.loads = in[0],
                                  .walls = in[1],
                                  .dissipated = in[2],
                                  .held_before = 0,
                                  .fluid = in_fluid && in.size() > 3 ? in[3] : 0,
                                  .numerical = in.size() > (in_fluid ? 4 : 3) ? in.back() : 0});
            }};
}

/// Memory of passes, as springs of friction at walls; it has no columns if they have none.
Record memory_record(const Communicator& comm, const RodGroup& group, const Rods& rods) {
    std::size_t numbers = 0;
    const auto local = rods.local();
    for (std::size_t i = 0; i < local.size() && numbers == 0; ++i)
        if (local[i].group == group.id()) numbers = rods.memory(i).size();
    numbers = to_index(comm.max(static_cast<std::int64_t>(numbers)));
    return {"/groups/" + group.name() + "/memory", 1, numbers, take_numbers<memory_of>,
            [](Rods& to, std::size_t i, std::span<const double> in) { to.set_memory(i, in); }};
}

std::vector<Slab> slabs(const Communicator& comm, const RodGroup& group, const Record& record) {
    const std::int64_t rods =
        comm.size() * std::max<std::int64_t>(1, slab_bytes_per_rank / static_cast<std::int64_t>(record.bytes()));
    std::vector<Slab> found;
    for (std::int64_t begin = 0; begin < group.count(); begin += rods)
        found.push_back({begin, std::min(rods, group.count() - begin)});
    return found;
}

/// Rods of a slab that this rank owns.
struct Share {
    std::vector<std::size_t> local;    ///< numbers in Rods::local()
    std::vector<std::int64_t> indices; ///< indices in the slab
};

/// Shares of all slabs of a group.
std::vector<Share> shares(const Rods& rods, const RodGroup& group, std::span<const Slab> slabs) {
    std::vector<Share> found(slabs.size());
    const auto all = rods.local();
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].group != group.id()) continue;
        const std::size_t slab = to_index(all[i].index / slabs[0].count); // only the last one may be shorter
        found[slab].local.push_back(i);
        found[slab].indices.push_back(all[i].index - slabs[slab].begin);
    }
    return found;
}

/// Box of a block of a slab.
H5Box box_of(const Record& record, const Slab& slab, std::int64_t begin, std::int64_t size) {
    return {{static_cast<std::uint64_t>(slab.begin + begin), 0, 0},
            {static_cast<std::uint64_t>(size), record.rows, record.columns}};
}

} // namespace

std::vector<Record> records_of(const Communicator& comm, const RodGroup& group, const Rods& rods, bool audited) {
    std::vector<Record> all = {state_record(group)};
    if (audited) all.push_back(budget_record(group, rods));
    if (Record memory = memory_record(comm, group, rods); memory.columns > 0) all.push_back(std::move(memory));
    return all;
}

std::uint64_t write_record(const Communicator& comm, H5File& file, const RodGroup& group, const Record& record,
                           const Rods& rods) {
    file.make_dataset(record.dataset, H5Type::float64,
                      {static_cast<std::uint64_t>(group.count()), record.rows, record.columns});
    const std::vector<Slab> all = slabs(comm, group, record);
    const std::vector<Share> owned = shares(rods, group, all);
    // One slab is prepared while the one before is written. Only this thread calls MPI and HDF5.
    struct Ready {
        std::optional<IndexBlocks> blocks;
        RecordBuffers buffers;
        std::vector<std::uint64_t> hashes;
    } ready[2];
    const auto begin = [&](std::size_t s) {
        Ready& to = ready[s % 2];
        to.buffers.begin(to.blocks.emplace(comm, owned[s].indices, all[s].count), record.bytes());
        to.hashes.resize(owned[s].local.size());
    };
    const auto take = [&](std::size_t s) {
        Ready& to = ready[s % 2];
        record.take(rods, owned[s].local, [&](std::size_t j, std::span<const double> numbers, std::uint64_t hash) {
            std::memcpy(to.buffers.record(j), numbers.data(), record.bytes());
            to.hashes[j] = hash;
        });
    };
    const auto launch = rods.threads() > 1 ? std::launch::async : std::launch::deferred;
    std::uint64_t digest = 0;
    std::future<void> taken;
    const auto start = [&](std::size_t s) {
        begin(s);
        taken = std::async(launch, take, s);
    };
    if (!all.empty()) start(0);
    for (std::size_t s = 0; s < all.size(); ++s) {
        taken.get();
        Ready& now = ready[s % 2];
        for (const std::uint64_t hash : now.hashes) digest += hash;
        const auto block = now.buffers.exchange();
        if (s + 1 < all.size()) start(s + 1);
        file.write(record.dataset, H5Type::float64, box_of(record, all[s], now.blocks->begin(), now.blocks->size()),
                   block.data());
    }
    digest = comm.sum_wrapping(digest);
    file.set(record.dataset, "digest", digest);
    return digest;
}

std::uint64_t read_record(const Communicator& comm, const H5File& file, const std::string& path, const RodGroup& group,
                          const Record& record, const Rods& owned_by, Rods* rods) {
    if (file.shape(record.dataset) !=
        std::vector<std::uint64_t>{static_cast<std::uint64_t>(group.count()), record.rows, record.columns})
        throw IoError(path + ": " + record.dataset + " has the wrong size");
    const auto written = file.get<std::uint64_t>(record.dataset, "digest");
    std::uint64_t found = 0;
    const std::vector<Slab> all = slabs(comm, group, record);
    const std::vector<Share> shared = rods ? shares(owned_by, group, all) : std::vector<Share>(all.size());
    UnsetArray<double> buffer;
    for (std::size_t s = 0; s < all.size(); ++s) {
        const Slab& slab = all[s];
        const std::int64_t begin = block_begin(slab.count, comm.rank(), comm.size()),
                           size = block_begin(slab.count, comm.rank() + 1, comm.size()) - begin;
        buffer.need(to_index(size) * record.numbers());
        const std::span block(buffer.data(), to_index(size) * record.numbers());
        file.read(record.dataset, H5Type::float64, box_of(record, slab, begin, size), block.data());
        found += sum_of_hashes(group.first_gid() + slab.begin + begin, block, record.numbers());
        if (!rods) continue;
        const Share& share = shared[s];
        const IndexBlocks blocks(comm, share.indices, slab.count);
        const auto bytes = blocks.to_owners(std::as_bytes(block), record.bytes());
        std::vector<double> owned(bytes.size() / sizeof(double));
        std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(owned)).begin());
        for (std::size_t i = 0; i < share.local.size(); ++i)
            record.put(*rods, share.local[i], std::span(owned).subspan(i * record.numbers(), record.numbers()));
    }
    found = comm.sum_wrapping(found);
    if (found != written)
        throw IoError(fmt::format("{}: {} is damaged (its digest is {:016x} instead of {:016x})", path, record.dataset,
                                  found, written));
    return found;
}

} // namespace skein
