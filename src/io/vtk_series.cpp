#include "io/vtk_series.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/own_files.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace fs = std::filesystem;

namespace skein {

namespace {

/// Whether a file may be a frame that a killed run left half written: before its head is on the disk there are zeros.
bool is_unfinished_frame(const std::string& path) {
    if (!fs::is_regular_file(path)) return false;
    std::array<char, 64> begin{};
    std::ifstream file(path, std::ios::binary);
    file.read(begin.data(), begin.size());
    const std::string_view text(begin.data(), static_cast<std::size_t>(file.gcount()));
    return begins_vtk_polydata(text) || std::all_of(text.begin(), text.end(), [](char c) { return c == 0; });
}

} // namespace

std::string VtkSeries::frame_name(const std::string& kind, std::int64_t step) {
    return fmt::format("{}{}_{:012d}.vtp", frames_folder, kind, step);
}

VtkSeries::VtkSeries(const Communicator& comm, std::string directory, const OutputSpec& spec,
                     std::span<const RodGroup> groups, const Rods& rods, std::int64_t resume_step, NodeForces forces,
                     const Expected& expected, const Warn& warn)
    : comm_(comm), directory_(std::move(directory)),
      forces_(std::move(forces)), content_{.real = spec.precision == Precision::single ? VtkType::float32
                                                                                       : VtkType::float64,
                                           .normals = spec.directors,
                                           .forces = static_cast<bool>(forces_)},
      rods_(list_of("rods", resume_step, expected.rods, warn)),
      walls_(list_of("walls", resume_step, expected.walls, warn)) {
    for (const RodGroup& group : groups) groups_.emplace_back(comm_, group, rods, content_);
}

VtkSeries::List VtkSeries::list_of(const std::string& kind, std::int64_t resume_step,
                                   std::optional<std::int64_t> expected, const Warn& warn) const {
    const std::string frames = path_of(frames_folder);
    std::vector<NumberedFile> there;
    std::vector<std::string> paths;
    on_root(comm_, [&] {
        for (const auto& found : numbered_files(frames, kind + "_", ".vtp.tmp"))
            if (const std::string path = frames + found.name; is_unfinished_frame(path)) remove_file(path);
        for (const auto& found : numbered_files(frames, kind + "_", ".vtp"))
            if (found.number <= resume_step) {
                there.push_back(found);
                paths.push_back(frames + found.name);
            }
    });
    const auto step_of = [&](const std::string& path) { return std::stoll(path.substr(path.rfind('_') + 1)); };
    const std::vector<std::int64_t> damaged =
        find_damaged(comm_, paths, [&](const std::string& path) { return is_sound_vtk_polydata(path, step_of(path)); });
    std::vector<PvdFile::Entry> entries;
    std::int64_t last = -1;
    on_root(comm_, [&] {
        std::vector<FramePlace> places;
        for (std::size_t i = 0; i < there.size(); ++i) {
            FramePlace& place = places.emplace_back(FramePlace{there[i].number, {}});
            const auto found = find_vtk_polydata(paths[i]);
            if (found && damaged[i] == 0) {
                if (found->stamp) place.after = found->stamp->after;
                entries.push_back({found->time, frames_folder + there[i].name});
                last = there[i].number;
                continue;
            }
            const std::string now = set_aside(paths[i], paths[i] + ".damaged");
            if (warn)
                warn(fmt::format(
                    "{}: is no whole frame, or not the one that was written\n  it is put aside as {}; the run goes on "
                    "without it",
                    paths[i], now));
        }
        for (const std::string& gap : missing_frames(kind, frames, places, expected))
            if (warn) warn(gap);
    });
    List list{kind, PvdFile(path_of(kind + ".pvd"), entries), comm_.broadcast(last)};
    on_root(comm_, [&] {
        const std::string path = path_of(kind + ".pvd");
        if (!entries.empty() || (fs::exists(path) && is_pvd_document(read_file(path)))) list.file.write();
    });
    return list;
}

std::string VtkSeries::begin_file(const std::string& name, std::uint64_t bytes) const {
    fs::create_directories(path_of(frames_folder));
    require_space(directory_, bytes);
    const std::string temporary = path_of(name) + ".tmp";
    if (fs::exists(temporary) && !is_unfinished_frame(temporary)) set_aside(temporary, temporary + ".foreign");
    Descriptor(temporary, O_WRONLY | O_CREAT | O_TRUNC).close();
    reserve_space(temporary, bytes);
    return temporary;
}

void VtkSeries::end_file(List& list, const std::string& name, const VtkPolyData& layout, VtkStamp stamp, double time) {
    const std::string path = path_of(name), temporary = path + ".tmp";
    stamp.digest += place_digest(stamp.step, stamp.after);
    Descriptor file(temporary, O_WRONLY);
    file.write_at(layout.tail_at(), VtkPolyData::tail + stamp.text());
    file.close();
    if (fs::exists(path) && !find_vtk_polydata(path)) set_aside(path, path + ".foreign");
    if (std::rename(temporary.c_str(), path.c_str()) != 0) throw_system_error(temporary, "cannot be renamed", errno);
    list.file.append({time, name});
}

template <class Deed> void VtkSeries::whole_or_not(List& list, std::int64_t step, Deed deed) {
    if (step <= list.last) return;
    const std::string name = frame_name(list.kind, step);
    try {
        deed(name);
    } catch (const IoError&) { // on a full disk what is left stands in the way
        if (const std::string left = path_of(name) + ".tmp"; comm_.root() && is_unfinished_frame(left))
            ::unlink(left.c_str());
        throw;
    }
    list.last = step;
}

void VtkSeries::write(std::int64_t step, double time, double lag) {
    whole_or_not(rods_, step, [&](const std::string& name) {
        const VtkPolyData layout(content_.nodes, content_.lines, 0, content_.arrays(), time);
        const std::string temporary = path_of(name) + ".tmp";
        std::uint64_t digest = 0;
        on_root(comm_, [&] {
            VtkParts file(begin_file(name, layout.file_bytes()), O_WRONLY);
            file.write_at(0, layout.head());
            for (std::size_t i = 0; i < layout.arrays().size(); ++i) {
                const std::uint64_t bytes = layout.arrays()[i].bytes();
                file.write_at(layout.count_at(i), {reinterpret_cast<const char*>(&bytes), sizeof bytes});
            }
            digest += file.close();
        });
        for (VtkRods& group : groups_) {
            const auto block = group.take(content_, time, lag, forces_, buffers_);
            on_all(comm_, [&] {
                VtkParts file(temporary, O_WRONLY);
                group.write(file, layout, content_, block);
                digest += file.close();
            });
        }
        digest = comm_.sum_wrapping(digest);
        on_root(comm_, [&] { end_file(rods_, name, layout, {step, rods_.last, digest}, time); });
        unflushed_.push_back(path_of(name)); // of all ranks: each has written to it on its own machine
    });
}

void VtkSeries::follow(const Rods& rods) {
    for (VtkRods& group : groups_) group.follow(comm_, rods);
}

void VtkSeries::write_walls(std::int64_t step, double time, const PolygonMesh& walls) {
    whole_or_not(walls_, step, [&](const std::string& name) {
        on_root(comm_, [&] {
            const auto [layout, text] = vtk_document(walls, "wall", time);
            VtkParts file(begin_file(name, layout.file_bytes()), O_WRONLY);
            file.write_at(0, text);
            end_file(walls_, name, layout, {step, walls_.last, file.close()}, time);
            unflushed_.push_back(path_of(name));
        });
    });
}

void VtkSeries::flush() {
    on_all(comm_, [&] {
        if (unflushed_.empty()) return;
        if (comm_.root()) {
            for (const List* list : {&rods_, &walls_}) unflushed_.push_back(path_of(list->kind + ".pvd"));
            unflushed_.push_back(path_of(frames_folder));
        }
        for (const std::string& path : unflushed_)
            if (fs::exists(path)) Descriptor(path, O_RDONLY).flush(); // its reader may have moved it
        unflushed_.clear();
    });
}

double VtkSeries::frame_bytes(const OutputSpec& spec, double lines, double nodes, bool forces) {
    const VtkContent content{.real = spec.precision == Precision::single ? VtkType::float32 : VtkType::float64,
                             .normals = spec.directors,
                             .forces = forces};
    return nodes * (static_cast<double>(content.bytes_per_node()) + 4) + lines * 16;
}

} // namespace skein
