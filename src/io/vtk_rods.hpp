// The rods of a group in frames of poly data: the numbers of each, and where in the file those of this rank's block
// stand. A frame has all groups in the order of the scene, rods in that of their group, and of each array the nodes of
// a rod side by side. A rod is a line; a body some, of two nodes each: its spheres and capsules, and the edges of its
// boxes.
#pragma once

#include "io/output_spec.hpp"
#include "io/vtk_polydata.hpp"
#include "partition/partition.hpp"
#include "tiles/rods.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace skein {

/// Forces on the exposed slots of a rod of this rank by its number in the scene, lab, N. Any thread.
using NodeForces = std::function<void(std::int64_t gid, std::span<Vec3d> out)>;

/// Arrays and sizes of a frame, of all groups together.
struct VtkContent {
    VtkType real = VtkType::float32;
    bool normals = false, forces = false, magnetised = false;
    std::uint64_t lines = 0, nodes = 0; ///< of all groups

    /// Numbers at nodes come first; behind them connectivity, offsets, rod, group, and magnetisation where there is
    /// any.
    std::vector<VtkArray> arrays() const;
    std::size_t node_arrays() const { return 6 + std::size_t{normals} + std::size_t{forces}; }
    std::size_t bytes_per_node() const;
};

class VtkRods {
public:
    /// Its rods stand behind those of `before`, to which they are added. `group` and `rods` must outlive it.
    /// Collective.
    VtkRods(const Communicator& comm, const RodGroup& group, const Rods& rods, VtkContent& before);

    /// Rods have new owners from now on. Collective.
    void follow(const Communicator& comm, const Rods& rods);

    /// This rank's block of the group's rods as they are, all numbers of a rod side by side, in `buffers`. `forces` is
    /// asked where the content has them. Collective.
    std::span<const std::byte> take(const VtkContent& content, double time, double lag, const NodeForces& forces,
                                    RecordBuffers& buffers);
    /// Puts a block where it belongs.
    void write(VtkParts& file, const VtkPolyData& layout, const VtkContent& content,
               std::span<const std::byte> block) const;

private:
    /// Memory of a thread for one rod.
    struct Scratch {
        std::vector<Vec3d> force;
        std::vector<double> numbers;
    };
    std::size_t record_bytes(const VtkContent& content) const {
        return content.bytes_per_node() * static_cast<std::size_t>(nodes());
    }
    /// Of one rod.
    std::int64_t nodes() const;
    std::int64_t lines() const;
    void describe_body(const RodCopy& body, const VtkContent& content, Scratch& scratch) const;
    void find_radii();
    void describe(std::size_t place, const RodCopy& rod, const VtkContent& content, Scratch& scratch) const;
    /// Arrays that are alike in all frames.
    void write_constants(VtkParts& file, const VtkPolyData& layout, const VtkContent& content) const;

    const RodGroup& group_;
    const Rods* rods_;
    OwnedRods owned_;
    IndexBlocks blocks_;
    std::uint64_t first_line_, first_node_; ///< of the group, in a frame
    std::vector<double> radius_;            ///< at nodes; of rods with sizes of their own one after the other
    std::vector<double> magnetisation_;     ///< of this rank's block, lab, unit vectors; none where the group has none
    std::vector<Scratch> scratch_;          ///< by thread
};

} // namespace skein
