#include "io/vtk_series.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/own_files.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>

namespace fs = std::filesystem;

namespace skein {

namespace {

/// True if the file may be a frame that a killed run left unfinished. Not collective.
bool is_unfinished_frame(const std::string& path) {
    const std::optional<std::string> begin = beginning_of(path, 64);
    return begin && (begins_vtk_polydata(*begin) || is_hole(*begin));
}

VtkContent content_of(const OutputSpec& spec, bool forces) {
    return {.real = spec.precision == Precision::single ? VtkType::float32 : VtkType::float64,
            .normals = spec.directors,
            .forces = forces};
}

} // namespace

std::string VtkSeries::frame_name(const std::string& kind, std::int64_t step) {
    return fmt::format("{}{}_{:012d}.vtp", frames_folder, kind, step);
}

VtkSeries::VtkSeries(const Communicator& comm, std::string directory, const OutputSpec& spec,
                     std::span<const RodGroup> groups, const Rods& rods, NodeForces forces,
                     const EarlierFrames& earlier, std::optional<std::int64_t> expected_walls)
    : comm_(comm), directory_(std::move(directory)), forces_(std::move(forces)),
      content_(content_of(spec, static_cast<bool>(forces_))), rods_(list_of("rods", earlier)),
      walls_(list_of("walls", {earlier.resume_step, expected_walls, earlier.warn})) {
    for (const RodGroup& group : groups) groups_.emplace_back(comm_, group, rods, content_);
}

VtkSeries::List VtkSeries::list_of(const std::string& kind, const EarlierFrames& earlier) const {
    const std::string folder = fs::path(path_of(frames_folder)).parent_path().string();
    on_root(comm_, [&] {
        for (const NumberedFile& file : numbered_files(folder, kind + "_", ".vtp.tmp"))
            if (const std::string path = folder + "/" + file.name; is_unfinished_frame(path)) remove_file(path);
    });
    std::vector<PvdFile::Entry> entries;
    std::int64_t last = -1;
    check_frames(
        comm_, {kind, folder, kind + "_", ".vtp"}, earlier,
        [](const FrameFile& frame) { return is_sound_vtk_polydata(frame.path, frame.step); },
        [&](const FrameFile& frame) -> std::optional<std::int64_t> {
            const auto found = find_vtk_polydata(frame.path);
            if (!found) throw IoError(frame.path + ": is incomplete");
            entries.push_back({found->time, frames_folder + frame.name});
            last = frame.step;
            return found->stamp ? std::optional(found->stamp->after) : std::nullopt;
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
    } catch (const IoError&) { // an incomplete frame takes space on a full disk
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
        unflushed_.push_back(path_of(name)); // on all ranks, since each has written on its own machine
    });
}

void VtkSeries::rebind(const Rods& rods) {
    for (VtkRods& group : groups_) group.rebind(comm_, rods);
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
            if (fs::exists(path)) Descriptor(path, O_RDONLY).flush(); // a reader may have moved the file
        unflushed_.clear();
    });
}

double VtkSeries::frame_bytes(const OutputSpec& spec, double lines, double nodes, bool forces) {
    return nodes * (static_cast<double>(content_of(spec, forces).bytes_per_node()) + 4) + lines * 16;
}

} // namespace skein
