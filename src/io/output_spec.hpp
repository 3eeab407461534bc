// Outputs of a scene and their intervals.
#pragma once

#include "skein/core/fields.hpp"

#include <cstdint>
#include <utility>

namespace skein {

enum class Precision { single, double_ };
inline constexpr std::string_view precision_names[] = {"single", "double"};

/// Files for ParaView beside the trajectory.
enum class ParaView { automatic, vtp, xdmf, none };
inline constexpr std::string_view paraview_names[] = {"auto", "vtp", "xdmf", "none"};

/// Content of a frame: all nodes, or only the last node of every rod.
enum class FrameKind { trajectory, tips };
inline constexpr std::string_view frame_kind_names[] = {"trajectory", "tips"};

/// Optional sets of observables.
inline constexpr std::string_view observable_set_names[] = {"angular_momentum", "curvature", "knots", "order"};

/// Intervals are simulated seconds, unless they are wall time, rounded to whole steps. 0 switches an output off, which
/// is then neither opened nor allocated.
struct OutputSpec {
    double trajectory = 0; ///< every node, into HDF5
    bool directors = true; ///< trajectory holds directors too
    Precision precision = Precision::single;
    ParaView paraview = ParaView::automatic;
    double tips = 0;                       ///< last node of every rod, into HDF5
    bool both_ends = false;                ///< and the first one
    double series = 0;                     ///< observables.csv
    std::vector<std::string> observables;  ///< sets beyond energies, momentum and extremes
    std::vector<std::string> fluid_forces; ///< groups of which each rod and body has columns of its own
    bool fluid_power = false;              ///< work of bodies on a fluid at their surfaces
    bool audit = false;                    ///< energy audit
    double fluid_fields = 0;               ///< fields of the fluid, into HDF5
    double contacts = 0;                   ///< all contacts with their forces, into tables
    double checkpoint = 0;                 ///< 0: none by simulated time
    double checkpoint_wall = 900;          ///< interval of wall time; 0: none by wall time
    double frames_wall = 0;                ///< interval of wall time at which frames become readable; 0: at checkpoints
    long keep = 2;                         ///< newest checkpoints
    bool milestones = true;                ///< and older ones at doubling ages
    std::vector<std::string> progress;     ///< columns of the series that the progress line shows

    /// True if frames are written as poly data too, on demand or because all rods have few `nodes`.
    bool writes_vtp(std::int64_t nodes) const;
    /// Most nodes with automatic poly data: 6 MB a frame, about as much as the trajectory with directors.
    static constexpr std::int64_t most_nodes_of_vtp = 100000;

    bool observes(std::string_view set) const;
    /// Keys and intervals of outputs by simulated time, s; the checkpoint comes last.
    std::vector<std::pair<const char*, double>> intervals() const {
        return {{"trajectory", trajectory}, {"tips", tips},         {"series", series},
                {"fields", fluid_fields},   {"contacts", contacts}, {"checkpoint", checkpoint}};
    }

    void fields(FieldVisitor& f);

private:
    void frame_fields(FieldVisitor& f);
    void checkpoint_fields(FieldVisitor& f);
};

} // namespace skein
