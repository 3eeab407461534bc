#include "io/vtk_series.hpp"

#include "core/error.hpp"
#include "io/descriptor.hpp"
#include "io/disk.hpp"
#include "io/files.hpp"
#include "io/pvd.hpp"
#include "partition/partition.hpp"
#include "rod/rod_profile.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <numeric>

namespace skein {

namespace {

constexpr const char* kinds[] = {"rods", "walls"};
const std::string folder = "vtp";

std::string frame_name(const std::string& kind, std::int64_t step) { return fmt::format("{}/{}_{:012d}.vtp", folder, kind, step); }

std::vector<PvdFile::Entry> frames_up_to(const std::string& directory, const std::string& kind, std::int64_t step, double dt) {
    std::vector<PvdFile::Entry> entries;
    for (const auto& found : numbered_files(directory + "/" + folder, kind + "_", ".vtp"))
        if (found.number <= step) entries.push_back({static_cast<double>(found.number) * dt, folder + "/" + found.name});
    return entries;
}

/// Runs `deed` on all ranks. Where it throws on some, all throw IoError with its message.
void on_all(const Communicator& comm, const std::function<void()>& deed) {
    std::string failure;
    try {
        deed();
    } catch (const std::exception& error) {
        failure = error.what();
    }
    failure = comm.first_text(failure);
    if (!failure.empty()) throw IoError(failure);
}

void write_at(Descriptor& file, std::uint64_t at, const void* data, std::size_t bytes) {
    if (bytes == 0) return;
    if (::lseek(file, static_cast<off_t>(at), SEEK_SET) < 0) throw IoError(fmt::format("a frame cannot be written at {}", at));
    file.write({static_cast<const char*>(data), bytes});
}

/// A quantity at nodes: so many numbers each, from a rod as it is.
struct Quantity {
    std::string name;
    int components;
};

/// What a rod of a frame is worked out from.
struct Sight {
    std::vector<Slot<1>> state;
    std::vector<NodeProfile> profile;
    std::vector<Vec3d> force;
};

double* put(double* out, const Vec3d& v) {
    *out++ = v.x, *out++ = v.y, *out++ = v.z;
    return out;
}

/// One group's rods of this rank, and its block of them in file order.
struct GroupShare {
    const RodGroup& group;
    std::vector<std::size_t> local; ///< places of the group's rods in Rods::local()
    IndexBlocks blocks;
    std::uint64_t first_rod = 0, first_node = 0; ///< of the group, in a frame
};

std::vector<std::size_t> places(const Rods& rods, const RodGroup& group) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < rods.local().size(); ++i)
        if (rods.local()[i].group == group.id()) found.push_back(i);
    return found;
}

std::vector<std::int64_t> indices(const Rods& rods, std::span<const std::size_t> places) {
    std::vector<std::int64_t> found;
    for (const auto place : places) found.push_back(rods.local()[place].index);
    return found;
}

template <class T> std::span<const std::byte> bytes_of(const std::vector<T>& numbers) {
    return std::as_bytes(std::span(numbers.data(), numbers.size()));
}

} // namespace

void keep_vtk_frames(const std::string& directory, std::int64_t step, double dt) {
    const std::string frames = directory + "/" + folder;
    if (!std::filesystem::exists(frames)) return;
    for (const std::string kind : kinds) {
        for (const auto& found : numbered_files(frames, kind + "_", ".vtp.tmp")) remove_file(frames + "/" + found.name);
        for (const auto& found : numbered_files(frames, kind + "_", ".vtp"))
            if (found.number > step) remove_file(frames + "/" + found.name);
        const std::string list = directory + "/" + kind + ".pvd";
        const auto entries = frames_up_to(directory, kind, step, dt);
        if (entries.empty()) remove_file(list);
        else PvdFile(list).restart(entries);
    }
    if (std::filesystem::is_empty(frames)) std::filesystem::remove(frames);
}

struct VtkSeries::Impl {
    Communicator comm;
    std::string directory;
    OutputSpec spec;
    const Rods& rods;
    const Threads& threads;
    NodeForces forces;
    std::vector<Quantity> quantities;
    std::vector<GroupShare> groups;
    std::uint64_t rod_count = 0, node_count = 0;
    bool magnetised = false;
    std::array<PvdFile, 2> lists;             ///< root's, as in `kinds`
    std::array<std::int64_t, 2> last{-1, -1}; ///< step of the last frame
    VtkType real() const { return spec.precision == Precision::single ? VtkType::float32 : VtkType::float64; }

    /// Behind these: connectivity, offsets, rod, group, and magnetisation where there is any.
    std::vector<VtkArray> arrays() const {
        const VtkType integer = node_count < (1u << 31) ? VtkType::int32 : VtkType::int64;
        std::vector<VtkArray> all;
        for (const Quantity& q : quantities)
            all.push_back({q.name == "Points" ? VtkPart::points : VtkPart::point_data, q.name, real(), q.components, node_count});
        all.push_back({VtkPart::lines, "connectivity", integer, 1, node_count});
        all.push_back({VtkPart::lines, "offsets", integer, 1, rod_count});
        all.push_back({VtkPart::cell_data, "rod", VtkType::int64, 1, rod_count});
        all.push_back({VtkPart::cell_data, "group", VtkType::int32, 1, rod_count});
        if (magnetised) all.push_back({VtkPart::cell_data, "magnetisation", real(), 3, rod_count});
        return all;
    }

    std::size_t numbers_per_node() const {
        std::size_t sum = 0;
        for (const Quantity& q : quantities) sum += static_cast<std::size_t>(q.components);
        return sum;
    }

    /// All numbers of a rod: quantity by quantity, node by node.
    void describe(const GroupShare& share, std::size_t place, double time, double lag, Sight& sight, double* out) const {
        const RodGroup& group = share.group;
        const auto nodes = static_cast<std::size_t>(group.slots());
        sight.state.resize(nodes), sight.profile.resize(nodes);
        rods.export_rod(place, sight.state);
        synchronise(group, sight.state, lag);
        rod_profile(group, sight.state, time, sight.profile);
        const auto element = [&](std::size_t node, std::size_t back) { // beside a node, before or after it
            return std::min(node - std::min(node, back), nodes - 2);
        };
        const auto each = [&](auto&& f) {
            for (std::size_t i = 0; i < nodes; ++i) out = f(i);
        };
        each([&](std::size_t i) { return put(out, lane(sight.state[i].position, 0)); });
        each([&](std::size_t i) {
            *out = 0.5 * (group.element[element(i, 1)].radius + group.element[element(i, 0)].radius);
            return out + 1;
        });
        each([&](std::size_t i) { return put(out, lane(sight.state[i].velocity, 0)); });
        for (double NodeProfile::*member : {&NodeProfile::strain, &NodeProfile::curvature, &NodeProfile::energy})
            each([&](std::size_t i) {
                *out = sight.profile[i].*member;
                return out + 1;
            });
        if (spec.directors)
            each([&](std::size_t i) {
                const auto d1 = [&](std::size_t k) { return matrix(lane(sight.state[k].director, 0)).d1; };
                return put(out, 0.5 * (d1(element(i, 1)) + d1(element(i, 0))));
            });
        if (!forces) return;
        sight.force.resize(nodes);
        forces(rods.local()[place].gid, sight.force);
        each([&](std::size_t i) { return put(out, sight.force[i]); });
    }

    /// The numbers of this rank's block of a group's rods, as they go into the file.
    std::vector<std::byte> block(const GroupShare& share, double time, double lag) const {
        const std::size_t size = bytes_of(real()), numbers = numbers_per_node() * static_cast<std::size_t>(share.group.slots());
        std::vector<std::byte> records(share.local.size() * numbers * size);
        std::vector<Sight> sights(static_cast<std::size_t>(threads.count()));
        std::vector<std::vector<double>> rooms(sights.size(), std::vector<double>(numbers));
        threads.for_each(share.local.size(), [&](std::size_t i, int thread) {
            std::vector<double>& room = rooms[static_cast<std::size_t>(thread)];
            describe(share, share.local[i], time, lag, sights[static_cast<std::size_t>(thread)], room.data());
            std::byte* to = &records[i * numbers * size];
            if (real() == VtkType::float64) {
                std::memcpy(to, room.data(), numbers * size);
                return;
            }
            for (const double number : room) {
                const auto single = static_cast<float>(number);
                std::memcpy(to, &single, sizeof single);
                to += sizeof single;
            }
        });
        return share.blocks.to_blocks(records, numbers * size);
    }

    /// Of one array, the part of this rank's block of rods.
    void write_quantities(Descriptor& file, const VtkPolyData& layout, const GroupShare& share,
                          const std::vector<std::byte>& records) const {
        const std::size_t size = bytes_of(real()), nodes = static_cast<std::size_t>(share.group.slots()),
                          record = numbers_per_node() * nodes * size, rods_here = static_cast<std::size_t>(share.blocks.size());
        std::size_t within = 0;
        std::vector<std::byte> column;
        for (std::size_t q = 0; q < quantities.size(); ++q) {
            const std::size_t per_rod = static_cast<std::size_t>(quantities[q].components) * nodes * size;
            column.resize(rods_here * per_rod);
            for (std::size_t i = 0; i < rods_here; ++i)
                std::memcpy(column.data() + i * per_rod, records.data() + i * record + within, per_rod);
            const std::uint64_t before = share.first_node * static_cast<std::uint64_t>(quantities[q].components) * size;
            write_at(file, layout.numbers_at(q) + before + static_cast<std::uint64_t>(share.blocks.begin()) * per_rod,
                     column.data(), column.size());
            within += per_rod;
        }
    }

    /// What does not change from frame to frame.
    void write_constants(Descriptor& file, const VtkPolyData& layout, const GroupShare& share) const {
        const auto nodes = static_cast<std::uint64_t>(share.group.slots()),
                   begin = static_cast<std::uint64_t>(share.blocks.begin()),
                   count = static_cast<std::uint64_t>(share.blocks.size());
        const std::uint64_t first_node = share.first_node + begin * nodes, first_rod = share.first_rod + begin;
        std::size_t array = quantities.size();
        const auto put_integers = [&](std::uint64_t first, std::uint64_t size, auto&& value) {
            const VtkArray& a = layout.arrays()[array];
            std::vector<std::byte> numbers(size * bytes_of(a.type));
            for (std::uint64_t i = 0; i < size; ++i) {
                const auto wide = static_cast<std::int64_t>(value(i));
                const auto narrow = static_cast<std::int32_t>(wide);
                if (a.type == VtkType::int64) std::memcpy(&numbers[i * 8], &wide, 8);
                else std::memcpy(&numbers[i * 4], &narrow, 4);
            }
            write_at(file, layout.numbers_at(array) + first * bytes_of(a.type), numbers.data(), numbers.size());
            ++array;
        };
        put_integers(first_node, count * nodes, [&](std::uint64_t i) { return first_node + i; });
        put_integers(first_rod, count, [&](std::uint64_t i) { return first_node + (i + 1) * nodes; });
        put_integers(first_rod, count, [&](std::uint64_t i) { return begin + i; });
        put_integers(first_rod, count, [&](std::uint64_t) { return share.group.id(); });
        if (!magnetised) return;
        const std::size_t size = 3 * bytes_of(real());
        const bool magnetic = share.group.spec().magnetisation.pattern != MagnetisationPattern::none;
        std::vector<double> moments;
        for (std::uint64_t i = 0; i < count; ++i) {
            const Vec3d m = magnetic ? share.group.magnetisation(static_cast<std::int64_t>(begin + i)) : Vec3d{0, 0, 0};
            moments.insert(moments.end(), {m.x, m.y, m.z});
        }
        const std::vector<float> singles(moments.begin(), moments.end());
        write_at(file, layout.numbers_at(array) + first_rod * size,
                 real() == VtkType::float64 ? static_cast<const void*>(moments.data()) : singles.data(), count * size);
    }

    void begin_file(const std::string& path, const VtkPolyData& layout) const {
        std::filesystem::create_directories(directory + "/" + folder);
        require_space(directory, layout.file_bytes());
        Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
        write_at(file, 0, layout.head().data(), layout.head().size());
        for (std::size_t i = 0; i < layout.arrays().size(); ++i) {
            const std::uint64_t bytes = layout.arrays()[i].bytes();
            write_at(file, layout.count_at(i), &bytes, sizeof bytes);
        }
        write_at(file, layout.tail_at(), VtkPolyData::tail.data(), VtkPolyData::tail.size());
        file.close();
    }

    void write(std::int64_t step, double time, double lag) {
        const std::string name = frame_name(kinds[0], step), path = directory + "/" + name, temporary = path + ".tmp";
        const VtkPolyData layout(node_count, rod_count, 0, arrays(), time);
        on_root(comm, [&] { begin_file(temporary, layout); });
        std::vector<std::vector<std::byte>> records;
        for (const GroupShare& share : groups) records.push_back(block(share, time, lag));
        on_all(comm, [&] {
            Descriptor file(temporary, O_WRONLY);
            for (std::size_t g = 0; g < groups.size(); ++g) {
                write_quantities(file, layout, groups[g], records[g]);
                write_constants(file, layout, groups[g]);
            }
            if (comm.size() > 1) file.flush();
            file.close();
        });
        on_root(comm, [&] {
            publish(temporary, path);
            lists[0].append({time, name});
        });
        last[0] = step;
    }

    void write_walls(std::int64_t step, double time, const PolygonMesh& walls) {
        on_root(comm, [&] {
            std::filesystem::create_directories(directory + "/" + folder);
            const std::string name = frame_name(kinds[1], step);
            write_file(directory + "/" + name, vtk_document(walls, "wall", time));
            lists[1].append({time, name});
        });
        last[1] = step;
    }
};

VtkSeries::VtkSeries(const Communicator& comm, std::string directory, const OutputSpec& spec, std::span<const RodGroup> groups,
                     const Rods& rods, const Threads& threads, std::int64_t resume_step, double dt, NodeForces forces)
    : impl_(new Impl{.comm = comm,
                     .directory = directory,
                     .spec = spec,
                     .rods = rods,
                     .threads = threads,
                     .forces = std::move(forces),
                     .quantities = {{"Points", 3}, {"radius", 1}, {"velocity", 3}, {"strain", 1}, {"curvature", 1}, {"energy", 1}},
                     .lists = {PvdFile(directory + "/rods.pvd"), PvdFile(directory + "/walls.pvd")}}) {
    if (spec.directors) impl_->quantities.push_back({"normal", 3});
    if (impl_->forces) impl_->quantities.push_back({"contact_force", 3});
    for (const RodGroup& group : groups) {
        std::vector<std::size_t> local = places(rods, group);
        IndexBlocks blocks(comm, indices(rods, local), group.count());
        impl_->groups.push_back({group, std::move(local), std::move(blocks), impl_->rod_count, impl_->node_count});
        impl_->rod_count += static_cast<std::uint64_t>(group.count());
        impl_->node_count += static_cast<std::uint64_t>(group.count()) * static_cast<std::uint64_t>(group.slots());
        impl_->magnetised |= group.spec().magnetisation.pattern != MagnetisationPattern::none;
    }
    on_root(comm, [&] {
        for (std::size_t kind = 0; kind < std::size(kinds); ++kind) {
            const auto entries = frames_up_to(directory, kinds[kind], resume_step, dt);
            if (entries.empty()) continue;
            impl_->lists[kind].restart(entries);
            impl_->last[kind] = std::llround(entries.back().time / dt);
        }
    });
    for (std::int64_t& step : impl_->last) step = comm.broadcast(step);
}

VtkSeries::~VtkSeries() = default;

void VtkSeries::write(std::int64_t step, double time, double lag) {
    if (step <= impl_->last[0]) return;
    try {
        impl_->write(step, time, lag);
    } catch (const IoError&) { // on a full disk what is left stands in the way
        if (impl_->comm.root()) ::unlink((impl_->directory + "/" + frame_name(kinds[0], step) + ".tmp").c_str());
        throw;
    }
}

void VtkSeries::write_walls(std::int64_t step, double time, const PolygonMesh& walls) {
    if (step > impl_->last[1]) impl_->write_walls(step, time, walls);
}

double VtkSeries::frame_bytes(const OutputSpec& spec, double rods, double nodes, bool forces) {
    const double numbers = 10 + (spec.directors ? 3 : 0) + (forces ? 3 : 0), size = spec.precision == Precision::single ? 4 : 8;
    return nodes * (numbers * size + 4) + rods * 16;
}

} // namespace skein
