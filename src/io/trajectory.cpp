#include "io/trajectory.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/frame_files.hpp"
#include "io/group_frames.hpp"
#include "io/h5_file.hpp"
#include "io/own_files.hpp"
#include "io/segments.hpp"
#include "io/xdmf.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <unistd.h>
#include <utility>
#include <vector>

namespace skein {

namespace {

/// Version 2 has digests of frames, and the step before the first one.
constexpr std::int64_t trajectory_version = 2;
/// Size of a frame's step, time and digest.
constexpr std::uint64_t stamp_bytes = sizeof(std::int64_t) + sizeof(double) + sizeof(std::uint64_t);

/// Writes the numbers of frame `first` and later ones from root.
template <class T> void write_from(H5File& file, const Communicator& comm, const std::string& path, std::uint64_t first,
                                   const std::vector<T>& all) {
    file.write(path, h5_type<T>(), {{first}, {comm.root() ? all.size() - first : 0}}, all.data() + first);
}

} // namespace

struct FrameWriter::Impl {
    Communicator comm;
    Settings settings;
    std::string side_car_name = "trajectory.xdmf";
    std::vector<GroupFrames> groups = {};
    std::vector<std::string> group_names = {};
    std::vector<Segment> segments = {}; ///< finished segments; root only
    std::size_t listed = 0;             ///< segments in the side-car
    std::uint64_t flush_every = 1;      ///< frames of a file
    std::size_t most_pending = 1;       ///< frames
    std::unique_ptr<H5File> file = {};  ///< file of the open segment, if it has frames
    Segment open = {};                  ///< open segment with its pending frames
    std::size_t written = 0;            ///< frames of the open segment in the file
    bool whole = true;                  ///< false while frames are being written
    std::int64_t last_step = -1;
    std::int64_t last_closed = -1; ///< step of the last frame in finished segments

    Impl(const Communicator& comm_, Settings settings_, std::span<const RodGroup> of_scene, const Rods& rods)
        : comm(comm_), settings(std::move(settings_)) {
        for (const RodGroup& group : of_scene) {
            groups.emplace_back(comm, group, rods, settings.kind, settings.spec);
            group_names.push_back(group.name());
        }
    }
    std::string kind_name() const { return std::string(nth(frame_kind_names, settings.kind)); }
    std::string path_of(const std::string& name) const { return settings.directory + "/" + name; }
    std::string temporary() const { return path_of(open.file) + ".tmp"; }
    std::vector<std::string> frame_datasets() const {
        std::vector<std::string> paths{"/step", "/time", "/digest"};
        for (const GroupFrames& group : groups)
            for (auto& path : group.frame_datasets()) paths.push_back(std::move(path));
        return paths;
    }

    std::string lost(const std::string& name) const { return path_of("lost_" + name); }

    /// Readable segments of the directory up to the resumed step; others are renamed. Root only.
    std::vector<Segment> sort_out() const {
        const EarlierFrames& earlier = settings.earlier;
        std::vector<Segment> found;
        for (const auto& left : numbered_files(settings.directory, kind_name() + "_", ".h5.tmp"))
            if (const std::string report = salvage(settings.directory, left.name, group_names);
                earlier.warn && !report.empty())
                earlier.warn(report);
        for (const auto& one : numbered_files(settings.directory, kind_name() + "_", ".h5")) {
            if (one.number > earlier.resume_step) {
                set_aside(path_of(one.name), lost(one.name));
                continue;
            }
            try {
                found.push_back(read_segment(settings.directory, one.name));
            } catch (const IoError& error) {
                put_aside_damaged(path_of(one.name), error.what(), earlier.warn);
            }
        }
        return found;
    }

    /// Warns of segments that are missing before others, or at the end. Root only.
    void find_gaps() const {
        std::vector<FramePlace> frames;
        for (const Segment& segment : segments) frames.push_back({segment.steps.back(), segment.after});
        warn_of_gaps(kind_name(), settings.directory, frames, settings.earlier.expected, settings.earlier.warn);
    }

    /// Replaces a segment by a copy of its first frames; the original is renamed to lost_*.
    void cut(const std::string& name, std::size_t frames) const {
        const std::string path = path_of(name), copy = path + ".tmp";
        on_root(comm, [&] {
            make_way(copy, trajectory_format);
            std::filesystem::copy_file(path, copy, std::filesystem::copy_options::overwrite_existing);
        });
        H5File shorter(comm, copy, H5File::Mode::modify);
        shorter.set_frames(skein::frame_datasets(shorter, group_names), frames);
        shorter.close();
        on_root(comm, [&] {
            set_aside(path, lost(name));
            publish(copy, path);
        });
    }

    std::string side_car() const { return path_of(side_car_name); }

    /// Renames a foreign file with the name of the side-car. Returns true if there is a side-car. Root only.
    bool make_way_for_side_car() const {
        if (!std::filesystem::exists(side_car())) return false;
        if (is_xdmf_document(read_file(side_car()))) return true;
        set_aside(side_car(), side_car() + ".foreign");
        return false;
    }

    /// True if all frames of a segment have their digests; every rank checks a share. Collective.
    bool is_sound(const std::string& name) const {
        std::int64_t damaged = std::numeric_limits<std::int64_t>::max();
        try {
            const Segment segment = read_segment(settings.directory, name);
            const std::size_t found =
                first_damaged(path_of(name), group_names, to_index(comm.rank()), to_index(comm.size()));
            if (found < segment.steps.size()) damaged = segment.steps[found];
        } catch (const IoError&) {
            damaged = -1;
        }
        damaged = comm.min(damaged);
        if (damaged == std::numeric_limits<std::int64_t>::max()) return true;
        on_root(comm, [&] {
            put_aside_damaged(path_of(name),
                              damaged < 0 ? name + ": cannot be read"
                                          : fmt::format("{}: the frame of step {} is damaged", name, damaged),
                              settings.earlier.warn);
        });
        return false;
    }

    /// Keeps sound frames up to the resumed step.
    void resume() {
        on_root(comm, [&] { segments = sort_out(); });
        while (true) { // checks the last segment only, since the run continues from its end
            const std::string last = comm.broadcast(segments.empty() ? std::string() : segments.back().file);
            if (last.empty() || is_sound(last)) break;
            if (comm.root()) segments.pop_back();
        }
        std::size_t frames = 0;
        if (!segments.empty()) {
            const auto& steps = segments.back().steps;
            frames =
                to_index(std::upper_bound(steps.begin(), steps.end(), settings.earlier.resume_step) - steps.begin());
        }
        const std::string longer =
            comm.broadcast(!segments.empty() && frames < segments.back().steps.size() ? segments.back().file : "");
        if (!longer.empty()) {
            cut(longer, to_index(comm.broadcast(static_cast<std::int64_t>(frames))));
            if (comm.root()) {
                segments.back().steps.resize(frames);
                segments.back().times.resize(frames);
            }
        }
        if (comm.root()) find_gaps();
        last_closed = last_step = comm.broadcast(segments.empty() ? std::int64_t{-1} : segments.back().steps.back());
        if (settings.kind != FrameKind::trajectory) return;
        bool old = false;
        on_root(comm, [&] {
            old = make_way_for_side_car();
            if (old && settings.spec.paraview == ParaView::none) remove_file(side_car());
        });
        if (comm.max(static_cast<std::int64_t>(old || !segments.empty())) > 0) write_side_car();
    }

    /// Size of a frame with its stamp, from a member function for the size of a group's part.
    template <class Size> std::uint64_t frame_bytes(Size size) const {
        std::uint64_t bytes = stamp_bytes;
        for (const GroupFrames& group : groups) bytes += (group.*size)();
        return bytes;
    }

    /// Sets the number of pending frames to the least of all ranks, so that all write at the same steps.
    void limit_pending() {
        const auto frame = static_cast<std::int64_t>(frame_bytes(&GroupFrames::pending_bytes));
        most_pending = std::max<std::size_t>(settings.buffer_bytes / to_index(comm.max(frame)), 1);
    }

    void open_file(std::uint64_t bytes) {
        on_root(comm, [&] { make_way(temporary(), trajectory_format); });
        file = std::make_unique<H5File>(comm, temporary(), H5File::Mode::create);
        file->reserve(bytes);
        file->set("/", "format", trajectory_format);
        file->set("/", "version", trajectory_version);
        file->set("/", "title", settings.title);
        file->set("/", "kind", kind_name());
        file->set("/", "after", last_closed);
        file->make_frames("/step", H5Type::int64, {});
        file->make_frames("/time", H5Type::float64, {});
        file->make_frames("/digest", H5Type::uint64, {});
        file->make_group("/groups");
        for (const GroupFrames& group : groups) group.make(*file, comm);
    }

    void write(std::int64_t step, double time, double lag) {
        if (std::any_of(groups.begin(), groups.end(), [](const GroupFrames& group) { return group.has_left(); }))
            write_pending();
        if (open.steps.empty()) open.file = fmt::format("{}_{:012d}.h5", kind_name(), step);
        for (GroupFrames& group : groups) group.take(lag, most_pending);
        open.steps.push_back(step);
        open.times.push_back(time);
        last_step = step;
        if (open.steps.size() - written == most_pending) write_pending();
    }

    void write_pending() {
        const std::size_t frames = open.steps.size() - written;
        if (frames == 0) return;
        std::uint64_t bytes = frames * stamp_bytes;
        for (const GroupFrames& group : groups)
            bytes += frames * group.frame_bytes() + (file ? 0 : group.constant_bytes());
        on_root(comm, [&] { require_space(settings.directory, bytes); });
        if (file) file->reserve(bytes);
        else open_file(bytes);
        whole = false;
        file->set_frames(frame_datasets(), open.steps.size(), flush_every);
        write_from(*file, comm, "/step", written, open.steps);
        write_from(*file, comm, "/time", written, open.times);
        std::vector<std::uint64_t> digests(frames, 0);
        for (GroupFrames& group : groups) group.write(*file, written, digests);
        for (std::uint64_t& digest : digests) digest = comm.sum_wrapping(digest);
        for (std::size_t k = 0; k < frames; ++k)
            digests[k] += stamp_digest(open.steps[written + k], open.times[written + k]);
        file->write("/digest", H5Type::uint64, {{written}, {comm.root() ? frames : 0}}, digests.data());
        written = open.steps.size();
        whole = true;
    }

    void close() {
        if (open.steps.empty()) return;
        write_pending();
        close_file();
    }

    /// Closes the open segment with its written frames.
    void close_file() {
        file->close();
        file.reset();
        open.steps.resize(written);
        open.times.resize(written);
        on_root(comm, [&] {
            for (const GroupFrames& group : groups) group.make_views(temporary(), written);
            make_way(path_of(open.file), trajectory_format);
            publish(temporary(), path_of(open.file));
        });
        last_closed = last_step = open.steps.back();
        open.after.reset();
        if (comm.root()) segments.push_back(std::move(open));
        open = {};
        written = 0;
        if (comm.max(static_cast<std::int64_t>(document_lags(segments.size(), listed))) > 0) write_side_car();
    }

    /// Cleans up after an error. Written frames are kept if possible, pending ones are dropped. A half written segment
    /// is useless and takes space on a full disk.
    void give_up() {
        for (GroupFrames& group : groups) group.drop_pending();
        if (file && whole && written > 0) try {
                close_file();
            } catch (const IoError&) {
            }
        file.reset();
        if (comm.root() && !open.file.empty() && is_unfinished(temporary(), trajectory_format))
            ::unlink(temporary().c_str());
        last_step = last_closed;
        open = {};
        written = 0;
        whole = true;
    }

    /// Runs `deed`, and cleans up if it throws.
    template <class Deed> void attempt(Deed&& deed) {
        try {
            deed();
        } catch (const IoError&) {
            give_up();
            throw;
        }
    }

    void write_side_car() {
        if (settings.kind != FrameKind::trajectory || settings.spec.paraview == ParaView::none) return;
        on_root(comm, [&] {
            listed = segments.size();
            std::vector<XdmfGroup> xdmf_groups;
            std::vector<XdmfSegment> xdmf_segments;
            for (const GroupFrames& group : groups) xdmf_groups.push_back(group.xdmf());
            for (const Segment& segment : segments) xdmf_segments.push_back({segment.file, segment.times});
            write_file(side_car(), xdmf_document(settings.title, xdmf_groups, xdmf_segments,
                                                 settings.spec.precision == Precision::single ? 4 : 8));
        });
    }
};

FrameWriter::FrameWriter(const Communicator& comm, Settings settings, std::span<const RodGroup> groups,
                         const Rods& rods)
    : impl_(new Impl(comm, std::move(settings), groups, rods)) {
    impl_->limit_pending();
    const std::uint64_t frame = impl_->frame_bytes(&GroupFrames::frame_bytes);
    impl_->flush_every = std::max<std::uint64_t>(impl_->settings.flush_bytes / frame, 1);
    impl_->resume();
}

FrameWriter::~FrameWriter() = default;

void FrameWriter::write(std::int64_t step, double time, double lag) {
    if (step <= impl_->last_step) return;
    impl_->attempt([&] { impl_->write(step, time, lag); });
}

void FrameWriter::rebind(const Rods& rods) {
    for (GroupFrames& group : impl_->groups) group.rebind(impl_->comm, rods);
    impl_->limit_pending();
}

void FrameWriter::close_segment() {
    impl_->attempt([&] { impl_->close(); });
}

void FrameWriter::finish() {
    close_segment();
    if (impl_->comm.max(static_cast<std::int64_t>(impl_->listed < impl_->segments.size())) > 0) impl_->write_side_car();
}

std::int64_t FrameWriter::last_step() const { return impl_->last_step; }

void write_single_frame(const Communicator& comm, const std::string& directory, const std::string& name,
                        std::span<const RodGroup> groups, const Rods& rods, const std::string& title, std::int64_t step,
                        double time, double lag) {
    FrameWriter::Impl frame(
        comm, {.directory = directory, .spec = {.directors = true, .precision = Precision::double_}, .title = title},
        groups, rods);
    frame.side_car_name = name + ".xdmf";
    frame.open.file = name + ".h5";
    frame.open.steps = {step};
    frame.open.times = {time};
    for (GroupFrames& group : frame.groups) group.take(lag, 1);
    frame.attempt([&] {
        on_root(comm, [&] { frame.make_way_for_side_car(); });
        frame.close();
    });
}

} // namespace skein
