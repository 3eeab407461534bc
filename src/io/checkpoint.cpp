#include "io/checkpoint.hpp"

#include "io/disk.hpp"
#include "io/h5_file.hpp"
#include "io/own_files.hpp"
#include "partition/partition.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <future>
#include <numeric>
#include <optional>
#include <sstream>
#include <unistd.h>

namespace skein {

namespace {

const std::string checkpoint_format = "skein-checkpoint";
/// Version 2 has directors as quaternions, and the sums of an audit. Springs at walls have weights since 4 and no works
/// of their own since 5. Fluids have no gained velocities of rods since 6, and slips since 7. Works of contacts have
/// several numbers since 8.
constexpr std::int64_t format_version = 8, version_of_springs = 5, oldest_version = 2;

// Consecutive rods of a group that are transferred at a time: enough for full bandwidth, few beside the state.
constexpr std::int64_t slab_bytes_per_rank = 16 << 20;

struct Slab {
    std::int64_t begin, count;
};

/// Takes the numbers of local rod `local[j]` and their hash, on any thread.
using PutRecord = std::function<void(std::size_t j, std::span<const double> numbers, std::uint64_t hash)>;

/// Numbers of every rod of a group: a dataset [rods, rows, columns] of doubles.
struct Record {
    std::string dataset;
    std::uint64_t rows, columns;
    void (*take)(const Rods& rods, std::span<const std::size_t> local, const PutRecord& put);
    void (*put)(Rods& rods, std::size_t i, std::span<const double> in);

    std::size_t numbers() const { return rows * columns; }
    std::size_t bytes() const { return numbers() * sizeof(double); }
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
    return works;
}
std::vector<double> memory_of(const Rods& rods, std::size_t i) { return rods.memory(i); }

Record budget_record(const RodGroup& group, const Rods& rods) {
    const std::uint64_t works = rods.budgets_fluid(to_index(group.id())) ? 4 : 3;
    return {"/groups/" + group.name() + "/works", 1, works, take_numbers<budget_of>,
            [](Rods& to, std::size_t i, std::span<const double> in) {
                to.set_budget(i, {.loads = in[0],
                                  .walls = in[1],
                                  .dissipated = in[2],
                                  .held_before = 0,
                                  .fluid = in.size() > 3 ? in[3] : 0});
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

/// Records of a group; the first is its state.
std::vector<Record> records_of(const Communicator& comm, const RodGroup& group, const Rods& rods, bool audited) {
    std::vector<Record> all = {state_record(group)};
    if (audited) all.push_back(budget_record(group, rods));
    if (Record memory = memory_record(comm, group, rods); memory.columns > 0) all.push_back(std::move(memory));
    return all;
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

/// Writes a record of a group's rods and returns its digest.
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

/// Reads a record, into `rods` if given, and returns its digest. Throws IoError if the digest is wrong.
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

std::string saved_dataset(const SavedNumbers& saved) { return "/kept/" + saved.name; }

/// Box of this rank's part of `count` rows.
H5Box part_of(const Communicator& comm, std::size_t count) {
    const auto begin = [&](int rank) {
        return to_index(block_begin(static_cast<std::int64_t>(count), rank, comm.size()));
    };
    return {{begin(comm.rank())}, {begin(comm.rank() + 1) - begin(comm.rank())}};
}

/// Digest of the rows of all ranks; this rank's begin at number `first`. Collective.
std::uint64_t digest_of_rows(const Communicator& comm, std::uint64_t first, const SavedNumbers& saved) {
    return comm.sum_wrapping(sum_of_hashes(static_cast<std::int64_t>(first), saved.rows, saved.columns));
}

void write_rows(const Communicator& comm, H5File& file, const std::string& dataset, const SavedNumbers& saved) {
    const std::vector<std::int64_t> rows =
        comm.all_gather(static_cast<std::int64_t>(saved.rows.size() / saved.columns));
    const auto mine = rows.begin() + comm.rank();
    const auto first = static_cast<std::uint64_t>(std::accumulate(rows.begin(), mine, std::int64_t{0}));
    const std::int64_t all = std::accumulate(rows.begin(), rows.end(), std::int64_t{0});
    file.make_dataset(dataset, H5Type::float64,
                      {std::max<std::uint64_t>(1, static_cast<std::uint64_t>(all)), saved.columns});
    file.set(dataset, "rows", all);
    file.set(dataset, "columns", static_cast<std::int64_t>(saved.columns));
    file.set(dataset, "digest", digest_of_rows(comm, first, saved));
    if (all > 0)
        file.write(dataset, H5Type::float64, {{first, 0}, {static_cast<std::uint64_t>(*mine), saved.columns}},
                   saved.rows.data());
}

void write_saved(const Communicator& comm, H5File& file, const SavedNumbers& saved) {
    const std::string dataset = saved_dataset(saved);
    file.make_dataset(dataset, H5Type::float64, {std::max<std::uint64_t>(1, saved.numbers.size())});
    file.set(dataset, "digest", hash_numbers(0, saved.numbers));
    file.set(dataset, "count", static_cast<std::int64_t>(saved.numbers.size()));
    if (!saved.numbers.empty()) {
        const H5Box box = part_of(comm, saved.numbers.size());
        file.write(dataset, H5Type::float64, box, saved.numbers.data() + box.start[0]);
    }
    if (saved.columns > 0) write_rows(comm, file, dataset + "_rows", saved);
}

void read_rows(const Communicator& comm, const H5File& file, const std::string& path, const std::string& dataset,
               SavedNumbers& saved) {
    const auto rows = file.get<std::int64_t>(dataset, "rows");
    const H5Box part = part_of(comm, to_index(rows));
    saved.columns = to_index(file.get<std::int64_t>(dataset, "columns"));
    saved.rows.resize(part.count[0] * saved.columns);
    if (rows > 0)
        file.read(dataset, H5Type::float64, {{part.start[0], 0}, {part.count[0], saved.columns}}, saved.rows.data());
    if (digest_of_rows(comm, part.start[0], saved) != file.get<std::uint64_t>(dataset, "digest"))
        throw IoError(path + ": " + dataset + " is damaged");
}

void read_saved(const Communicator& comm, const H5File& file, const std::string& path, SavedNumbers& saved) {
    const std::string dataset = saved_dataset(saved);
    const std::size_t count = to_index(file.get<std::int64_t>(dataset, "count"));
    saved.numbers.resize(count);
    if (count > 0) file.read(dataset, H5Type::float64, {{0}, {count}}, saved.numbers.data());
    if (hash_numbers(0, saved.numbers) != file.get<std::uint64_t>(dataset, "digest"))
        throw IoError(path + ": " + dataset + " is damaged");
    if (file.has(dataset + "_rows")) read_rows(comm, file, path, dataset + "_rows", saved);
}

std::uint64_t file_bytes(const Communicator& comm, std::span<const RodGroup> groups, const Rods& rods,
                         const CheckpointInfo& info) {
    std::uint64_t bytes = info.scene.size() + info.settings.size() + info.ancestry.size();
    for (const RodGroup& group : groups)
        for (const Record& record : records_of(comm, group, rods, info.audited_from.has_value()))
            bytes += static_cast<std::uint64_t>(group.count()) * record.bytes();
    for (const SavedNumbers& saved : info.saved)
        bytes += saved.numbers.size() * sizeof(double) +
                 static_cast<std::uint64_t>(comm.sum(static_cast<std::int64_t>(saved.rows.size() * sizeof(double))));
    return bytes;
}

std::string frames_text(const std::map<std::string, std::int64_t>& last) {
    std::string text;
    for (const auto& [name, step] : last) text += fmt::format("{} {}\n", name, step);
    return text;
}

void set_marks(H5File& file, const CheckpointInfo& info) {
    if (!info.stage_begins.empty()) {
        file.set("/", "stage_begins", fmt::format("{}", fmt::join(info.stage_begins, " ")));
        file.set("/", "stage_work", info.stage_work);
        file.set("/", "stage_over", std::int64_t(info.stage_over));
        if (info.stage_over) {
            file.set("/", "stage_defect", info.stage_defect);
            file.set("/", "stage_contacts", info.stage_contacts);
        }
    }
    if (info.series) {
        file.set("/", "series_bytes", info.series->bytes);
        file.set("/", "series_digest", info.series->digest);
        if (!info.series->row.empty()) file.set("/", "series_row", info.series->row);
    }
    if (info.last_trajectory) file.set("/", "last_trajectory", *info.last_trajectory);
    if (info.last_tips) file.set("/", "last_tips", *info.last_tips);
    if (!info.last_frames.empty()) file.set("/", "last_frames", frames_text(info.last_frames));
}

void get_marks(const H5File& file, CheckpointInfo& info) {
    if (const auto bytes = file.find<std::uint64_t>("/", "series_bytes"))
        info.series = {*bytes, file.get<std::uint64_t>("/", "series_digest"),
                       file.find<std::string>("/", "series_row").value_or("")};
    std::istringstream begins(file.find<std::string>("/", "stage_begins").value_or(""));
    for (double begin = 0; begins >> begin;) info.stage_begins.push_back(begin);
    info.stage_over = file.find<std::int64_t>("/", "stage_over").value_or(0) != 0;
    info.stage_defect = file.find<double>("/", "stage_defect").value_or(0);
    info.stage_contacts = file.find<double>("/", "stage_contacts").value_or(0);
    info.stage_work = file.find<double>("/", "stage_work").value_or(0);
    info.last_trajectory = file.find<std::int64_t>("/", "last_trajectory");
    info.last_tips = file.find<std::int64_t>("/", "last_tips");
    std::istringstream lines(file.find<std::string>("/", "last_frames").value_or(""));
    std::int64_t step = 0;
    for (std::string name; lines >> name >> step;) info.last_frames[name] = step;
}

/// Digest of all texts, because HDF5 has no checksums on attributes of more than 4 kB.
std::uint64_t texts_digest(const CheckpointInfo& info) {
    std::uint64_t digest = text_digest(info.scene);
    digest = text_digest(info.settings, digest);
    digest = text_digest(info.ancestry, digest);
    digest = text_digest(frames_text(info.last_frames), digest);
    return info.series ? text_digest(info.series->row, digest) : digest;
}

/// `bytes` is the size of the file.
void write_state(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups, const Rods& rods,
                 const CheckpointInfo& info, std::uint64_t bytes) {
    H5File file(comm, path, H5File::Mode::create);
    file.reserve(bytes);
    file.set("/", "format", checkpoint_format);
    file.set("/", "version", format_version);
    file.set("/", "step", info.step);
    file.set("/", "dt", info.dt);
    file.set("/", "digest", info.digest);
    if (info.beyond != 0) file.set("/", "digest_beyond_rods", info.beyond);
    file.set("/", "scene", info.scene);
    file.set("/", "audited", std::int64_t(info.audited_from.has_value()));
    if (info.audited_from) file.set("/", "audited_from", *info.audited_from);
    set_marks(file, info);
    if (info.shift != 0) file.set("/", "shift", info.shift);
    if (!info.settings.empty()) file.set("/", "settings", info.settings);
    if (!info.ancestry.empty()) file.set("/", "ancestry", info.ancestry);
    file.set("/", "texts_digest", texts_digest(info));
    file.make_group("/groups");
    std::uint64_t digest = 0;
    for (const RodGroup& group : groups) {
        file.make_group("/groups/" + group.name());
        const auto records = records_of(comm, group, rods, info.audited_from.has_value());
        for (const Record& record : records) {
            const std::uint64_t of_record = write_record(comm, file, group, record, rods);
            if (&record == &records.front()) digest += of_record;
        }
    }
    if (!info.saved.empty()) file.make_group("/kept");
    for (const SavedNumbers& saved : info.saved) write_saved(comm, file, saved);
    if (digest += info.beyond; digest != info.digest)
        throw IoError(fmt::format("{}: the state changed while it was written (digest {:016x}, before {:016x})", path,
                                  digest, info.digest));
    file.close();
}

std::uint64_t read_state(const Communicator& comm, const H5File& file, const std::string& path,
                         std::span<const RodGroup> groups, bool audited, const Rods& owned_by, Rods* rods,
                         bool may_begin_memory = false) {
    std::uint64_t digest = 0;
    for (const RodGroup& group : groups) {
        const auto records = records_of(comm, group, owned_by, audited);
        for (const Record& record : records) {
            if (may_begin_memory && &record != &records.front() && !file.has(record.dataset)) continue;
            const std::uint64_t of_record = read_record(comm, file, path, group, record, owned_by, rods);
            if (&record == &records.front()) digest += of_record;
        }
    }
    return digest;
}

CheckpointInfo read_info(const H5File& file, const std::string& path);

/// Reads the file back, since a disk may silently keep wrong bytes.
void verify(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups,
            const CheckpointInfo& info, const Rods& rods) {
    H5File file(comm, path, H5File::Mode::read);
    read_info(file, path);
    read_state(comm, file, path, groups, info.audited_from.has_value(), rods, nullptr);
    for (const SavedNumbers& saved : info.saved) {
        SavedNumbers found{.name = saved.name};
        read_saved(comm, file, path, found);
    }
    file.close();
}

/// Removes checkpoints up to `step` by `keeping`. Later ones were unreadable at the resume and are renamed *.damaged.
/// Files of such a name that are no checkpoints stay.
void thin(const std::string& directory, std::int64_t step, const Keeping& keeping) {
    std::vector<std::int64_t> steps;
    const auto files = numbered_files(directory, "checkpoint_", ".h5");
    for (const NumberedFile& file : files)
        if (file.number <= step) steps.push_back(file.number);
    const auto kept = kept_steps(steps, keeping);
    for (const NumberedFile& file : files) {
        const std::string path = directory + "/" + file.name;
        if (std::binary_search(kept.begin(), kept.end(), file.number) || h5_format(path) != checkpoint_format) continue;
        if (file.number > step) set_aside(path, path + ".damaged");
        else remove_file(path);
    }
}

} // namespace

void write_checkpoint(const Communicator& comm, const std::string& directory, std::span<const RodGroup> groups,
                      const Rods& rods, const CheckpointInfo& info, const Keeping& keeping) {
    const std::string path = fmt::format("{}/checkpoint_{:012d}.h5", directory, info.step);
    const std::string temporary = path + ".tmp";
    try {
        const std::uint64_t bytes = file_bytes(comm, groups, rods, info);
        on_root(comm, [&] {
            require_space(directory, bytes);
            make_way(temporary, checkpoint_format);
        });
        write_state(comm, temporary, groups, rods, info, bytes);
        verify(comm, temporary, groups, info, rods);
        on_root(comm, [&] {
            make_way(path, checkpoint_format);
            publish(temporary, path);
        });
    } catch (const IoError&) {
        if (comm.root() && is_unfinished(temporary, checkpoint_format)) ::unlink(temporary.c_str());
        throw;
    }
    on_root(comm, [&] { thin(directory, info.step, keeping); });
}

namespace {

/// Lines "  /rods/0/length: was 1, now 2" for the first keys that differ.
std::string scene_differences(const std::string& old_text, const std::string& new_text) {
    using nlohmann::json;
    constexpr int most = 8;
    const json was = json::parse(old_text, nullptr, false).flatten(),
               now = json::parse(new_text, nullptr, false).flatten();
    json all = was;
    all.update(now);
    std::string lines;
    int count = 0;
    for (const auto& item : all.items()) {
        const auto value_in = [&item](const json& scene) {
            return scene.contains(item.key()) ? scene[item.key()].dump() : "absent";
        };
        const std::string before = value_in(was), after = value_in(now);
        if (before == after || ++count > most) continue;
        lines += fmt::format("\n  {}: was {}, now {}", item.key(), before, after);
    }
    return count > most ? fmt::format("{}\n  and {} more", lines, count - most) : lines;
}

CheckpointInfo read_info(const H5File& file, const std::string& path) {
    const auto format = file.get<std::string>("/", "format");
    if (format != checkpoint_format) throw IoError(path + ": is not a checkpoint (format \"" + format + "\")");
    CheckpointInfo info;
    info.file = path;
    info.version = file.get<std::int64_t>("/", "version");
    if (info.version < oldest_version || info.version > format_version)
        throw InputError(fmt::format("{}: the format has version {}, but this program reads versions {} to {}", path,
                                     info.version, oldest_version, format_version));
    info.step = file.get<std::int64_t>("/", "step");
    info.dt = file.get<double>("/", "dt");
    info.digest = file.get<std::uint64_t>("/", "digest");
    info.beyond = file.find<std::uint64_t>("/", "digest_beyond_rods").value_or(0);
    info.scene = file.get<std::string>("/", "scene");
    info.shift = file.find<double>("/", "shift").value_or(0);
    info.settings = file.find<std::string>("/", "settings").value_or("");
    info.ancestry = file.find<std::string>("/", "ancestry").value_or("");
    if (file.get<std::int64_t>("/", "audited")) info.audited_from = file.get<double>("/", "audited_from");
    get_marks(file, info);
    const auto written = file.find<std::uint64_t>("/", "texts_digest"); // absent in files of earlier programs
    if (written && *written != texts_digest(info))
        throw IoError(path + ": the scene or the settings in it are damaged");
    return info;
}

} // namespace

std::vector<std::string> checkpoint_files(const Communicator& comm, const std::string& directory) {
    std::vector<std::string> names;
    on_root(comm, [&] {
        for (const auto& file : numbered_files(directory, "checkpoint_", ".h5")) names.push_back(file.name);
    });
    return broadcast_names(comm, names);
}

CheckpointInfo read_checkpoint_info(const Communicator& comm, const std::string& path) {
    H5File file(comm, path, H5File::Mode::read);
    CheckpointInfo info = read_info(file, path);
    file.close();
    return info;
}

CheckpointInfo load_checkpoint(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups,
                               Rods& rods, const std::function<void(const CheckpointInfo&)>& accept,
                               std::span<const std::string> saved, bool may_begin_memory) {
    H5File file(comm, path, H5File::Mode::read);
    CheckpointInfo info = read_info(file, path);
    accept(info);
    const bool in_fluid = std::find(saved.begin(), saved.end(), "fluid") != saved.end();
    if (info.version < (in_fluid ? format_version : version_of_springs) && !saved.empty())
        throw InputError(fmt::format("{}: the format has version {}, which saved contacts, walls or rods in a fluid "
                                     "differently; finish that run "
                                     "with the program that began it, or start anew with --overwrite",
                                     path, info.version));
    if (read_state(comm, file, path, groups, info.audited_from.has_value(), rods, &rods, may_begin_memory) +
            info.beyond !=
        info.digest)
        throw IoError(path + ": the digest of the whole state differs");
    for (const std::string& name : saved)
        read_saved(comm, file, path, info.saved.emplace_back(SavedNumbers{.name = name}));
    file.close();
    return info;
}

namespace {

/// Names of the checkpoints, newest first. It removes unfinished ones of a killed run.
std::vector<std::string> list_checkpoints(const Communicator& comm, const std::string& directory) {
    on_root(comm, [&] {
        for (const auto& file : numbered_files(directory, "checkpoint_", ".h5.tmp"))
            if (is_unfinished(directory + "/" + file.name, checkpoint_format)) remove_file(directory + "/" + file.name);
    });
    std::vector<std::string> list = checkpoint_files(comm, directory);
    std::reverse(list.begin(), list.end());
    return list;
}

} // namespace

std::optional<CheckpointInfo> read_checkpoint(const Communicator& comm, const std::string& directory,
                                              std::span<const RodGroup> groups, Rods& rods, const std::string& scene,
                                              const std::function<void(const std::string&)>& warn,
                                              std::span<const std::string> saved,
                                              const std::function<void(const CheckpointInfo&)>& accept,
                                              const std::string& newest) {
    auto names = list_checkpoints(comm, directory);
    if (const auto first = std::find_if(names.begin(), names.end(),
                                        [&](const std::string& name) { return directory + "/" + name == newest; });
        first != names.end())
        names.erase(names.begin(), first);
    const auto same_scene = [&](const CheckpointInfo& info) {
        if (info.scene != scene)
            throw InputError(
                info.file +
                ": belongs to another scene; `skein branch` continues from it with changed numbers, --overwrite "
                "starts anew, or restore:" +
                scene_differences(info.scene, scene));
        if (accept) accept(info);
    };
    for (const std::string& name : names) {
        try {
            return load_checkpoint(comm, directory + "/" + name, groups, rods, same_scene, saved);
        } catch (const IoError& error) {
            if (comm.root()) warn(error.what());
        }
    }
    if (names.empty()) return std::nullopt;
    throw IoError(fmt::format("{}: none of its {} checkpoints can be read; start anew with --overwrite", directory,
                              names.size()));
}

} // namespace skein
