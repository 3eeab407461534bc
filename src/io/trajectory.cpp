#include "io/trajectory.hpp"

#include "core/error.hpp"
#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/h5_file.hpp"
#include "io/own_files.hpp"
#include "io/segments.hpp"
#include "io/xdmf.hpp"
#include "partition/partition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
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
constexpr std::uint64_t view_bytes = 4 << 10;                      ///< in the file, of a frame's names of its own, or more

using Shape = std::vector<std::uint64_t>;

/// A quantity of a frame: numbers of one rod, worked out from its state.
struct Field {
    std::string name;
    Shape shape; ///< of one rod
    void (*fill_single)(const RodCopy& rod, float* out);
    void (*fill_double)(const RodCopy& rod, double* out);

    std::size_t numbers() const {
        std::size_t n = 1;
        for (const auto extent : shape) n *= extent;
        return n;
    }
};
template <class Quantity> Field field(std::string name, Shape shape) {
    return {std::move(name), std::move(shape), Quantity::template fill<float>, Quantity::template fill<double>};
}

template <class T, class V> T* put(T* out, const V& x, const V& y, const V& z) {
    *out++ = static_cast<T>(x);
    *out++ = static_cast<T>(y);
    *out++ = static_cast<T>(z);
    return out;
}
template <class T> T* put(T* out, const Vec3<Pack<1>>& v) { return put(out, v.x[0], v.y[0], v.z[0]); }
template <class T> T* put(T* out, const Vec3d& v) { return put(out, v.x, v.y, v.z); }

struct Positions {
    template <class T> static void fill(const RodCopy& rod, T* out) {
        for (const auto& slot : rod.state) out = put(out, slot.position);
    }
};

struct Tip {
    template <class T> static void fill(const RodCopy& rod, T* out) { put(out, rod.state.back().position); }
};

struct Directors {
    template <class T> static void fill(const RodCopy& rod, T* out) {
        for (const Mat3d& q : rod.frames) out = put(put(put(out, q.d1), q.d2), q.d3);
    }
};

/// d1 at nodes: mean of the elements that meet there.
struct Normals {
    template <class T> static void fill(const RodCopy& rod, T* out) {
        const std::size_t last = rod.frames.size() - 1;
        for (std::size_t node = 0; node < rod.state.size(); ++node)
            out = put(out, 0.5 * (rod.frames[node > 0 ? node - 1 : 0].d1 + rod.frames[std::min(node, last)].d1));
    }
};

std::vector<Field> fields_of(FrameKind kind, const OutputSpec& spec, const RodGroup& group) {
    if (kind == FrameKind::tips) return {field<Tip>("position", {3})};
    const auto nodes = static_cast<std::uint64_t>(group.slots());
    std::vector<Field> fields{field<Positions>("position", {nodes, 3})};
    if (spec.directors) {
        fields.push_back(field<Directors>("directors", {nodes - 1, 3, 3}));
        fields.push_back(field<Normals>("normal", {nodes, 3}));
    }
    return fields;
}

Shape prepend(std::uint64_t first, const Shape& rest) {
    Shape shape{first};
    shape.insert(shape.end(), rest.begin(), rest.end());
    return shape;
}

/// Records [rows, columns] as [columns, rows].
std::vector<std::byte> transposed(std::span<const std::byte> records, std::size_t rows, std::size_t columns, std::size_t bytes) {
    std::vector<std::byte> turned(rows * columns * bytes);
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < columns; ++column)
            std::memcpy(&turned[(column * rows + row) * bytes], &records[(row * columns + column) * bytes], bytes);
    return turned;
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
        const std::uint64_t per_node =
            kind_ == FrameKind::trajectory ? (group_.sized() ? 24 : 16) * static_cast<std::uint64_t>(group_.slots()) : 0;
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
    void take(double lag, std::size_t most) {
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            pending_[f].block.need(most * block_rods() * record_bytes(fields_[f]));
            pending_[f].sent.need(most * blocks_.sent() * record_bytes(fields_[f]));
        }
        const std::size_t frame = pending_frames_++;
        rods_.read(local_, directors() ? Copy::frames : Copy::positions, lag, [&](int, std::size_t i, const RodCopy& rod) {
            const auto [own, place] = blocks_.destination(i);
            for (std::size_t f = 0; f < fields_.size(); ++f) {
                std::byte* records = own ? pending_[f].block.data() : pending_[f].sent.data();
                const std::size_t at = frame * (own ? block_rods() : blocks_.sent()) + place;
                std::byte* out = records + at * record_bytes(fields_[f]);
                if (precision_ == Precision::single) fields_[f].fill_single(rod, reinterpret_cast<float*>(out));
                else fields_[f].fill_double(rod, reinterpret_cast<double*>(out));
            }
        });
    }

    /// Writes the pending frames, as many as there are `digests`, from frame `first` on; adds this rank's part to their digests.
    void write(H5File& file, std::uint64_t first, std::span<std::uint64_t> digests) {
        const std::size_t frames = digests.size();
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            const Field& field = fields_[f];
            const std::size_t record = record_bytes(field);
            std::byte* block = pending_[f].block.data();
            // A rod's numbers of all frames travel together.
            const std::span<const std::byte> sent(pending_[f].sent.data(), frames * blocks_.sent() * record);
            blocks_.send(transposed(sent, frames, blocks_.sent(), record), frames * record,
                         [&](std::size_t place, const std::byte* numbers) {
                             for (std::size_t k = 0; k < frames; ++k)
                                 std::memcpy(block + (k * block_rods() + place) * record, numbers + k * record, record);
                         });
            const std::size_t frame = block_rods() * record;
            for (std::size_t k = 0; k < frames; ++k)
                digests[k] += word_digest(std::span<const std::byte>(block + k * frame, frame), number_bytes(),
                                          static_cast<std::uint64_t>(blocks_.begin()) * field.numbers());
            H5Box box{{first, static_cast<std::uint64_t>(blocks_.begin())}, {frames, block_rods()}};
            box.start.resize(2 + field.shape.size(), 0);
            box.count.insert(box.count.end(), field.shape.begin(), field.shape.end());
            file.write(path(field.name), number_type(), box, block);
        }
        pending_frames_ = 0;
    }

    void drop_pending() { pending_frames_ = 0; }

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
    std::size_t block_rods() const { return static_cast<std::size_t>(blocks_.size()); }
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

    /// Rows of this rank's block, of what the owner of a rod alone may know: row(index, out).
    template <class Row> std::vector<double> rows_of_owners(std::size_t width, Row row) const {
        RecordBuffers buffers;
        buffers.begin(blocks_, width * sizeof(double));
        std::vector<double> own(width);
        for (std::size_t i = 0; i < local_.size(); ++i) {
            row(rods_.local()[local_[i]].index, own.data());
            std::memcpy(buffers.record(i), own.data(), width * sizeof(double));
        }
        const auto bytes = buffers.exchange();
        std::vector<double> rows(bytes.size() / sizeof(double));
        if (!rows.empty()) std::memcpy(rows.data(), bytes.data(), bytes.size());
        return rows;
    }
    template <class F> void write_vectors(H5File& file, const std::string& name, F vector_of) const {
        const std::vector<double> rows = rows_of_owners(3, [&](std::int64_t i, double* out) {
            const Vec3d v = vector_of(i);
            out[0] = v.x, out[1] = v.y, out[2] = v.z;
        });
        write_rows<double>(file, name, 3, [&](std::int64_t i, double* out) {
            std::copy_n(&rows[static_cast<std::size_t>(i - blocks_.begin()) * 3], 3, out);
        });
    }

    /// Radius at node k of the undeformed rod: mean of the elements that meet there.
    static double node_radius(const RodGroup& group, std::int64_t k) {
        const std::int64_t last = group.elements() - 1;
        return 0.5 * (group.element[static_cast<std::size_t>(std::max<std::int64_t>(k - 1, 0))].radius +
                      group.element[static_cast<std::size_t>(std::min(k, last))].radius);
    }

    void write_constants(H5File& file, const Communicator& comm) const {
        write_vectors(file, "origin", [&](std::int64_t i) { return group_.origin(i); });
        if (magnetised()) write_vectors(file, "magnetisation", [&](std::int64_t i) { return group_.magnetisation(i); });
        if (kind_ == FrameKind::tips) return;

        const std::int64_t nodes = group_.slots();
        const auto width = static_cast<std::uint64_t>(nodes);
        std::vector<double> radius;
        const auto put_radii = [&](std::int64_t i, double* out) {
            const std::size_t first = group_.sized() ? static_cast<std::size_t>((i - blocks_.begin()) * nodes) : 0;
            std::copy_n(radius.begin() + static_cast<std::ptrdiff_t>(first), nodes, out);
        };
        if (group_.sized()) {
            radius = rows_of_owners(static_cast<std::size_t>(nodes), [&](std::int64_t i, double* out) {
                with_rod(group_, i, [&](const RodGroup& rod) {
                    for (std::int64_t k = 0; k < nodes; ++k) out[k] = node_radius(rod, k);
                });
            });
            write_rows<double>(file, "radius", width, put_radii);
        } else {
            for (std::int64_t k = 0; k < nodes; ++k) radius.push_back(node_radius(group_, k));
            file.make_dataset(path("radius"), H5Type::float64, {width});
            file.write(path("radius"), H5Type::float64, {{0}, {comm.root() ? width : 0}}, radius.data());
        }
        // What only the side-car needs: XDMF knows no repetition.
        write_rows<std::int64_t>(file, "rod", 1, [](std::int64_t i, std::int64_t* out) { *out = i; });
        write_rows<double>(file, "point_radius", width, put_radii);
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
    /// Records of a field that wait to be written: [frames, rods of this rank's block] and [frames, rods of others' blocks].
    struct Pending {
        UnsetArray<std::byte> block, sent;
    };
    std::vector<Pending> pending_; ///< by field
    std::size_t pending_frames_ = 0;
};

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
    std::string title;
    Warn warn; ///< on root
    std::string side_car_name = "trajectory.xdmf";
    std::vector<GroupFrames> groups = {};
    std::vector<std::string> group_names = {};
    std::vector<Segment> segments = {}; ///< finished ones; root only
    std::size_t listed = 0;             ///< of them in the side-car
    std::uint64_t flush_every = 1;      ///< frames of a file
    std::size_t most_pending = 1;       ///< frames
    std::unique_ptr<H5File> file = {};  ///< of the open segment, once there are frames in it
    Segment open = {};                  ///< with its pending frames
    std::size_t written = 0;            ///< frames of the open segment
    bool whole = true;                  ///< false while frames are on their way into it
    std::int64_t last_step = -1;
    std::int64_t last_closed = -1; ///< step of the last frame in finished segments

    std::string kind_name() const { return std::string(frame_kind_names[static_cast<std::size_t>(kind)]); }
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
        std::int64_t before = -1;
        const auto gap = [&](std::int64_t from, std::int64_t to) {
            tell(fmt::format("{}: the frames after step {} and up to step {} are missing from {}", kind_name(), from, to,
                             directory));
        };
        for (const Segment& segment : segments) {
            if (segment.after && *segment.after > before) gap(before, *segment.after);
            before = segment.steps.back();
        }
        if (expected && *expected > before) gap(before, *expected);
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
            put_aside_damaged(name, damaged < 0 ? name + ": cannot be read"
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
            if (comm.root()) segments.back().steps.resize(frames), segments.back().times.resize(frames);
        }
        if (comm.root()) look_for_gaps(expected);
        last_closed = last_step = comm.broadcast(segments.empty() ? std::int64_t{-1} : segments.back().steps.back());
        if (kind != FrameKind::trajectory) return;
        bool old = false;
        on_root(comm, [&] { old = make_way_for_side_car(); });
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
        most_pending = std::max<std::size_t>(bytes / static_cast<std::uint64_t>(comm.max(static_cast<std::int64_t>(frame))), 1);
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
        for (const GroupFrames& group : groups) bytes += frames * group.frame_bytes() + (file ? 0 : group.constant_bytes());
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
        for (std::size_t k = 0; k < frames; ++k) digests[k] += stamp_digest(open.steps[written + k], open.times[written + k]);
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

    /// After an error. What was written before it is kept where that can be done, frames that wait are given up; a segment
    /// that an error has left half written cannot be trusted, and on a full disk it stands in the way.
    void give_up() {
        for (GroupFrames& group : groups) group.drop_pending();
        if (file && whole && written > 0) try {
                close_file();
            } catch (const IoError&) {
            }
        file.reset();
        if (comm.root() && !open.file.empty() && is_unfinished(temporary(), trajectory_format)) ::unlink(temporary().c_str());
        last_step = last_closed;
        open = {};
        written = 0;
        whole = true;
    }

    void write_side_car() {
        if (kind != FrameKind::trajectory) return;
        on_root(comm, [&] {
            listed = segments.size();
            std::vector<XdmfGroup> xdmf_groups;
            std::vector<XdmfSegment> xdmf_segments;
            for (const GroupFrames& group : groups) xdmf_groups.push_back(group.xdmf());
            for (const Segment& segment : segments) xdmf_segments.push_back({segment.file, segment.times});
            write_file(side_car(), xdmf_document(title, xdmf_groups, xdmf_segments, spec.precision == Precision::single ? 4 : 8));
        });
    }
};

FrameWriter::FrameWriter(const Communicator& comm, std::string directory, FrameKind kind, const OutputSpec& spec,
                         std::span<const RodGroup> groups, const Rods& rods, std::int64_t resume_step, std::string title,
                         std::uint64_t buffer_bytes, Warn warn, std::optional<std::int64_t> expected, std::uint64_t flush_bytes)
    : impl_(new Impl{comm, std::move(directory), kind, spec, std::move(title), std::move(warn)}) {
    for (const RodGroup& group : groups) {
        impl_->groups.emplace_back(comm, group, rods, kind, spec);
        impl_->group_names.push_back(group.name());
    }
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
    for (const RodGroup& group : groups) frame.groups.emplace_back(comm, group, rods, FrameKind::trajectory, frame.spec);
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
