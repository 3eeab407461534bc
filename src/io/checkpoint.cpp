#include "io/checkpoint.hpp"

#include "core/error.hpp"
#include "io/disk.hpp"
#include "io/h5_file.hpp"
#include "partition/partition.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <unistd.h>

namespace skein {

namespace {

const std::string format_name = "skein-checkpoint";
/// 2: directors are quaternions; with an audit, its sums.
constexpr std::int64_t format_version = 2;

// A slab is a run of a group's rods that is moved between owners and file at a time: enough for full bandwidth, little
// beside the state itself.
constexpr std::int64_t slab_bytes_per_rank = 64 << 20;

struct Slab {
    std::int64_t begin, count;
};

/// What is kept of every rod of a group: a dataset [rods, rows, columns] of doubles.
struct Record {
    std::string dataset;
    std::uint64_t rows, columns;
    void (*take)(const Rods& rods, std::size_t i, std::span<double> out);
    void (*put)(Rods& rods, std::size_t i, std::span<const double> in);

    std::size_t numbers() const { return rows * columns; }
    std::size_t bytes() const { return numbers() * sizeof(double); }
};

Record state_record(const RodGroup& group) {
    return {"/groups/" + group.name() + "/state", static_cast<std::uint64_t>(group.slots()), slot_doubles,
            [](const Rods& rods, std::size_t i, std::span<double> out) {
                rods.export_rod(i, {reinterpret_cast<Slot<1>*>(out.data()), out.size() / slot_doubles});
            },
            [](Rods& rods, std::size_t i, std::span<const double> in) {
                rods.import_rod(i, {reinterpret_cast<const Slot<1>*>(in.data()), in.size() / slot_doubles});
            }};
}

Record works_record(const RodGroup& group) {
    return {"/groups/" + group.name() + "/works", 1, 3,
            [](const Rods& rods, std::size_t i, std::span<double> out) {
                const RodWorks w = rods.works(i);
                out[0] = w.loads, out[1] = w.walls, out[2] = w.dissipated;
            },
            [](Rods& rods, std::size_t i, std::span<const double> in) {
                rods.set_works(i, {in[0], in[1], in[2]});
            }};
}

std::vector<Slab> slabs(const Communicator& comm, const RodGroup& group, const Record& record) {
    const std::int64_t rods =
        comm.size() * std::max<std::int64_t>(1, slab_bytes_per_rank / static_cast<std::int64_t>(record.bytes()));
    std::vector<Slab> found;
    for (std::int64_t begin = 0; begin < group.count(); begin += rods)
        found.push_back({begin, std::min(rods, group.count() - begin)});
    return found;
}

/// The rods of a slab that this rank owns, and the slab's rods that it reads or writes.
struct Share {
    std::vector<std::size_t> local;    ///< places in Rods::local()
    std::vector<std::int64_t> indices; ///< in the slab

    Share(const Rods& rods, const RodGroup& group, const Slab& slab) {
        const auto all = rods.local();
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].group != group.id() || all[i].index < slab.begin || all[i].index >= slab.begin + slab.count) continue;
            local.push_back(i);
            indices.push_back(all[i].index - slab.begin);
        }
    }
};

template <class T> std::span<T> part(std::vector<T>& all, std::size_t i, const Record& record) {
    return std::span(all).subspan(i * record.numbers(), record.numbers());
}

H5Box box_of(const Record& record, const Slab& slab, const IndexBlocks& blocks) {
    return {{static_cast<std::uint64_t>(slab.begin + blocks.begin()), 0, 0},
            {static_cast<std::uint64_t>(blocks.size()), record.rows, record.columns}};
}

/// Writes a record of a group's rods; returns its digest.
std::uint64_t write_record(const Communicator& comm, H5File& file, const RodGroup& group, const Record& record, const Rods& rods) {
    file.make_dataset(record.dataset, H5Type::float64, {static_cast<std::uint64_t>(group.count()), record.rows, record.columns});
    std::uint64_t digest = 0;
    for (const Slab& slab : slabs(comm, group, record)) {
        const Share share(rods, group, slab);
        std::vector<double> owned(share.local.size() * record.numbers());
        for (std::size_t i = 0; i < share.local.size(); ++i) {
            const auto numbers = part(owned, i, record);
            record.take(rods, share.local[i], numbers);
            digest += hash_numbers(rods.local()[share.local[i]].gid, numbers);
        }
        const IndexBlocks blocks(comm, share.indices, slab.count);
        const auto block = blocks.to_blocks(std::as_bytes(std::span(owned)), record.bytes());
        file.write(record.dataset, H5Type::float64, box_of(record, slab, blocks), block.data());
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
    for (const Slab& slab : slabs(comm, group, record)) {
        const Share share(owned_by, group, slab);
        const IndexBlocks blocks(comm, share.indices, slab.count);
        std::vector<double> block(static_cast<std::size_t>(blocks.size()) * record.numbers());
        file.read(record.dataset, H5Type::float64, box_of(record, slab, blocks), block.data());
        for (std::int64_t i = 0; i < blocks.size(); ++i) {
            const std::int64_t gid = group.first_gid() + slab.begin + blocks.begin() + i;
            found += hash_numbers(gid, part(block, static_cast<std::size_t>(i), record));
        }
        if (!rods) continue;
        const auto bytes = blocks.to_owners(std::as_bytes(std::span(block)), record.bytes());
        std::vector<double> owned(bytes.size() / sizeof(double));
        std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(owned)).begin());
        for (std::size_t i = 0; i < share.local.size(); ++i) record.put(*rods, share.local[i], part(owned, i, record));
    }
    found = comm.sum_wrapping(found);
    if (found != written)
        throw IoError(fmt::format("{}: {} is damaged (digest {:016x}, {:016x} was written)", path, record.dataset, found, written));
    return found;
}

std::uint64_t file_bytes(std::span<const RodGroup> groups, const CheckpointInfo& info) {
    std::uint64_t bytes = info.scene.size();
    for (const RodGroup& group : groups)
        bytes += static_cast<std::uint64_t>(group.count()) *
                 (state_record(group).bytes() + (info.audited_from ? works_record(group).bytes() : 0));
    return bytes;
}

void write_state(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups, const Rods& rods,
                 const CheckpointInfo& info) {
    H5File file(comm, path, H5File::Mode::create);
    file.reserve(file_bytes(groups, info));
    file.set("/", "format", format_name);
    file.set("/", "version", format_version);
    file.set("/", "step", info.step);
    file.set("/", "dt", info.dt);
    file.set("/", "digest", info.digest);
    file.set("/", "scene", info.scene);
    file.set("/", "audited", std::int64_t(info.audited_from.has_value()));
    if (info.audited_from) file.set("/", "audited_from", *info.audited_from);
    file.make_group("/groups");
    std::uint64_t digest = 0;
    for (const RodGroup& group : groups) {
        file.make_group("/groups/" + group.name());
        digest += write_record(comm, file, group, state_record(group), rods);
        if (info.audited_from) write_record(comm, file, group, works_record(group), rods);
    }
    if (digest != info.digest)
        throw IoError(
            fmt::format("{}: the state changed while it was written (digest {:016x}, was {:016x})", path, digest, info.digest));
    file.close();
}

std::uint64_t read_state(const Communicator& comm, const H5File& file, const std::string& path, std::span<const RodGroup> groups,
                         bool audited, const Rods& owned_by, Rods* rods) {
    std::uint64_t digest = 0;
    for (const RodGroup& group : groups) {
        digest += read_record(comm, file, path, group, state_record(group), owned_by, rods);
        if (audited) read_record(comm, file, path, group, works_record(group), owned_by, rods);
    }
    return digest;
}

/// A disk may keep other bytes than it was given and say nothing.
void verify(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups, bool audited, const Rods& rods) {
    H5File file(comm, path, H5File::Mode::read);
    read_state(comm, file, path, groups, audited, rods, nullptr);
    file.close();
}

/// Keeps checkpoint `step` and the one before. Later ones are what a resumed run could not read and has now passed by.
void remove_others(const std::string& directory, std::int64_t step) {
    auto files = numbered_files(directory, "checkpoint_", ".h5");
    const auto newest = std::find_if(files.begin(), files.end(), [step](const NumberedFile& f) { return f.number == step; });
    if (newest != files.end()) files.erase(newest == files.begin() ? newest : newest - 1, newest + 1);
    for (const auto& file : files) remove_file(directory + "/" + file.name);
}

} // namespace

void write_checkpoint(const Communicator& comm, const std::string& directory, std::span<const RodGroup> groups, const Rods& rods,
                      const CheckpointInfo& info) {
    const std::string path = fmt::format("{}/checkpoint_{:012d}.h5", directory, info.step);
    const std::string temporary = path + ".tmp";
    try {
        on_root(comm, [&] { require_space(directory, file_bytes(groups, info)); });
        write_state(comm, temporary, groups, rods, info);
        verify(comm, temporary, groups, info.audited_from.has_value(), rods);
        on_root(comm, [&] { publish(temporary, path); });
    } catch (const IoError&) {
        if (comm.root()) ::unlink(temporary.c_str());
        throw;
    }
    on_root(comm, [&] { remove_others(directory, info.step); });
}

namespace {

/// Lines "  /rods/0/length: was 1, now 2" for the first few keys that differ.
std::string scene_differences(const std::string& old_text, const std::string& new_text) {
    using nlohmann::json;
    constexpr int most = 8;
    const json was = json::parse(old_text, nullptr, false).flatten(), now = json::parse(new_text, nullptr, false).flatten();
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

CheckpointInfo load(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups, Rods& rods,
                    const std::string& scene) {
    H5File file(comm, path, H5File::Mode::read);
    std::string format;
    file.get("/", "format", format);
    if (format != format_name) throw IoError(path + ": is no checkpoint (format \"" + format + "\")");
    std::int64_t version = 0;
    file.get("/", "version", version);
    if (version != format_version)
        throw InputError(fmt::format("{}: version {} of the format; this program reads version {}", path, version, format_version));

    CheckpointInfo info;
    info.file = path;
    file.get("/", "step", info.step);
    file.get("/", "dt", info.dt);
    file.get("/", "digest", info.digest);
    file.get("/", "scene", info.scene);
    if (info.scene != scene)
        throw InputError(
            path + ": belongs to another scene; start anew with --overwrite, or mend:" + scene_differences(info.scene, scene));
    std::int64_t audited = 0;
    file.get("/", "audited", audited);
    if (audited) file.get("/", "audited_from", info.audited_from.emplace());
    if (read_state(comm, file, path, groups, info.audited_from.has_value(), rods, &rods) != info.digest)
        throw IoError(path + ": the digest of the whole state differs");
    file.close();
    return info;
}

/// Names of the checkpoints, newest first. Unfinished ones of a killed run are removed.
std::vector<std::string> list_checkpoints(const Communicator& comm, const std::string& directory) {
    std::string names;
    on_root(comm, [&] {
        for (const auto& file : numbered_files(directory, "checkpoint_", ".h5.tmp")) remove_file(directory + "/" + file.name);
        for (const auto& file : numbered_files(directory, "checkpoint_", ".h5")) names = file.name + "\n" + names;
    });
    names = comm.broadcast(names);
    std::vector<std::string> list;
    for (std::size_t begin = 0, end; (end = names.find('\n', begin)) != names.npos; begin = end + 1)
        list.push_back(names.substr(begin, end - begin));
    return list;
}

} // namespace

std::optional<CheckpointInfo> read_checkpoint(const Communicator& comm, const std::string& directory,
                                              std::span<const RodGroup> groups, Rods& rods, const std::string& scene,
                                              const std::function<void(const std::string&)>& warn) {
    const auto names = list_checkpoints(comm, directory);
    for (const std::string& name : names) {
        try {
            return load(comm, directory + "/" + name, groups, rods, scene);
        } catch (const IoError& error) {
            if (comm.root()) warn(error.what());
        }
    }
    if (names.empty()) return std::nullopt;
    throw IoError(fmt::format("{}: none of its {} checkpoints can be read; start anew with --overwrite", directory, names.size()));
}

} // namespace skein
