// Frames as poly data for ParaView, whose Tube filter takes them as they are: rods.pvd lists vtp/rods_<step>.vtp, walls.pvd lists
// vtp/walls_<step>.vtp. A frame is written under a temporary name by all ranks, each its share of the rods in file order, so its
// bytes do not depend on their number. The lists name the frames there are; what came after the step at which a run resumes is
// removed, and computed again.
#pragma once

#include "io/output_spec.hpp"
#include "io/vtk_polydata.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "rod/rods.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace skein {

/// Keeps the frames up to a step (-1: none) and lists them: what a directory needs when a run resumes or starts anew. `dt`: of a
/// step, s. Root only.
void keep_vtk_frames(const std::string& directory, std::int64_t step, double dt);

class VtkSeries {
public:
    /// Forces on the nodes of a rod of this rank by its number in the scene, lab, N.
    using NodeForces = std::function<void(std::int64_t gid, std::span<Vec3d> out)>;

    /// Goes on after `resume_step`. `forces`: null where rods do not touch. All but text must outlive it. Collective.
    VtkSeries(const Communicator& comm, std::string directory, const OutputSpec& spec, std::span<const RodGroup> groups,
              const Rods& rods, const Threads& threads, std::int64_t resume_step, double dt, NodeForces forces);
    ~VtkSeries();

    /// Appends the state at time t (synchronised copies: positions drifted on by `lag`). A step that is already there is left
    /// alone. Collective.
    void write(std::int64_t step, double time, double lag);
    /// The walls of a scene, which is one frame alone where none moves. Collective.
    void write_walls(std::int64_t step, double time, const PolygonMesh& walls);

    /// Of one frame, about.
    static double frame_bytes(const OutputSpec& spec, double rods, double nodes, bool forces);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace skein
