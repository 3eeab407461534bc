#include "io/checkpoint.hpp"

#include "io/disk.hpp"
#include "io/h5_file.hpp"
#include "io/own_files.hpp"
#include "partition/partition.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <future>
#include <numeric>
#include <optional>
#include <sstream>
#include <unistd.h>

namespace skein {

namespace {

const std::string format_name = "skein-checkpoint";
/// 2: directors are quaternions; with an audit, its sums.
constexpr std::int64_t format_version = 8, // before 8 works of contacts were kept as one number each, before 7 fluids
                                           // were kept without slips, before 6 with velocities that rods gained
    version_of_springs = 5, // before 5 springs at walls were kept with works of their own, before 4 without a weight
    oldest_version = 2;

// A slab is a run of a group's rods that is moved between owners and file at a time: enough for full bandwidth, little
// beside the state itself.
constexpr std::int64_t slab_bytes_per_rank = 16 << 20;

struct Slab {
    std::int64_t begin, count;
};

/// Takes the numbers of local rod `local[j]` and their hash; called by any thread.
using PutRecord = std::function<void(std::size_t j, std::span<const double> numbers, std::uint64_t hash)>;

/// What is kept of every rod of a group: a dataset [rods, rows, columns] of doubles.
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

Record budget_record(const RodGroup& group) {
    return {"/groups/" + group.name() + "/works", 1, 3,
            [](const Rods& rods, std::span<const std::size_t> local, const PutRecord& put) {
                for (std::size_t j = 0; j < local.size(); ++j) {
                    const RodBudget w = rods.budget(local[j]);
                    const double numbers[] = {w.loads, w.walls, w.dissipated};
                    put(j, numbers, hash_numbers(rods.local()[local[j]].gid, numbers));
                }
            },
            [](Rods& rods, std::size_t i, std::span<const double> in) {
                rods.set_budget(i, {in[0], in[1], in[2]});
            }};
}

/// What passes remember of a rod (springs of friction at walls); no columns where they remember nothing.
Record memory_record(const Communicator& comm, const RodGroup& group, const Rods& rods) {
    std::size_t numbers = 0;
    const auto local = rods.local();
    for (std::size_t i = 0; i < local.size() && numbers == 0; ++i)
        if (local[i].group == group.id()) numbers = rods.memory(i).size();
    numbers = static_cast<std::size_t>(comm.max(static_cast<std::int64_t>(numbers)));
    return {"/groups/" + group.name() + "/memory", 1, numbers,
            [](const Rods& from, std::span<const std::size_t> local, const PutRecord& put) {
                for (std::size_t j = 0; j < local.size(); ++j) {
                    const std::vector<double> numbers = from.memory(local[j]);
                    put(j, numbers, hash_numbers(from.local()[local[j]].gid, numbers));
                }
            },
            [](Rods& to, std::size_t i, std::span<const double> in) { to.set_memory(i, in); }};
}

/// Every record that a group has; the first is its state.
std::vector<Record> records_of(const Communicator& comm, const RodGroup& group, const Rods& rods, bool audited) {
    std::vector<Record> all = {state_record(group)};
    if (audited) all.push_back(budget_record(group));
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

/// The rods of a slab that this rank owns.
struct Share {
    std::vector<std::size_t> local;    ///< places in Rods::local()
    std::vector<std::int64_t> indices; ///< in the slab
};

/// Of every slab of a group.
std::vector<Share> shares(const Rods& rods, const RodGroup& group, std::span<const Slab> slabs) {
    std::vector<Share> found(slabs.size());
    const auto all = rods.local();
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].group != group.id()) continue;
        const auto slab = static_cast<std::size_t>(all[i].index / slabs[0].count); // but for the last they are equal
        found[slab].local.push_back(i);
        found[slab].indices.push_back(all[i].index - slabs[slab].begin);
    }
    return found;
}

template <class T> std::span<T> part(std::vector<T>& all, std::size_t i, const Record& record) {
    return std::span(all).subspan(i * record.numbers(), record.numbers());
}

/// `begin`, `size`: of the block, in the slab.
H5Box box_of(const Record& record, const Slab& slab, std::int64_t begin, std::int64_t size) {
    return {{static_cast<std::uint64_t>(slab.begin + begin), 0, 0},
            {static_cast<std::uint64_t>(size), record.rows, record.columns}};
}

/// Writes a record of a group's rods; returns its digest.
std::uint64_t write_record(const Communicator& comm, H5File& file, const RodGroup& group, const Record& record,
                           const Rods& rods) {
    file.make_dataset(record.dataset, H5Type::float64,
                      {static_cast<std::uint64_t>(group.count()), record.rows, record.columns});
    const std::vector<Slab> all = slabs(comm, group, record);
    const std::vector<Share> owned = shares(rods, group, all);
    // One slab is made ready while the one before is written. The writing stays on this thread: it alone calls MPI and
    // HDF5.
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

/// Reads a record, into `rods` where given, and returns its digest. Throws IoError where it is not what was written.
std::uint64_t read_record(const Communicator& comm, const H5File& file, const std::string& path, const RodGroup& group,
                          const Record& record, const Rods& owned_by, Rods* rods) {
    if (file.shape(record.dataset) !=
        std::vector<std::uint64_t>{static_cast<std::uint64_t>(group.count()), record.rows, record.columns})
        throw IoError(path + ": " + record.dataset + " has the wrong size");
    std::uint64_t written = 0, found = 0;
    file.get(record.dataset, "digest", written);
    const std::vector<Slab> all = slabs(comm, group, record);
    const std::vector<Share> shared = rods ? shares(owned_by, group, all) : std::vector<Share>(all.size());
    UnsetArray<double> kept;
    for (std::size_t s = 0; s < all.size(); ++s) {
        const Slab& slab = all[s];
        const std::int64_t begin = block_begin(slab.count, comm.rank(), comm.size()),
                           size = block_begin(slab.count, comm.rank() + 1, comm.size()) - begin;
        kept.need(static_cast<std::size_t>(size) * record.numbers());
        const std::span block(kept.data(), static_cast<std::size_t>(size) * record.numbers());
        file.read(record.dataset, H5Type::float64, box_of(record, slab, begin, size), block.data());
        found += sum_of_hashes(group.first_gid() + slab.begin + begin, block, record.numbers());
        if (!rods) continue;
        const Share& share = shared[s];
        const IndexBlocks blocks(comm, share.indices, slab.count);
        const auto bytes = blocks.to_owners(std::as_bytes(block), record.bytes());
        std::vector<double> owned(bytes.size() / sizeof(double));
        std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(owned)).begin());
        for (std::size_t i = 0; i < share.local.size(); ++i) record.put(*rods, share.local[i], part(owned, i, record));
    }
    found = comm.sum_wrapping(found);
    if (found != written)
        throw IoError(fmt::format("{}: {} is damaged (digest {:016x}, {:016x} was written)", path, record.dataset,
                                  found, written));
    return found;
}

std::string kept_dataset(const SavedNumbers& kept) { return "/kept/" + kept.name; }

/// This rank's part of numbers that all ranks have.
H5Box part_of(const Communicator& comm, std::size_t count) {
    const auto begin =
        static_cast<std::uint64_t>(block_begin(static_cast<std::int64_t>(count), comm.rank(), comm.size()));
    const auto end =
        static_cast<std::uint64_t>(block_begin(static_cast<std::int64_t>(count), comm.rank() + 1, comm.size()));
    return {{begin}, {end - begin}};
}

/// Of the rows of all ranks, this one's from number `first` on. Collective.
std::uint64_t digest_of_rows(const Communicator& comm, std::uint64_t first, const SavedNumbers& kept) {
    return comm.sum_wrapping(sum_of_hashes(static_cast<std::int64_t>(first), kept.rows, kept.columns));
}

void write_rows(const Communicator& comm, H5File& file, const std::string& dataset, const SavedNumbers& kept) {
    const std::vector<std::int64_t> rows = comm.all_gather(static_cast<std::int64_t>(kept.rows.size() / kept.columns));
    const auto mine = rows.begin() + comm.rank();
    const auto first = static_cast<std::uint64_t>(std::accumulate(rows.begin(), mine, std::int64_t{0}));
    const std::int64_t all = std::accumulate(rows.begin(), rows.end(), std::int64_t{0});
    file.make_dataset(dataset, H5Type::float64,
                      {std::max<std::uint64_t>(1, static_cast<std::uint64_t>(all)), kept.columns});
    file.set(dataset, "rows", all);
    file.set(dataset, "columns", static_cast<std::int64_t>(kept.columns));
    file.set(dataset, "digest", digest_of_rows(comm, first, kept));
    if (all > 0)
        file.write(dataset, H5Type::float64, {{first, 0}, {static_cast<std::uint64_t>(*mine), kept.columns}},
                   kept.rows.data());
}

void write_kept(const Communicator& comm, H5File& file, const SavedNumbers& kept) {
    const std::string dataset = kept_dataset(kept);
    file.make_dataset(dataset, H5Type::float64, {std::max<std::uint64_t>(1, kept.numbers.size())});
    file.set(dataset, "digest", hash_numbers(0, kept.numbers));
    file.set(dataset, "count", static_cast<std::int64_t>(kept.numbers.size()));
    if (!kept.numbers.empty()) {
        const H5Box box = part_of(comm, kept.numbers.size());
        file.write(dataset, H5Type::float64, box, kept.numbers.data() + box.start[0]);
    }
    if (kept.columns > 0) write_rows(comm, file, dataset + "_rows", kept);
}

void read_rows(const Communicator& comm, const H5File& file, const std::string& path, const std::string& dataset,
               SavedNumbers& kept) {
    std::int64_t rows = 0, columns = 0;
    std::uint64_t written = 0;
    file.get(dataset, "rows", rows);
    file.get(dataset, "columns", columns);
    file.get(dataset, "digest", written);
    const H5Box part = part_of(comm, static_cast<std::size_t>(rows));
    kept.columns = static_cast<std::size_t>(columns);
    kept.rows.resize(part.count[0] * kept.columns);
    if (rows > 0)
        file.read(dataset, H5Type::float64, {{part.start[0], 0}, {part.count[0], kept.columns}}, kept.rows.data());
    if (digest_of_rows(comm, part.start[0], kept) != written) throw IoError(path + ": " + dataset + " is damaged");
}

void read_kept(const Communicator& comm, const H5File& file, const std::string& path, SavedNumbers& kept) {
    const std::string dataset = kept_dataset(kept);
    std::int64_t count = 0;
    std::uint64_t written = 0;
    file.get(dataset, "count", count);
    file.get(dataset, "digest", written);
    kept.numbers.resize(static_cast<std::size_t>(count));
    if (count > 0) file.read(dataset, H5Type::float64, {{0}, {static_cast<std::uint64_t>(count)}}, kept.numbers.data());
    if (hash_numbers(0, kept.numbers) != written) throw IoError(path + ": " + dataset + " is damaged");
    if (file.has(dataset + "_rows")) read_rows(comm, file, path, dataset + "_rows", kept);
}

std::uint64_t file_bytes(const Communicator& comm, std::span<const RodGroup> groups, const Rods& rods,
                         const CheckpointInfo& info) {
    std::uint64_t bytes = info.scene.size() + info.settings.size() + info.ancestry.size();
    for (const RodGroup& group : groups)
        for (const Record& record : records_of(comm, group, rods, info.audited_from.has_value()))
            bytes += static_cast<std::uint64_t>(group.count()) * record.bytes();
    for (const SavedNumbers& kept : info.saved)
        bytes += kept.numbers.size() * sizeof(double) +
                 static_cast<std::uint64_t>(comm.sum(static_cast<std::int64_t>(kept.rows.size() * sizeof(double))));
    return bytes;
}

std::string frames_text(const std::map<std::string, std::int64_t>& last) {
    std::string text;
    for (const auto& [name, step] : last) text += fmt::format("{} {}\n", name, step);
    return text;
}

void set_marks(H5File& file, const CheckpointInfo& info) {
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
    if (file.has("/", "series_bytes")) {
        SeriesMark& mark = info.series.emplace();
        file.get("/", "series_bytes", mark.bytes);
        file.get("/", "series_digest", mark.digest);
        if (file.has("/", "series_row")) file.get("/", "series_row", mark.row);
    }
    if (file.has("/", "last_trajectory")) file.get("/", "last_trajectory", info.last_trajectory.emplace());
    if (file.has("/", "last_tips")) file.get("/", "last_tips", info.last_tips.emplace());
    if (file.has("/", "last_frames")) {
        std::string text;
        file.get("/", "last_frames", text);
        std::istringstream lines(text);
        std::int64_t step = 0;
        for (std::string name; lines >> name >> step;) info.last_frames[name] = step;
    }
}

/// HDF5 has checksums on short attributes, and none on texts of more than 4 kB.
std::uint64_t texts_digest(const CheckpointInfo& info) {
    std::uint64_t digest = text_digest(info.scene);
    digest = text_digest(info.settings, digest);
    digest = text_digest(info.ancestry, digest);
    digest = text_digest(frames_text(info.last_frames), digest);
    return info.series ? text_digest(info.series->row, digest) : digest;
}

/// `bytes`: of all of it.
void write_state(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups, const Rods& rods,
                 const CheckpointInfo& info, std::uint64_t bytes) {
    H5File file(comm, path, H5File::Mode::create);
    file.reserve(bytes);
    file.set("/", "format", format_name);
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
    for (const SavedNumbers& kept : info.saved) write_kept(comm, file, kept);
    if (digest += info.beyond; digest != info.digest)
        throw IoError(fmt::format("{}: the state changed while it was written (digest {:016x}, was {:016x})", path,
                                  digest, info.digest));
    file.close();
}

std::uint64_t read_state(const Communicator& comm, const H5File& file, const std::string& path,
                         std::span<const RodGroup> groups, bool audited, const Rods& owned_by, Rods* rods) {
    std::uint64_t digest = 0;
    for (const RodGroup& group : groups) {
        const auto records = records_of(comm, group, owned_by, audited);
        for (const Record& record : records) {
            const std::uint64_t of_record = read_record(comm, file, path, group, record, owned_by, rods);
            if (&record == &records.front()) digest += of_record;
        }
    }
    return digest;
}

CheckpointInfo read_info(const H5File& file, const std::string& path);

/// A disk may keep other bytes than it was given and say nothing.
void verify(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups,
            const CheckpointInfo& info, const Rods& rods) {
    H5File file(comm, path, H5File::Mode::read);
    read_info(file, path);
    read_state(comm, file, path, groups, info.audited_from.has_value(), rods, nullptr);
    for (const SavedNumbers& kept : info.saved) {
        SavedNumbers found{.name = kept.name};
        read_kept(comm, file, path, found);
    }
    file.close();
}

/// Removes what `keeping` lets go of the checkpoints up to `step`. Later ones are what a resumed run could not read and
/// has now passed by; files of such a name that are no checkpoints stay.
void thin(const std::string& directory, std::int64_t step, const Keeping& keeping) {
    std::vector<std::int64_t> steps;
    const auto files = numbered_files(directory, "checkpoint_", ".h5");
    for (const NumberedFile& file : files)
        if (file.number <= step) steps.push_back(file.number);
    const auto kept = kept_steps(steps, keeping);
    for (const NumberedFile& file : files) {
        const std::string path = directory + "/" + file.name;
        if (std::binary_search(kept.begin(), kept.end(), file.number) || h5_format(path) != format_name) continue;
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
            make_way(temporary, format_name);
        });
        write_state(comm, temporary, groups, rods, info, bytes);
        verify(comm, temporary, groups, info, rods);
        on_root(comm, [&] {
            make_way(path, format_name);
            publish(temporary, path);
        });
    } catch (const IoError&) {
        if (comm.root() && is_unfinished(temporary, format_name)) ::unlink(temporary.c_str());
        throw;
    }
    on_root(comm, [&] { thin(directory, info.step, keeping); });
}

namespace {

/// Lines "  /rods/0/length: was 1, now 2" for the first few keys that differ.
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
    std::string format;
    file.get("/", "format", format);
    if (format != format_name) throw IoError(path + ": is no checkpoint (format \"" + format + "\")");
    std::int64_t version = 0;
    file.get("/", "version", version);
    if (version < oldest_version || version > format_version)
        throw InputError(fmt::format("{}: version {} of the format; this program reads versions {} to {}", path,
                                     version, oldest_version, format_version));

    CheckpointInfo info;
    info.file = path;
    info.version = version;
    file.get("/", "step", info.step);
    file.get("/", "dt", info.dt);
    file.get("/", "digest", info.digest);
    if (file.has("/", "digest_beyond_rods")) file.get("/", "digest_beyond_rods", info.beyond);
    file.get("/", "scene", info.scene);
    if (file.has("/", "shift")) file.get("/", "shift", info.shift);
    if (file.has("/", "settings")) file.get("/", "settings", info.settings);
    if (file.has("/", "ancestry")) file.get("/", "ancestry", info.ancestry);
    std::int64_t audited = 0;
    file.get("/", "audited", audited);
    if (audited) file.get("/", "audited_from", info.audited_from.emplace());
    get_marks(file, info);
    if (file.has("/", "texts_digest")) { // earlier programs wrote none
        std::uint64_t written = 0;
        file.get("/", "texts_digest", written);
        if (written != texts_digest(info)) throw IoError(path + ": the scene or the settings in it are damaged");
    }
    return info;
}

} // namespace

std::vector<std::string> checkpoint_files(const Communicator& comm, const std::string& directory) {
    std::string names;
    on_root(comm, [&] {
        for (const auto& file : numbered_files(directory, "checkpoint_", ".h5")) names += file.name + "\n";
    });
    names = comm.broadcast(names);
    std::vector<std::string> list;
    for (std::size_t begin = 0, end; (end = names.find('\n', begin)) != names.npos; begin = end + 1)
        list.push_back(names.substr(begin, end - begin));
    return list;
}

CheckpointInfo read_checkpoint_info(const Communicator& comm, const std::string& path) {
    H5File file(comm, path, H5File::Mode::read);
    CheckpointInfo info = read_info(file, path);
    file.close();
    return info;
}

CheckpointInfo load_checkpoint(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups,
                               Rods& rods, const std::function<void(const CheckpointInfo&)>& accept,
                               std::span<const std::string> kept) {
    H5File file(comm, path, H5File::Mode::read);
    CheckpointInfo info = read_info(file, path);
    accept(info);
    const bool in_fluid = std::find(kept.begin(), kept.end(), "fluid") != kept.end();
    if (info.version < (in_fluid ? format_version : version_of_springs) && !kept.empty())
        throw InputError(fmt::format(
            "{}: version {} of the format, which kept contacts, walls or rods in a fluid otherwise; end that run with "
            "the program that began it, or begin anew",
            path, info.version));
    if (read_state(comm, file, path, groups, info.audited_from.has_value(), rods, &rods) + info.beyond != info.digest)
        throw IoError(path + ": the digest of the whole state differs");
    for (const std::string& name : kept)
        read_kept(comm, file, path, info.saved.emplace_back(SavedNumbers{.name = name}));
    file.close();
    return info;
}

namespace {

/// Names of the checkpoints, newest first. Unfinished ones of a killed run are removed.
std::vector<std::string> list_checkpoints(const Communicator& comm, const std::string& directory) {
    on_root(comm, [&] {
        for (const auto& file : numbered_files(directory, "checkpoint_", ".h5.tmp"))
            if (is_unfinished(directory + "/" + file.name, format_name)) remove_file(directory + "/" + file.name);
    });
    std::vector<std::string> list = checkpoint_files(comm, directory);
    std::reverse(list.begin(), list.end());
    return list;
}

} // namespace

std::optional<CheckpointInfo> read_checkpoint(const Communicator& comm, const std::string& directory,
                                              std::span<const RodGroup> groups, Rods& rods, const std::string& scene,
                                              const std::function<void(const std::string&)>& warn,
                                              std::span<const std::string> kept) {
    const auto names = list_checkpoints(comm, directory);
    const auto same_scene = [&scene](const CheckpointInfo& info) {
        if (info.scene != scene)
            throw InputError(
                info.file +
                ": belongs to another scene; `skein branch` goes on from it under other numbers, --overwrite "
                "starts anew; or mend:" +
                scene_differences(info.scene, scene));
    };
    for (const std::string& name : names) {
        try {
            return load_checkpoint(comm, directory + "/" + name, groups, rods, same_scene, kept);
        } catch (const IoError& error) {
            if (comm.root()) warn(error.what());
        }
    }
    if (names.empty()) return std::nullopt;
    throw IoError(fmt::format("{}: none of its {} checkpoints can be read; start anew with --overwrite", directory,
                              names.size()));
}

} // namespace skein
