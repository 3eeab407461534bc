#include "io/vtk_rods.hpp"

#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"

#include <cstring>
#include <string_view>

namespace skein {

namespace {

std::string_view text_of(const void* numbers, std::size_t bytes) { return {static_cast<const char*>(numbers), bytes}; }

double* append(double* out, double x) {
    *out = x;
    return out + 1;
}
double* append(double* out, const Vec3d& v) { return append(append(append(out, v.x), v.y), v.z); }

/// Converts numbers to the type in the file.
void convert(std::span<const double> numbers, VtkType real, std::byte* out) {
    if (numbers.empty()) return;
    if (real == VtkType::float64) {
        std::memcpy(out, numbers.data(), numbers.size_bytes());
        return;
    }
    for (const double number : numbers) {
        const auto single = static_cast<float>(number);
        std::memcpy(out, &single, sizeof single);
        out += sizeof single;
    }
}

/// Writes value(0), value(1), ... as integers of an array, from its number `first` on.
template <class Value> void write_integers(VtkParts& file, const VtkPolyData& layout, std::size_t array,
                                           std::uint64_t first, std::uint64_t count, Value value) {
    const std::size_t size = bytes_of(layout.arrays()[array].type);
    std::vector<std::byte> numbers(count * size);
    for (std::uint64_t i = 0; i < count; ++i) {
        const auto wide = static_cast<std::int64_t>(value(i));
        const auto narrow = static_cast<std::int32_t>(wide);
        std::memcpy(&numbers[i * size], size == 8 ? static_cast<const void*>(&wide) : &narrow, size);
    }
    file.write_at(layout.numbers_at(array) + first * size, text_of(numbers.data(), numbers.size()));
}

bool is_magnetised(const RodGroup& group) { return group.spec().magnetisation.pattern != MagnetisationPattern::none; }

} // namespace

std::vector<VtkArray> VtkContent::arrays() const {
    const VtkType integer = nodes < (1u << 31) ? VtkType::int32 : VtkType::int64;
    std::vector<VtkArray> all{
        {VtkPart::points, "Points", real, 3, nodes},        {VtkPart::point_data, "radius", real, 1, nodes},
        {VtkPart::point_data, "velocity", real, 3, nodes},  {VtkPart::point_data, "strain", real, 1, nodes},
        {VtkPart::point_data, "curvature", real, 1, nodes}, {VtkPart::point_data, "energy", real, 1, nodes}};
    if (normals) all.push_back({VtkPart::point_data, "normal", real, 3, nodes});
    if (forces) all.push_back({VtkPart::point_data, "contact_force", real, 3, nodes});
    all.push_back({VtkPart::lines, "connectivity", integer, 1, nodes});
    all.push_back({VtkPart::lines, "offsets", integer, 1, lines});
    all.push_back({VtkPart::cell_data, "rod", VtkType::int64, 1, lines});
    all.push_back({VtkPart::cell_data, "group", VtkType::int32, 1, lines});
    if (magnetised) all.push_back({VtkPart::cell_data, "magnetisation", real, 3, lines});
    return all;
}

std::size_t VtkContent::bytes_per_node() const {
    return bytes_of(real) * (10 + 3 * std::size_t{normals} + 3 * std::size_t{forces});
}

VtkRods::VtkRods(const Communicator& comm, const RodGroup& group, const Rods& rods, VtkContent& before)
    : group_(group), rods_(&rods), owned_(owned_rods(rods, group.id())), blocks_(comm, owned_.indices, group.count()),
      first_line_(before.lines), first_node_(before.nodes), scratch_(to_index(rods.threads())) {
    find_radii();
    before.lines += to_index(group.count() * lines());
    before.nodes += to_index(group.count() * nodes());
    if (is_magnetised(group))
        magnetisation_ = rows_of_owners(blocks_, owned_.indices, 3,
                                        [&](std::int64_t i, double* out) { append(out, group.magnetisation(i)); });
    before.magnetised |= is_magnetised(group);
}

std::int64_t VtkRods::lines() const {
    return group_.body() ? static_cast<std::int64_t>(group_.body()->line.size()) : 1;
}
std::int64_t VtkRods::nodes() const { return group_.body() ? 2 * lines() : group_.slots(); }

void VtkRods::describe_body(const RodCopy& body, const VtkContent& content, Scratch& scratch) const {
    const Slot<1>& s = body.state[0];
    const Vec3d centre = lane(s.position, 0), velocity = lane(s.velocity, 0), spin = lane(s.spin, 0);
    const Quaterniond axes = lane(s.director, 0);
    double* out = scratch.numbers.data();
    const auto each = [&](auto&& number) {
        for (const BodyShape::Line& line : group_.body()->line)
            for (const Vec3d& place : {line.from, line.to}) out = append(out, number(place));
    };
    each([&](const Vec3d& place) { return centre + transpose_times(axes, place); });
    for (const double radius : radius_) out = append(out, radius);
    each([&](const Vec3d& place) { return velocity + transpose_times(axes, cross(spin, place)); });
    for (int strain = 0; strain < 3; ++strain) each([](const Vec3d&) { return 0.0; }); // strain, curvature, energy
    if (content.normals) each([&](const Vec3d&) { return body.frames[0].d1; });
    if (!content.forces) return;
    for (const BodyShape::Line& line : group_.body()->line)
        for (const int end : {0, 1})
            out = append(out, line.slot < 0 ? Vec3d{0, 0, 0} : nth(scratch.force, line.slot + end));
}

void VtkRods::find_radii() {
    radius_.clear();
    const auto put_radii = [this](const RodGroup& rod) {
        for (std::int64_t k = 0; k < nodes(); ++k)
            radius_.push_back(rod.body() ? nth(rod.body()->line, k / 2).radius : node_radius(rod, k));
    };
    if (!group_.heterogeneous()) put_radii(group_);
    else
        for (const std::int64_t i : owned_.indices) with_rod(group_, i, put_radii);
}

void VtkRods::rebind(const Communicator& comm, const Rods& rods) {
    rods_ = &rods;
    owned_ = owned_rods(rods, group_.id());
    blocks_ = IndexBlocks(comm, owned_.indices, group_.count());
    find_radii();
}

void VtkRods::describe(std::size_t place, const RodCopy& rod, const VtkContent& content, Scratch& scratch) const {
    const std::size_t nodes = rod.state.size();
    double* out = scratch.numbers.data();
    const auto each = [&](auto&& number) {
        for (std::size_t i = 0; i < nodes; ++i) out = append(out, number(i));
    };
    const double* radius = radius_.data() + (group_.heterogeneous() ? place * nodes : 0);
    each([&](std::size_t i) { return lane(rod.state[i].position, 0); });
    each([&](std::size_t i) { return radius[i]; });
    each([&](std::size_t i) { return lane(rod.state[i].velocity, 0); });
    each([&](std::size_t i) { return rod.profile[i].strain; });
    each([&](std::size_t i) { return rod.profile[i].curvature; });
    each([&](std::size_t i) { return rod.profile[i].energy; });
    if (content.normals) each([&](std::size_t i) { return rod.normal(i); });
    if (content.forces) each([&](std::size_t i) { return scratch.force[i]; });
}

std::span<const std::byte> VtkRods::take(const VtkContent& content, double time, double lag, const NodeForces& forces,
                                         RecordBuffers& buffers) {
    const std::size_t nodes = to_index(this->nodes());
    for (Scratch& scratch : scratch_) {
        scratch.force.resize(to_index(group_.exposed_slots()));
        scratch.numbers.resize(content.bytes_per_node() / bytes_of(content.real) * nodes);
    }
    buffers.begin(blocks_, record_bytes(content));
    rods_->read(
        owned_.places, Copy::strained, lag,
        [&](int thread, std::size_t i, const RodCopy& rod) {
            Scratch& scratch = nth(scratch_, thread);
            if (content.forces) forces(rods_->local()[owned_.places[i]].gid, scratch.force);
            if (group_.body()) describe_body(rod, content, scratch);
            else describe(i, rod, content, scratch);
            convert(scratch.numbers, content.real, buffers.record(i));
        },
        time);
    return buffers.exchange();
}

void VtkRods::write(VtkParts& file, const VtkPolyData& layout, const VtkContent& content,
                    std::span<const std::byte> block) const {
    const std::size_t record = record_bytes(content), nodes = to_index(this->nodes()),
                      rods_here = to_index(blocks_.size());
    std::size_t within = 0; // offset in a record
    std::vector<std::byte> column;
    for (std::size_t a = 0; a < content.node_arrays(); ++a) {
        const std::size_t per_node = to_index(layout.arrays()[a].components) * bytes_of(content.real);
        const std::size_t per_rod = per_node * nodes;
        column.resize(rods_here * per_rod);
        for (std::size_t i = 0; i < rods_here; ++i)
            std::memcpy(column.data() + i * per_rod, block.data() + i * record + within, per_rod);
        file.write_at(layout.numbers_at(a) + first_node_ * per_node + to_index(blocks_.begin()) * per_rod,
                      text_of(column.data(), column.size()));
        within += per_rod;
    }
    write_constants(file, layout, content);
}

void VtkRods::write_constants(VtkParts& file, const VtkPolyData& layout, const VtkContent& content) const {
    const std::uint64_t nodes = to_index(this->nodes()), of_rod = to_index(lines()), begin = to_index(blocks_.begin()),
                        rods_here = to_index(blocks_.size());
    const std::uint64_t first_node = first_node_ + begin * nodes, first_line = first_line_ + begin * of_rod,
                        of_line = nodes / of_rod, count = rods_here * of_rod;
    std::size_t array = content.node_arrays();
    write_integers(file, layout, array++, first_node, rods_here * nodes,
                   [&](std::uint64_t i) { return first_node + i; });
    write_integers(file, layout, array++, first_line, count,
                   [&](std::uint64_t i) { return first_node + (i + 1) * of_line; });
    write_integers(file, layout, array++, first_line, count, [&](std::uint64_t i) { return begin + i / of_rod; });
    write_integers(file, layout, array++, first_line, count, [&](std::uint64_t) { return group_.id(); });
    if (!content.magnetised) return;
    const std::size_t size = 3 * bytes_of(content.real);
    std::vector<std::byte> numbers(count * size);
    convert(magnetisation_.empty() ? std::vector<double>(3 * count, 0.0) : magnetisation_, content.real,
            numbers.data());
    file.write_at(layout.numbers_at(array) + first_line * size, text_of(numbers.data(), numbers.size()));
}

} // namespace skein
