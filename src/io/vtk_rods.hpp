// Rods of a group in frames of poly data: their numbers, and the place of this rank's block in the file. Groups follow
// the order of the scene, rods that of their group, and nodes of a rod are adjacent in each array. A rod is one line. A
// body has lines of two nodes for its spheres, its capsules and the edges of its boxes.
#pragma once

#include "io/output_spec.hpp"
#include "io/vtk_polydata.hpp"
#include "partition/partition.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace skein {

/// Gives the forces on the exposed slots of a rod of this rank, lab, N, by its number in the scene. Any thread.
using NodeForces = std::function<void(std::int64_t gid, std::span<Vec3d> out)>;

/// Arrays and sizes of a frame of all groups.
struct VtkContent {
    VtkType real = VtkType::float32;
    bool normals = false, forces = false, magnetised = false;
    std::uint64_t lines = 0, nodes = 0; ///< sums over groups

    /// Arrays at nodes, then connectivity, offsets, rod, group, and magnetisation if there is any.
    std::vector<VtkArray> arrays() const;
    std::size_t node_arrays() const { return 6 + std::size_t{normals} + std::size_t{forces}; }
    std::size_t bytes_per_node() const;
};

class VtkRods {
public:
    /// Appends the rods of the group to `before`. `group` and `rods` must outlive the object. Collective.
    VtkRods(const Communicator& comm, const RodGroup& group, const Rods& rods, VtkContent& before);

    /// Takes rods with new owners. Collective.
    void rebind(const Communicator& comm, const Rods& rods);

    /// Copies this rank's block of the group's rods to `buffers`, with adjacent numbers of a rod. It calls `forces` if
    /// the content has them. Collective.
    std::span<const std::byte> take(const VtkContent& content, double time, double lag, const NodeForces& forces,
                                    RecordBuffers& buffers);
    /// Writes a block to its place.
    void write(VtkParts& file, const VtkPolyData& layout, const VtkContent& content,
               std::span<const std::byte> block) const;

private:
    /// Memory of a thread for one rod.
    struct Scratch {
        std::vector<Vec3d> force;
        std::vector<double> numbers;
    };
    std::size_t record_bytes(const VtkContent& content) const { return content.bytes_per_node() * to_index(nodes()); }
    std::int64_t nodes() const; ///< nodes of one rod
    std::int64_t lines() const; ///< lines of one rod
    void describe_body(const RodCopy& body, const VtkContent& content, Scratch& scratch) const;
    void find_radii();
    void describe(std::size_t place, const RodCopy& rod, const VtkContent& content, Scratch& scratch) const;
    /// Writes the arrays that are equal in all frames.
    void write_constants(VtkParts& file, const VtkPolyData& layout, const VtkContent& content) const;

    const RodGroup& group_;
    const Rods* rods_;
    OwnedRods owned_;
    IndexBlocks blocks_;
    std::uint64_t first_line_, first_node_; ///< numbers in a frame
    std::vector<double> radius_;            ///< at nodes of one rod, or of all own rods if these differ
    std::vector<double> magnetisation_;     ///< unit vectors of this rank's block, lab; empty without magnetisation
    std::vector<Scratch> scratch_;          ///< by thread
};

} // namespace skein
