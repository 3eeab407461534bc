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

/// 2: a digest of each frame, and what was before the first one.
constexpr std::int64_t format_version = 2;
constexpr std::uint64_t stamp_bytes =
    sizeof(std::int64_t) + sizeof(double) + sizeof(std::uint64_t); ///< of a frame's step, time and digest

/// The numbers of frame `first` and later ones, written by root.
template <class T> void write_from(H5File& file, const Communicator& comm, const std::string& path, std::uint64_t first,
                                   const std::vector<T>& all) {
    file.write(path, h5_type<T>(), {{first}, {comm.root() ? all.size() - first : 0}}, all.data() + first);
}

} // namespace

struct FrameWriter::Impl {
    Communicator comm;
    std::string directory;
    FrameKind kind;
    OutputSpec spec;
    std::string title;
    Warn warn; ///< on root
    std::string side_car_name = "trajectory.xdmf";
    std::vector<GroupFrames> groups = {};
    std::vector<std::string> group_names = {};
    std::vector<Segment> segments = {}; ///< finished ones; root only
    std::size_t listed = 0;             ///< of them in the side-car
    std::uint64_t flush_every = 1;      ///< frames of a file
    std::uint64_t buffer_bytes = default_buffer_bytes;
    std::size_t most_pending = 1;      ///< frames
    std::unique_ptr<H5File> file = {}; ///< of the open segment, once there are frames in it
    Segment open = {};                 ///< with its pending frames
    std::size_t written = 0;           ///< frames of the open segment
    bool whole = true;                 ///< false while frames are on their way into it
    std::int64_t last_step = -1;
    std::int64_t last_closed = -1; ///< step of the last frame in finished segments

    std::string kind_name() const { return std::string(nth(frame_kind_names, kind)); }
    std::string path_of(const std::string& name) const { return directory + "/" + name; }
    std::string temporary() const { return path_of(open.file) + ".tmp"; }
    std::vector<std::string> frame_datasets() const {
        std::vector<std::string> paths{"/step", "/time", "/digest"};
        for (const GroupFrames& group : groups)
            for (auto& path : group.frame_datasets()) paths.push_back(std::move(path));
        return paths;
    }

    void tell(const std::string& text) const {
        if (comm.root() && warn && !text.empty()) warn(text);
    }
    std::string lost(const std::string& name) const { return path_of("lost_" + name); }

    /// Of the directory's segments those that begin up to the step and can be read. Others are put aside. Root only.
    std::vector<Segment> sort_out(std::int64_t step) const {
        std::vector<Segment> found;
        for (const auto& left : numbered_files(directory, kind_name() + "_", ".h5.tmp"))
            tell(salvage(directory, left.name, group_names));
        for (const auto& one : numbered_files(directory, kind_name() + "_", ".h5")) {
            if (one.number > step) {
                set_aside(path_of(one.name), lost(one.name));
                continue;
            }
            try {
                found.push_back(read_segment(directory, one.name));
            } catch (const IoError& error) {
                put_aside_damaged(one.name, error.what());
            }
        }
        return found;
    }

    void put_aside_damaged(const std::string& name, const std::string& why) const {
        const std::string now = set_aside(path_of(name), path_of(name) + ".damaged");
        tell(fmt::format("{}\n  it is put aside as {}; the run goes on without these frames", why, now));
    }

    /// Tells of segments that should have been before others, or at the end. Root only.
    void look_for_gaps(std::optional<std::int64_t> expected) const {
        std::vector<FramePlace> frames;
        for (const Segment& segment : segments) frames.push_back({segment.steps.back(), segment.after});
        for (const std::string& gap : missing_frames(kind_name(), directory, frames, expected)) tell(gap);
    }

    /// Shortens a segment to its first frames, by way of a copy; the whole of it is put aside.
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

    /// Puts aside a file of the side-car's name that is none; returns whether one is there. Root only.
    bool make_way_for_side_car() const {
        if (!std::filesystem::exists(side_car())) return false;
        if (is_xdmf_document(read_file(side_car()))) return true;
        set_aside(side_car(), side_car() + ".foreign");
        return false;
    }

    /// Whether all frames of a segment are what was written; every rank looks at its share of them.
    bool is_sound(const std::string& name) const {
        std::int64_t damaged = std::numeric_limits<std::int64_t>::max();
        try {
            const Segment segment = read_segment(directory, name);
            const std::size_t found = first_damaged(path_of(name), group_names, static_cast<std::size_t>(comm.rank()),
                                                    static_cast<std::size_t>(comm.size()));
            if (found < segment.steps.size()) damaged = segment.steps[found];
        } catch (const IoError&) {
            damaged = -1;
        }
        damaged = comm.min(damaged);
        if (damaged == std::numeric_limits<std::int64_t>::max()) return true;
        on_root(comm, [&] {
            put_aside_damaged(
                name, damaged < 0 ? name + ": cannot be read"
                                  : fmt::format("{}: the frame of step {} is not what was written", name, damaged));
        });
        return false;
    }

    void keep_up_to(std::int64_t step, std::optional<std::int64_t> expected) {
        on_root(comm, [&] { segments = sort_out(step); });
        while (true) { // only the last one is needed to go on: the others are not looked at frame by frame
            const std::string last = comm.broadcast(segments.empty() ? std::string() : segments.back().file);
            if (last.empty() || is_sound(last)) break;
            if (comm.root()) segments.pop_back();
        }
        std::size_t frames = 0;
        if (!segments.empty()) {
            const auto& steps = segments.back().steps;
            frames = static_cast<std::size_t>(std::upper_bound(steps.begin(), steps.end(), step) - steps.begin());
        }
        const std::string longer =
            comm.broadcast(!segments.empty() && frames < segments.back().steps.size() ? segments.back().file : "");
        if (!longer.empty()) {
            cut(longer, static_cast<std::size_t>(comm.broadcast(static_cast<std::int64_t>(frames))));
            if (comm.root()) {
                segments.back().steps.resize(frames);
                segments.back().times.resize(frames);
            }
        }
        if (comm.root()) look_for_gaps(expected);
        last_closed = last_step = comm.broadcast(segments.empty() ? std::int64_t{-1} : segments.back().steps.back());
        if (kind != FrameKind::trajectory) return;
        bool old = false;
        on_root(comm, [&] {
            old = make_way_for_side_car();
            if (old && spec.paraview == ParaView::none) remove_file(side_car());
        });
        if (comm.max(static_cast<std::int64_t>(old || !segments.empty())) > 0) write_side_car();
    }

    void flush_after(std::uint64_t bytes) {
        std::uint64_t frame = stamp_bytes;
        for (const GroupFrames& group : groups) frame += group.frame_bytes();
        flush_every = std::max<std::uint64_t>(bytes / frame, 1);
    }

    /// Frames that `bytes` of memory hold on every rank, so that all ranks write at the same steps.
    void limit_pending(std::uint64_t bytes) {
        std::uint64_t frame = stamp_bytes;
        for (const GroupFrames& group : groups) frame += group.pending_bytes();
        most_pending =
            std::max<std::size_t>(bytes / static_cast<std::uint64_t>(comm.max(static_cast<std::int64_t>(frame))), 1);
    }

    void open_file(std::uint64_t bytes) {
        on_root(comm, [&] { make_way(temporary(), trajectory_format); });
        file = std::make_unique<H5File>(comm, temporary(), H5File::Mode::create);
        file->reserve(bytes);
        file->set("/", "format", trajectory_format);
        file->set("/", "version", format_version);
        file->set("/", "title", title);
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
        on_root(comm, [&] { require_space(directory, bytes); });
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

    /// Ends the open segment with the frames that are written.
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

    /// After an error. What was written before it is kept where that can be done, frames that wait are given up; a
    /// segment that an error has left half written cannot be trusted, and on a full disk it stands in the way.
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

    void write_side_car() {
        if (kind != FrameKind::trajectory || spec.paraview == ParaView::none) return;
        on_root(comm, [&] {
            listed = segments.size();
            std::vector<XdmfGroup> xdmf_groups;
            std::vector<XdmfSegment> xdmf_segments;
            for (const GroupFrames& group : groups) xdmf_groups.push_back(group.xdmf());
            for (const Segment& segment : segments) xdmf_segments.push_back({segment.file, segment.times});
            write_file(side_car(),
                       xdmf_document(title, xdmf_groups, xdmf_segments, spec.precision == Precision::single ? 4 : 8));
        });
    }
};

FrameWriter::FrameWriter(const Communicator& comm, std::string directory, FrameKind kind, const OutputSpec& spec,
                         std::span<const RodGroup> groups, const Rods& rods, std::int64_t resume_step,
                         std::string title, std::uint64_t buffer_bytes, Warn warn, std::optional<std::int64_t> expected,
                         std::uint64_t flush_bytes)
    : impl_(new Impl{comm, std::move(directory), kind, spec, std::move(title), std::move(warn)}) {
    for (const RodGroup& group : groups) {
        impl_->groups.emplace_back(comm, group, rods, kind, spec);
        impl_->group_names.push_back(group.name());
    }
    impl_->buffer_bytes = buffer_bytes;
    impl_->limit_pending(buffer_bytes);
    impl_->flush_after(flush_bytes);
    impl_->keep_up_to(resume_step, expected);
}

FrameWriter::~FrameWriter() = default;

void FrameWriter::write(std::int64_t step, double time, double lag) {
    if (step <= impl_->last_step) return;
    try {
        impl_->write(step, time, lag);
    } catch (const IoError&) {
        impl_->give_up();
        throw;
    }
}

void FrameWriter::follow(const Rods& rods) {
    for (GroupFrames& group : impl_->groups) group.follow(impl_->comm, rods);
    impl_->limit_pending(impl_->buffer_bytes);
}

void FrameWriter::close_segment() {
    try {
        impl_->close();
    } catch (const IoError&) {
        impl_->give_up();
        throw;
    }
}

void FrameWriter::finish() {
    close_segment();
    if (impl_->comm.max(static_cast<std::int64_t>(impl_->listed < impl_->segments.size())) > 0) impl_->write_side_car();
}

std::int64_t FrameWriter::last_step() const { return impl_->last_step; }

void write_single_frame(const Communicator& comm, const std::string& directory, const std::string& name,
                        std::span<const RodGroup> groups, const Rods& rods, const std::string& title, std::int64_t step,
                        double time, double lag) {
    const OutputSpec spec{.directors = true, .precision = Precision::double_};
    FrameWriter::Impl frame{comm, directory, FrameKind::trajectory, spec, title, {}};
    for (const RodGroup& group : groups)
        frame.groups.emplace_back(comm, group, rods, FrameKind::trajectory, frame.spec);
    frame.side_car_name = name + ".xdmf";
    frame.open.file = name + ".h5";
    frame.open.steps = {step};
    frame.open.times = {time};
    for (GroupFrames& group : frame.groups) group.take(lag, 1);
    try {
        on_root(comm, [&] { frame.make_way_for_side_car(); });
        frame.close();
    } catch (const IoError&) {
        frame.give_up();
        throw;
    }
}

} // namespace skein
