#include "io/group_frames.hpp"

#include "io/segments.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace skein {

namespace {

using Shape = std::vector<std::uint64_t>;

constexpr std::uint64_t frame_view_bytes = 4 << 10; // upper bound for the datasets of a single frame in the file

/// Field with numbers by fill(rod, out) for both types of numbers.
template <class Fill> FrameField field(std::string name, Shape shape, Fill fill) {
    return {std::move(name), std::move(shape), fill, fill};
}

template <class T, class V> T* put(T* out, const V& x, const V& y, const V& z) {
    *out++ = static_cast<T>(x);
    *out++ = static_cast<T>(y);
    *out++ = static_cast<T>(z);
    return out;
}
template <class T> T* put(T* out, const Vec3<Pack<1>>& v) { return put(out, v.x[0], v.y[0], v.z[0]); }
template <class T> T* put(T* out, const Vec3d& v) { return put(out, v.x, v.y, v.z); }

std::vector<FrameField> fields_of(FrameKind kind, const OutputSpec& spec, const RodGroup& group) {
    if (kind == FrameKind::tips) {
        std::vector<FrameField> ends{
            field("position", {3}, [](const RodCopy& rod, auto* out) { put(out, rod.state.back().position); })};
        if (spec.both_ends)
            ends.push_back(
                field("start", {3}, [](const RodCopy& rod, auto* out) { put(out, rod.state.front().position); }));
        return ends;
    }
    const std::uint64_t nodes = to_index(group.slots()), elements = to_index(group.elements());
    std::vector<FrameField> fields{field("position", {nodes, 3}, [](const RodCopy& rod, auto* out) {
        for (const auto& slot : rod.state) out = put(out, slot.position);
    })};
    if (spec.directors) {
        fields.push_back(field("directors", {elements, 3, 3}, [](const RodCopy& rod, auto* out) {
            for (const Mat3d& q : rod.frames) out = put(put(put(out, q.d1), q.d2), q.d3);
        }));
        fields.push_back(field("normal", {nodes, 3}, [](const RodCopy& rod, auto* out) {
            for (std::size_t node = 0; node < rod.state.size(); ++node) out = put(out, rod.normal(node));
        }));
    }
    return fields;
}

Shape prepend(std::uint64_t first, const Shape& rest) {
    Shape shape{first};
    shape.insert(shape.end(), rest.begin(), rest.end());
    return shape;
}

/// Transposes records [rows, columns] to [columns, rows].
std::vector<std::byte> transposed(std::span<const std::byte> records, std::size_t rows, std::size_t columns,
                                  std::size_t bytes) {
    std::vector<std::byte> turned(rows * columns * bytes);
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < columns; ++column)
            std::memcpy(&turned[(column * rows + row) * bytes], &records[(row * columns + column) * bytes], bytes);
    return turned;
}

} // namespace

GroupFrames::GroupFrames(const Communicator& comm, const RodGroup& group, const Rods& rods, FrameKind kind,
                         const OutputSpec& spec)
    : group_(group), rods_(&rods), kind_(kind),
      type_(spec.precision == Precision::single ? H5Type::float32 : H5Type::float64),
      fields_(fields_of(kind, spec, group)), owned_(owned_rods(rods, group.id())),
      blocks_(comm, owned_.indices, group.count()), pending_(fields_.size()) {}

void GroupFrames::rebind(const Communicator& comm, const Rods& rods) {
    rods_ = &rods;
    owned_ = owned_rods(rods, group_.id());
    IndexBlocks blocks(comm, owned_.indices, group_.count());
    std::swap(blocks, blocks_);
    if (pending_frames_ > 0 && !pending_blocks_) pending_blocks_ = std::move(blocks);
}

std::uint64_t GroupFrames::frame_bytes() const {
    return count() * rod_bytes() + (kind_ == FrameKind::trajectory ? frame_view_bytes : 0);
}

std::uint64_t GroupFrames::constant_bytes() const {
    const std::uint64_t per_node = kind_ == FrameKind::trajectory
                                       ? (group_.heterogeneous() ? 24 : 16) * static_cast<std::uint64_t>(group_.slots())
                                       : 0;
    const std::size_t parts = group_.body() ? group_.body()->part.size() : 0;
    return count() * (per_node + 56) + 88 * parts + 8 * static_cast<std::uint64_t>(group_.slots()) +
           fields_.size() * H5File::frames_slack;
}

std::size_t GroupFrames::rod_bytes() const {
    std::size_t bytes = 0;
    for (const FrameField& field : fields_) bytes += record_bytes(field);
    return bytes;
}

void GroupFrames::make(H5File& file, const Communicator& comm) const {
    file.make_group(path());
    for (const FrameField& field : fields_) file.make_frames(path(field.name), type_, prepend(count(), field.shape));
    write_constants(file, comm);
}

std::vector<std::string> GroupFrames::frame_datasets() const {
    std::vector<std::string> paths;
    for (const FrameField& field : fields_) paths.push_back(path(field.name));
    return paths;
}

void GroupFrames::take(double lag, std::size_t most) {
    for (std::size_t f = 0; f < fields_.size(); ++f) {
        pending_[f].block.need(most * block_rods() * record_bytes(fields_[f]));
        pending_[f].sent.need(most * blocks_.sent() * record_bytes(fields_[f]));
    }
    const std::size_t frame = pending_frames_++;
    rods_->read(owned_.places, directors() ? Copy::frames : Copy::positions, lag,
                [&](int, std::size_t i, const RodCopy& rod) {
                    const auto [own, place] = blocks_.destination(i);
                    for (std::size_t f = 0; f < fields_.size(); ++f) {
                        std::byte* records = own ? pending_[f].block.data() : pending_[f].sent.data();
                        const std::size_t at = frame * (own ? block_rods() : blocks_.sent()) + place;
                        std::byte* out = records + at * record_bytes(fields_[f]);
                        if (type_ == H5Type::float32) fields_[f].fill_single(rod, reinterpret_cast<float*>(out));
                        else fields_[f].fill_double(rod, reinterpret_cast<double*>(out));
                    }
                });
}

void GroupFrames::write(H5File& file, std::uint64_t first, std::span<std::uint64_t> digests) {
    const std::size_t frames = digests.size();
    const IndexBlocks& blocks = pending_blocks_ ? *pending_blocks_ : blocks_;
    for (std::size_t f = 0; f < fields_.size(); ++f) {
        const FrameField& field = fields_[f];
        const std::size_t record = record_bytes(field);
        std::byte* block = pending_[f].block.data();
        // A rod's numbers of all frames are sent together.
        const std::span<const std::byte> sent(pending_[f].sent.data(), frames * blocks.sent() * record);
        blocks.send(transposed(sent, frames, blocks.sent(), record), frames * record,
                    [&](std::size_t place, const std::byte* numbers) {
                        for (std::size_t k = 0; k < frames; ++k)
                            std::memcpy(block + (k * block_rods() + place) * record, numbers + k * record, record);
                    });
        const std::size_t frame = block_rods() * record;
        for (std::size_t k = 0; k < frames; ++k)
            digests[k] += word_digest(std::span<const std::byte>(block + k * frame, frame), bytes_of(type_),
                                      static_cast<std::uint64_t>(blocks.begin()) * field.numbers());
        H5Box box{{first, static_cast<std::uint64_t>(blocks.begin())}, {frames, block_rods()}};
        box.start.resize(2 + field.shape.size(), 0);
        box.count.insert(box.count.end(), field.shape.begin(), field.shape.end());
        file.write(path(field.name), type_, box, block);
    }
    drop_pending();
}

void GroupFrames::make_views(const std::string& file, std::uint64_t frames) const {
    if (kind_ == FrameKind::tips) return;
    std::vector<std::string> names;
    for (const FrameField& field : fields_)
        if (field.name != "directors") names.push_back(field.name);
    make_frame_views(file, path(), names, frames);
}

template <class T> void GroupFrames::write_rows(H5File& file, const std::string& name, const std::vector<T>& rows,
                                                std::uint64_t width) const {
    const std::uint64_t begin = to_index(blocks_.begin()), size = to_index(blocks_.size());
    file.make_dataset(path(name), h5_type<T>(), {count(), width});
    file.write(path(name), h5_type<T>(), {{begin, 0}, {size, width}}, rows.data());
}

void GroupFrames::write_table(H5File& file, const Communicator& comm, const std::string& name,
                              const std::vector<double>& numbers, std::vector<std::uint64_t> shape) const {
    file.make_dataset(path(name), H5Type::float64, shape);
    const std::vector<std::uint64_t> start(shape.size(), 0);
    if (!comm.root()) shape[0] = 0;
    file.write(path(name), H5Type::float64, {start, shape}, numbers.data());
}

std::vector<double> GroupFrames::node_radii() const {
    const auto put_radii = [&](const RodGroup& rod, double* out) {
        for (std::int64_t k = 0; k < group_.slots(); ++k) out[k] = node_radius(rod, k);
    };
    if (group_.heterogeneous())
        return rows_of_owners(blocks_, owned_.indices, to_index(group_.slots()), [&](std::int64_t i, double* out) {
            with_rod(group_, i, [&](const RodGroup& rod) { put_radii(rod, out); });
        });
    std::vector<double> radii(to_index(group_.slots()));
    put_radii(group_, radii.data());
    return radii;
}

void GroupFrames::write_constants(H5File& file, const Communicator& comm) const {
    const auto write_vectors = [&](const std::string& name, auto vector_of) {
        write_rows(
            file, name,
            rows_of_owners(blocks_, owned_.indices, 3, [&](std::int64_t i, double* out) { put(out, vector_of(i)); }),
            3);
    };
    write_vectors("origin", [&](std::int64_t i) { return group_.origin(i); });
    if (magnetised()) write_vectors("magnetisation", [&](std::int64_t i) { return group_.magnetisation(i); });
    if (kind_ == FrameKind::tips) return;

    const std::uint64_t nodes = to_index(group_.slots());
    std::vector<double> radii = node_radii();
    if (group_.heterogeneous()) write_rows(file, "radius", radii, nodes);
    else write_table(file, comm, "radius", radii, {nodes});
    if (group_.body()) write_parts(file, comm);
    std::vector<std::int64_t> rods(block_rods()), corners(block_rods() * nodes);
    std::iota(rods.begin(), rods.end(), blocks_.begin());
    std::iota(corners.begin(), corners.end(), blocks_.begin() * group_.slots());
    write_rows(file, "rod", rods, 1);
    // XDMF has no repetition, so that the side-car needs the radii of each rod.
    if (!group_.heterogeneous()) {
        std::vector<double> repeated;
        for (std::size_t i = 0; i < block_rods(); ++i) repeated.insert(repeated.end(), radii.begin(), radii.end());
        radii = std::move(repeated);
    }
    write_rows(file, "point_radius", radii, nodes);
    write_rows(file, "connectivity", corners, nodes);
}

void GroupFrames::write_parts(H5File& file, const Communicator& comm) const {
    std::vector<double> capsules, boxes;
    for (const BodyShape::Part& p : group_.body()->part)
        if (p.box)
            boxes.insert(boxes.end(), {p.from.x, p.from.y, p.from.z, p.axes.w, p.axes.v.x, p.axes.v.y, p.axes.v.z,
                                       p.half.x, p.half.y, p.half.z, p.radius});
        else capsules.insert(capsules.end(), {p.from.x, p.from.y, p.from.z, p.to.x, p.to.y, p.to.z, p.radius});
    if (!capsules.empty()) write_table(file, comm, "capsules", capsules, {capsules.size() / 7, 7});
    if (!boxes.empty()) write_table(file, comm, "boxes", boxes, {boxes.size() / 11, 11});
}

} // namespace skein
