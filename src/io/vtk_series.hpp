// Frames as poly data for ParaView, whose Tube filter takes them as they are: rods.pvd lists vtp/rods_<step>.vtp,
// walls.pvd lists vtp/walls_<step>.vtp. A frame is written under a temporary name by all ranks, each its share of the
// rods in file order, so its bytes do not depend on their number. They depend on its step and the one before alone (but
// for contact forces where a run resumes), so a run that resumes lists those up to its step and writes later ones over
// what it finds.
#pragma once

#include "io/output_spec.hpp"
#include "io/pvd.hpp"
#include "io/vtk_rods.hpp"
#include "parallel/communicator.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace skein {

class VtkSeries {
public:
    using Warn = std::function<void(const std::string&)>;

    /// Steps of the last frames of rods and of walls that there should be; absent where that is not known.
    struct Expected {
        std::optional<std::int64_t> rods = {}, walls = {};
    };
    /// Goes on after `resume_step` (-1: none), and makes the lists anew. Frames before that are not whole, or not what
    /// was written, are put aside as *.damaged; `warn` (called on root) gets these and gaps. `forces`: null where rods
    /// do not touch. `groups` and `rods` must outlive it. Collective.
    VtkSeries(const Communicator& comm, std::string directory, const OutputSpec& spec, std::span<const RodGroup> groups,
              const Rods& rods, std::int64_t resume_step, NodeForces forces, const Expected& expected,
              const Warn& warn);

    /// Appends the state at time t (synchronised copies: positions drifted on by `lag`). A step that is already there
    /// is left alone. Collective.
    void write(std::int64_t step, double time, double lag);
    /// Rods have new owners from now on. `rods` must outlive it. Collective.
    void follow(const Rods& rods);
    /// Walls of a scene: one frame in all where none moves. Collective.
    void write_walls(std::int64_t step, double time, const PolygonMesh& walls);
    bool has_walls() const { return walls_.last >= 0; }
    /// Steps of the last frames; -1: none.
    std::int64_t last_rods() const { return rods_.last; }
    std::int64_t last_walls() const { return walls_.last; }

    /// Waits until all frames are on the disk. Called before each checkpoint. Collective.
    void flush();

    /// Name of a frame's file in the directory; kinds are rods and walls.
    static std::string frame_name(const std::string& kind, std::int64_t step);
    /// Size of one frame, about.
    static double frame_bytes(const OutputSpec& spec, double lines, double nodes, bool forces);

private:
    struct List {
        std::string kind;
        PvdFile file;           ///< root's
        std::int64_t last = -1; ///< step of the last frame in it
    };
    List list_of(const std::string& kind, std::int64_t resume_step, std::optional<std::int64_t> expected,
                 const Warn& warn) const;
    std::string path_of(const std::string& name) const { return directory_ + "/" + name; }
    /// An empty file of this name's temporary one; returns its path. Root only.
    std::string begin_file(const std::string& name, std::uint64_t bytes) const;
    /// Ends a frame, gives its file the name that it is to have and lists it. `digest`: of its parts. Root only.
    void end_file(List& list, const std::string& name, const VtkPolyData& layout, VtkStamp stamp, double time);
    /// Runs what writes a frame; where that fails what there is of it is removed.
    template <class Deed> void whole_or_not(List& list, std::int64_t step, Deed deed);

    Communicator comm_;
    std::string directory_;
    NodeForces forces_;
    VtkContent content_;
    std::vector<VtkRods> groups_;
    RecordBuffers buffers_;
    List rods_, walls_;
    std::vector<std::string> unflushed_; ///< files that this rank has written to
};

} // namespace skein
