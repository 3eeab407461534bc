#include "io/checkpoint.hpp"

#include "io/checkpoint_records.hpp"
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
/// several numbers since 8. Rods with sharp surfaces have shifts and mean rates since 9.
constexpr std::int64_t format_version = 9, version_of_springs = 5, oldest_version = 2;

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
                                     "with the program that began it, or start again with --overwrite",
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
            throw InputError(info.file +
                             ": belongs to another scene; `skein branch` continues from it with changed numbers, "
                             "--overwrite starts again, or restore:" +
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
    throw IoError(fmt::format("{}: none of its {} checkpoints can be read; start again with --overwrite", directory,
                              names.size()));
}

} // namespace skein
