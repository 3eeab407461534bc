#include "io/trajectory.hpp"

#include "core/error.hpp"
#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/h5_file.hpp"
#include "io/xdmf.hpp"
#include "partition/partition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <unistd.h>
#include <utility>
#include <vector>

namespace skein {

namespace {

const std::string format_name = "skein-trajectory";
constexpr std::int64_t format_version = 1;
constexpr std::uint64_t stamp_bytes = sizeof(std::int64_t) + sizeof(double); ///< of a frame's step and time
constexpr std::uint64_t view_bytes = 4 << 10; ///< in the file, of a frame's names of its own, or more

using Shape = std::vector<std::uint64_t>;

/// A quantity of a frame: numbers of one rod, worked out from its state.
struct Field {
    std::string name;
    Shape shape; ///< of one rod
    void (*fill)(std::span<const Slot<1>> state, double* out);

    std::size_t numbers() const {
        std::size_t n = 1;
        for (const auto extent : shape) n *= extent;
        return n;
    }
};

double* put(double* out, const Vec3<Pack<1>>& v) {
    *out++ = v.x[0];
    *out++ = v.y[0];
    *out++ = v.z[0];
    return out;
}

void fill_positions(std::span<const Slot<1>> state, double* out) {
    for (const auto& slot : state) out = put(out, slot.position);
}

void fill_tip(std::span<const Slot<1>> state, double* out) { put(out, state.back().position); }

void fill_directors(std::span<const Slot<1>> state, double* out) {
    for (const auto& slot : state.first(state.size() - 1)) {
        const Mat3<Pack<1>> q = matrix(slot.director);
        out = put(out, q.d1);
        out = put(out, q.d2);
        out = put(out, q.d3);
    }
}

/// d1 at nodes: mean of the elements that meet there.
void fill_normals(std::span<const Slot<1>> state, double* out) {
    const std::size_t last = state.size() - 2;
    for (std::size_t node = 0; node < state.size(); ++node) {
        const auto before = matrix(state[node > 0 ? node - 1 : 0].director).d1,
                   after = matrix(state[std::min(node, last)].director).d1;
        out = put(out, Pack<1>(0.5) * (before + after));
    }
}

std::vector<Field> fields_of(FrameKind kind, const OutputSpec& spec, const RodGroup& group) {
    if (kind == FrameKind::tips) return {{"position", {3}, fill_tip}};
    const auto nodes = static_cast<std::uint64_t>(group.slots());
    std::vector<Field> fields{{"position", {nodes, 3}, fill_positions}};
    if (spec.directors) {
        fields.push_back({"directors", {nodes - 1, 3, 3}, fill_directors});
        fields.push_back({"normal", {nodes, 3}, fill_normals});
    }
    return fields;
}

Shape prepend(std::uint64_t first, const Shape& rest) {
    Shape shape{first};
    shape.insert(shape.end(), rest.begin(), rest.end());
    return shape;
}

/// Records [rows, columns] as [columns, rows].
std::vector<std::byte> transposed(std::vector<std::byte> records, std::size_t rows, std::size_t columns, std::size_t bytes) {
    if (rows <= 1 || columns <= 1) return records;
    std::vector<std::byte> turned(records.size());
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < columns; ++column)
            std::memcpy(&turned[(column * rows + row) * bytes], &records[(row * columns + column) * bytes], bytes);
    return turned;
}

void store(const std::vector<double>& numbers, Precision precision, std::byte* out) {
    if (precision == Precision::double_) {
        std::memcpy(out, numbers.data(), numbers.size() * sizeof(double));
        return;
    }
    for (const double number : numbers) {
        const auto single = static_cast<float>(number);
        std::memcpy(out, &single, sizeof single);
        out += sizeof single;
    }
}

template <class T> H5Type h5_type();
template <> H5Type h5_type<double>() { return H5Type::float64; }
template <> H5Type h5_type<std::int64_t>() { return H5Type::int64; }

/// One group's part of the files. Frames are pending until they are written, many at a time.
class GroupFrames {
public:
    GroupFrames(const Communicator& comm, const RodGroup& group, const Rods& rods, FrameKind kind, const OutputSpec& spec)
        : group_(group), rods_(rods), kind_(kind), precision_(spec.precision), fields_(fields_of(kind, spec, group)),
          local_(places(rods, group)), blocks_(comm, indices(rods, local_), group.count()), pending_(fields_.size()) {}

    /// Of a frame in the file, or more.
    std::uint64_t frame_bytes() const { return count() * rod_bytes() + (kind_ == FrameKind::trajectory ? view_bytes : 0); }
    /// Of a pending frame on this rank.
    std::size_t pending_bytes() const { return local_.size() * rod_bytes(); }

    /// Of what holds for all frames, or more.
    std::uint64_t constant_bytes() const {
        const std::uint64_t per_node = kind_ == FrameKind::trajectory ? 16 * static_cast<std::uint64_t>(group_.slots()) : 0;
        return count() * (per_node + 56) + 8 * static_cast<std::uint64_t>(group_.slots()) + fields_.size() * H5File::frames_slack;
    }

    void make(H5File& file, const Communicator& comm) const {
        file.make_group(path());
        for (const Field& field : fields_) file.make_frames(path(field.name), number_type(), prepend(count(), field.shape));
        write_constants(file, comm);
    }

    std::vector<std::string> frame_datasets() const {
        std::vector<std::string> paths;
        for (const Field& field : fields_) paths.push_back(path(field.name));
        return paths;
    }

    /// Takes a frame of the rods as they are, one of at most `most` that will be pending.
    void take(const Threads& threads, double lag, std::size_t most) {
        constexpr std::size_t batch = 64; // rods of one task
        std::vector<std::size_t> begin;
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            const std::size_t bytes = local_.size() * record_bytes(fields_[f]);
            begin.push_back(pending_[f].size());
            if (pending_[f].empty()) pending_[f].reserve(most * bytes);
            pending_[f].resize(begin[f] + bytes);
        }
        threads.for_each((local_.size() + batch - 1) / batch, [&](std::size_t task, int) {
            std::vector<Slot<1>> state(static_cast<std::size_t>(group_.slots()));
            std::vector<double> numbers;
            for (std::size_t i = task * batch; i < std::min((task + 1) * batch, local_.size()); ++i) {
                rods_.export_rod(local_[i], state);
                if (directors()) synchronise(group_, state, lag);
                else synchronise_positions(group_, state, lag);
                for (std::size_t f = 0; f < fields_.size(); ++f) {
                    numbers.resize(fields_[f].numbers());
                    fields_[f].fill(state, numbers.data());
                    store(numbers, precision_, &pending_[f][begin[f] + i * record_bytes(fields_[f])]);
                }
            }
        });
    }

    /// Writes the pending frames, `frames` of them, from frame `first` on.
    void write(H5File& file, std::uint64_t first, std::size_t frames) {
        const auto rods = static_cast<std::size_t>(blocks_.size());
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            const Field& field = fields_[f];
            const std::size_t record = record_bytes(field);
            // A rod's numbers of all frames travel together.
            auto numbers = transposed(std::exchange(pending_[f], {}), frames, local_.size(), record);
            numbers = blocks_.to_blocks(numbers, frames * record);
            numbers = transposed(std::move(numbers), rods, frames, record);
            H5Box box{{first, static_cast<std::uint64_t>(blocks_.begin())}, {frames, rods}};
            box.start.resize(2 + field.shape.size(), 0);
            box.count.insert(box.count.end(), field.shape.begin(), field.shape.end());
            file.write(path(field.name), number_type(), box, numbers.data());
        }
    }

    void drop_pending() {
        for (auto& records : pending_) records = {};
    }

    /// Single frames under names of their own, for the side-car: of the XDMF readers in use one knows hyperslabs only in a
    /// spelling that the other does not. Root only, of a closed file.
    void make_views(const std::string& file, std::uint64_t frames) const {
        if (kind_ == FrameKind::tips) return;
        std::vector<std::string> names;
        for (const Field& field : fields_)
            if (field.name != "directors") names.push_back(field.name);
        make_frame_views(file, path(), names, frames);
    }

    XdmfGroup xdmf() const { return {group_.name(), group_.count(), group_.slots(), directors(), magnetised()}; }

private:
    static std::vector<std::size_t> places(const Rods& rods, const RodGroup& group) {
        std::vector<std::size_t> found;
        for (std::size_t i = 0; i < rods.local().size(); ++i)
            if (rods.local()[i].group == group.id()) found.push_back(i);
        return found;
    }
    static std::vector<std::int64_t> indices(const Rods& rods, std::span<const std::size_t> places) {
        std::vector<std::int64_t> found;
        for (const auto place : places) found.push_back(rods.local()[place].index);
        return found;
    }

    std::string path() const { return "/groups/" + group_.name(); }
    std::string path(const std::string& dataset) const { return path() + "/" + dataset; }
    std::uint64_t count() const { return static_cast<std::uint64_t>(group_.count()); }
    std::size_t number_bytes() const { return precision_ == Precision::single ? 4 : 8; }
    H5Type number_type() const { return precision_ == Precision::single ? H5Type::float32 : H5Type::float64; }
    std::size_t record_bytes(const Field& field) const { return field.numbers() * number_bytes(); }
    std::size_t rod_bytes() const {
        std::size_t bytes = 0;
        for (const Field& field : fields_) bytes += record_bytes(field);
        return bytes;
    }
    bool directors() const { return fields_.size() > 1; }
    bool magnetised() const { return group_.spec().magnetisation.pattern != MagnetisationPattern::none; }

    /// A dataset [rods, width] that holds for all frames: this rank's rows from row(index, out).
    template <class T, class Row> void write_rows(H5File& file, const std::string& name, std::uint64_t width, Row row) const {
        std::vector<T> rows(static_cast<std::size_t>(blocks_.size()) * width);
        for (std::int64_t i = 0; i < blocks_.size(); ++i) row(blocks_.begin() + i, &rows[static_cast<std::size_t>(i) * width]);
        const auto begin = static_cast<std::uint64_t>(blocks_.begin()), size = static_cast<std::uint64_t>(blocks_.size());
        file.make_dataset(path(name), h5_type<T>(), {count(), width});
        file.write(path(name), h5_type<T>(), {{begin, 0}, {size, width}}, rows.data());
    }

    /// Radius at node k of the undeformed rod: mean of the elements that meet there.
    double node_radius(std::int64_t k) const {
        const std::int64_t last = group_.elements() - 1;
        return 0.5 * (group_.element[static_cast<std::size_t>(std::max<std::int64_t>(k - 1, 0))].radius +
                      group_.element[static_cast<std::size_t>(std::min(k, last))].radius);
    }

    void write_constants(H5File& file, const Communicator& comm) const {
        const auto put_vector = [](const Vec3d& v, double* out) { out[0] = v.x, out[1] = v.y, out[2] = v.z; };
        write_rows<double>(file, "origin", 3, [&](std::int64_t i, double* out) { put_vector(group_.origin(i), out); });
        if (magnetised())
            write_rows<double>(file, "magnetisation", 3,
                               [&](std::int64_t i, double* out) { put_vector(group_.magnetisation(i), out); });
        if (kind_ == FrameKind::tips) return;

        const std::int64_t nodes = group_.slots();
        const auto width = static_cast<std::uint64_t>(nodes);
        std::vector<double> radius;
        for (std::int64_t k = 0; k < nodes; ++k) radius.push_back(node_radius(k));
        file.make_dataset(path("radius"), H5Type::float64, {width});
        file.write(path("radius"), H5Type::float64, {{0}, {comm.root() ? width : 0}}, radius.data());
        // What only the side-car needs: XDMF knows no repetition.
        write_rows<std::int64_t>(file, "rod", 1, [](std::int64_t i, std::int64_t* out) { *out = i; });
        write_rows<double>(file, "point_radius", width,
                           [&](std::int64_t, double* out) { std::copy(radius.begin(), radius.end(), out); });
        write_rows<std::int64_t>(file, "connectivity", width, [nodes](std::int64_t i, std::int64_t* out) {
            for (std::int64_t k = 0; k < nodes; ++k) out[k] = i * nodes + k;
        });
    }

    const RodGroup& group_;
    const Rods& rods_;
    FrameKind kind_;
    Precision precision_;
    std::vector<Field> fields_;
    std::vector<std::size_t> local_; ///< places of the group's rods in Rods::local()
    IndexBlocks blocks_;
    std::vector<std::vector<std::byte>> pending_; ///< of each field: [frames, owned rods]
};

/// Frames of one file, by its name in the directory.
struct Segment {
    std::string file;
    std::vector<std::int64_t> steps;
    std::vector<double> times;
};

template <class T> std::vector<T> read_all(const H5File& file, const std::string& path) {
    const std::uint64_t count = file.shape(path).at(0);
    std::vector<T> values(count);
    file.read(path, h5_type<T>(), {{0}, {count}}, values.data());
    return values;
}

/// The numbers of frame `first` and later ones, written by root.
template <class T>
void write_from(H5File& file, const Communicator& comm, const std::string& path, std::uint64_t first, const std::vector<T>& all) {
    file.write(path, h5_type<T>(), {{first}, {comm.root() ? all.size() - first : 0}}, all.data() + first);
}

} // namespace

struct FrameWriter::Impl {
    Communicator comm;
    std::string directory;
    FrameKind kind;
    OutputSpec spec;
    const Threads& threads;
    std::string title;
    std::vector<GroupFrames> groups;
    std::vector<Segment> segments; ///< finished ones
    std::size_t most_pending = 1;  ///< frames
    std::unique_ptr<H5File> file;  ///< of the open segment, once there are frames in it
    Segment open;                  ///< with its pending frames
    std::size_t written = 0;       ///< frames of the open segment
    std::int64_t last_step = -1;

    std::string kind_name() const { return std::string(frame_kind_names[static_cast<std::size_t>(kind)]); }
    std::string path_of(const std::string& name) const { return directory + "/" + name; }
    std::string temporary() const { return path_of(open.file) + ".tmp"; }
    std::vector<std::string> frame_datasets() const {
        std::vector<std::string> paths{"/step", "/time"};
        for (const GroupFrames& group : groups)
            for (auto& path : group.frame_datasets()) paths.push_back(std::move(path));
        return paths;
    }

    /// Removes segments that begin after the step, and unfinished ones; returns the names of the others.
    std::vector<std::string> clear_after(std::int64_t step) const {
        std::string names;
        on_root(comm, [&] {
            for (const auto& found : numbered_files(directory, kind_name() + "_", ".h5.tmp")) remove_file(path_of(found.name));
            for (const auto& found : numbered_files(directory, kind_name() + "_", ".h5")) {
                if (found.number > step) remove_file(path_of(found.name));
                else names += found.name + "\n";
            }
            if (kind == FrameKind::trajectory && (names.empty() || spec.paraview == ParaView::none))
                remove_file(path_of("trajectory.xdmf"));
        });
        names = comm.broadcast(names);
        std::vector<std::string> list;
        for (std::size_t begin = 0, end; (end = names.find('\n', begin)) != names.npos; begin = end + 1)
            list.push_back(names.substr(begin, end - begin));
        return list;
    }

    Segment read_segment(const std::string& name) const {
        H5File segment(comm, path_of(name), H5File::Mode::read);
        Segment found{name, read_all<std::int64_t>(segment, "/step"), read_all<double>(segment, "/time")};
        segment.close();
        return found;
    }

    /// Shortens a segment to its first frames, by way of a copy.
    void cut(Segment& segment, std::size_t frames) const {
        const std::string path = path_of(segment.file), copy = path + ".tmp";
        on_root(comm, [&] { std::filesystem::copy_file(path, copy, std::filesystem::copy_options::overwrite_existing); });
        H5File shorter(comm, copy, H5File::Mode::modify);
        shorter.set_frames(frame_datasets(), frames);
        shorter.close();
        on_root(comm, [&] { publish(copy, path); });
        segment.steps.resize(frames);
        segment.times.resize(frames);
    }

    void keep_up_to(std::int64_t step) {
        for (const std::string& name : clear_after(step)) {
            Segment segment = read_segment(name);
            const auto kept = std::upper_bound(segment.steps.begin(), segment.steps.end(), step) - segment.steps.begin();
            if (kept < static_cast<std::ptrdiff_t>(segment.steps.size())) cut(segment, static_cast<std::size_t>(kept));
            if (kept > 0) last_step = segment.steps.back();
            segments.push_back(std::move(segment));
        }
        if (!segments.empty()) write_side_car();
    }

    /// Frames that `bytes` of memory hold on every rank, so that all ranks write at the same steps.
    void limit_pending(std::uint64_t bytes) {
        std::uint64_t frame = stamp_bytes;
        for (const GroupFrames& group : groups) frame += group.pending_bytes();
        most_pending = std::max<std::size_t>(bytes / static_cast<std::uint64_t>(comm.max(static_cast<std::int64_t>(frame))), 1);
    }

    void open_file(std::uint64_t bytes) {
        file = std::make_unique<H5File>(comm, temporary(), H5File::Mode::create);
        file->reserve(bytes);
        file->set("/", "format", format_name);
        file->set("/", "version", format_version);
        file->set("/", "title", title);
        file->set("/", "kind", kind_name());
        file->make_frames("/step", H5Type::int64, {});
        file->make_frames("/time", H5Type::float64, {});
        file->make_group("/groups");
        for (const GroupFrames& group : groups) group.make(*file, comm);
    }

    void write(std::int64_t step, double time, double lag) {
        if (open.steps.empty()) open.file = fmt::format("{}_{:012d}.h5", kind_name(), step);
        for (GroupFrames& group : groups) group.take(threads, lag, most_pending);
        open.steps.push_back(step);
        open.times.push_back(time);
        last_step = step;
        if (open.steps.size() - written == most_pending) write_pending();
    }

    void write_pending() {
        const std::size_t frames = open.steps.size() - written;
        if (frames == 0) return;
        std::uint64_t bytes = frames * stamp_bytes;
        for (const GroupFrames& group : groups) bytes += frames * group.frame_bytes() + (file ? 0 : group.constant_bytes());
        on_root(comm, [&] { require_space(directory, bytes); });
        if (file) file->reserve(bytes);
        else open_file(bytes);
        file->set_frames(frame_datasets(), open.steps.size());
        write_from(*file, comm, "/step", written, open.steps);
        write_from(*file, comm, "/time", written, open.times);
        for (GroupFrames& group : groups) group.write(*file, written, frames);
        written = open.steps.size();
    }

    void close() {
        if (open.steps.empty()) return;
        write_pending();
        file->close();
        file.reset();
        on_root(comm, [&] {
            for (const GroupFrames& group : groups) group.make_views(temporary(), open.steps.size());
            publish(temporary(), path_of(open.file));
        });
        segments.push_back(std::exchange(open, {}));
        written = 0;
        write_side_car();
    }

    /// Gives up the open segment: after an error it cannot be trusted, and on a full disk it stands in the way.
    void drop() {
        file.reset();
        if (comm.root() && !open.file.empty()) ::unlink(temporary().c_str());
        for (GroupFrames& group : groups) group.drop_pending();
        open = {};
        written = 0;
    }

    void write_side_car() const {
        if (kind != FrameKind::trajectory || spec.paraview == ParaView::none) return;
        on_root(comm, [&] {
            std::vector<XdmfGroup> xdmf_groups;
            std::vector<XdmfSegment> xdmf_segments;
            for (const GroupFrames& group : groups) xdmf_groups.push_back(group.xdmf());
            for (const Segment& segment : segments) xdmf_segments.push_back({segment.file, segment.times});
            write_file(path_of("trajectory.xdmf"),
                       xdmf_document(title, xdmf_groups, xdmf_segments, spec.precision == Precision::single ? 4 : 8));
        });
    }
};

FrameWriter::FrameWriter(const Communicator& comm, std::string directory, FrameKind kind, const OutputSpec& spec,
                         std::span<const RodGroup> groups, const Rods& rods, const Threads& threads, std::int64_t resume_step,
                         std::string title, std::uint64_t buffer_bytes)
    : impl_(new Impl{comm, std::move(directory), kind, spec, threads, std::move(title)}) {
    for (const RodGroup& group : groups) impl_->groups.emplace_back(comm, group, rods, kind, spec);
    impl_->limit_pending(buffer_bytes);
    impl_->keep_up_to(resume_step);
}

FrameWriter::~FrameWriter() = default;

void FrameWriter::write(std::int64_t step, double time, double lag) {
    if (step <= impl_->last_step) return;
    try {
        impl_->write(step, time, lag);
    } catch (const IoError&) {
        impl_->drop();
        throw;
    }
}

void FrameWriter::close_segment() {
    try {
        impl_->close();
    } catch (const IoError&) {
        impl_->drop();
        throw;
    }
}

} // namespace skein
