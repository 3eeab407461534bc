// Frames as poly data for ParaView's Tube filter: rods.pvd lists vtp/rods_<step>.vtp, walls.pvd lists
// vtp/walls_<step>.vtp. All ranks write a frame under a temporary name, each its share of the rods in file order. So
// the bytes do not depend on the number of ranks. They depend only on its step and the one before, except for contact
// forces after a resume. A resumed run lists frames up to its step and overwrites later ones.
#pragma once

#include "io/frame_files.hpp"
#include "io/output_spec.hpp"
#include "io/pvd.hpp"
#include "io/vtk_rods.hpp"
#include "parallel/communicator.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

class VtkSeries {
public:
    /// Checks earlier frames and rewrites the lists. `forces` is null without contacts, and `expected_walls` is the
    /// last frame of walls that should exist, if known. `groups` and `rods` must outlive the object. Collective.
    VtkSeries(const Communicator& comm, std::string directory, const OutputSpec& spec, std::span<const RodGroup> groups,
              const Rods& rods, NodeForces forces, const EarlierFrames& earlier,
              std::optional<std::int64_t> expected_walls);

    /// Appends the state at a time, in copies whose positions drift by `lag`. Steps that exist are skipped. Collective.
    void write(std::int64_t step, double time, double lag);
    /// Takes rods with new owners, which must outlive the object. Collective.
    void rebind(const Rods& rods);
    /// Writes the walls of a scene; one frame is enough if none moves. Collective.
    void write_walls(std::int64_t step, double time, const PolygonMesh& walls);
    bool has_walls() const { return walls_.last >= 0; }
    /// Steps of the last frames; -1: none.
    std::int64_t last_rods() const { return rods_.last; }
    std::int64_t last_walls() const { return walls_.last; }

    /// Waits until all frames are on the disk, before each checkpoint. Collective.
    void flush();

    /// Name of a frame's file in the directory, of the kind rods or walls.
    static std::string frame_name(const std::string& kind, std::int64_t step);
    /// Approximate size of a frame.
    static double frame_bytes(const OutputSpec& spec, double lines, double nodes, bool forces);

private:
    struct List {
        std::string kind;
        PvdFile file;           ///< root only
        std::int64_t last = -1; ///< step of the last frame
    };
    List list_of(const std::string& kind, const EarlierFrames& earlier) const;
    std::string path_of(const std::string& name) const { return directory_ + "/" + name; }
    /// Makes an empty file with a temporary name and returns its path. Root only.
    std::string begin_file(const std::string& name, std::uint64_t bytes) const;
    /// Stamps a frame, renames its file and lists it. `stamp` has the digest of the parts. Root only.
    void end_file(List& list, const std::string& name, const VtkPolyData& layout, VtkStamp stamp, double time);
    /// Runs `deed`, which writes a frame, and removes an incomplete one if it throws.
    template <class Deed> void whole_or_not(List& list, std::int64_t step, Deed deed);

    Communicator comm_;
    std::string directory_;
    NodeForces forces_;
    VtkContent content_;
    std::vector<VtkRods> groups_;
    RecordBuffers buffers_;
    List rods_, walls_;
    std::vector<std::string> unflushed_; ///< files that this rank has written since flush()
};

} // namespace skein
