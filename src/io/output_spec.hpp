// What a scene wants written, and how often.
#pragma once

#include "skein/core/fields.hpp"

#include <cstdint>

namespace skein {

enum class Precision { single, double_ };
inline constexpr std::string_view precision_names[] = {"single", "double"};

/// What ParaView is to open beside or in place of the trajectory itself.
enum class ParaView { automatic, vtp, xdmf, none };
inline constexpr std::string_view paraview_names[] = {"auto", "vtp", "xdmf", "none"};

/// What a frame holds: all nodes, or only the last node of every rod.
enum class FrameKind { trajectory, tips };
inline constexpr std::string_view frame_kind_names[] = {"trajectory", "tips"};

/// What a scene may add to its observables.
inline constexpr std::string_view observable_set_names[] = {"angular_momentum", "curvature", "knots", "order"};

/// Intervals in simulated seconds, but where wall time is said, rounded to whole steps; 0 switches an output off: it is
/// then not opened, called or allocated.
struct OutputSpec {
    double trajectory = 0; ///< every node, into HDF5
    bool directors = true; ///< trajectory holds directors too
    Precision precision = Precision::single;
    ParaView paraview = ParaView::automatic;
    double tips = 0;                      ///< last node of every rod, into HDF5
    bool both_ends = false;               ///< and the first one
    double series = 0;                    ///< observables.csv
    std::vector<std::string> observables; ///< sets beyond energies, momentum and extremes
    bool audit = false;                   ///< energy audit
    double fluid_fields = 0;              ///< of the fluid, into HDF5
    double contacts = 0;                  ///< all contacts with their forces, into tables
    double checkpoint = 0;                ///< 0: none by simulated time
    double checkpoint_wall = 900;         ///< of wall time; 0: none by it
    double frames_wall = 0;               ///< of wall time after which frames can be read; 0: at checkpoints
    long keep = 2;                        ///< newest checkpoints
    bool milestones = true;               ///< and older ones at doubling ages
    std::vector<std::string> progress;    ///< columns of the series that the progress line shows

    /// Frames also as poly data: asked for, or by themselves where they are small. `nodes`: of all rods.
    bool writes_vtp(std::int64_t nodes) const;
    static constexpr std::int64_t most_nodes_of_vtp =
        100000; ///< 6 MB a frame, about as much as of the trajectory with directors

    bool observes(std::string_view set) const;

    void fields(FieldVisitor& f);
};

} // namespace skein
