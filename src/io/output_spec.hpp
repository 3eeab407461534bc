// What a scene wants written, and how often.
#pragma once

#include "core/fields.hpp"

#include <cstdint>

namespace skein {

enum class Precision { single, double_ };
inline constexpr std::string_view precision_names[] = {"single", "double"};

/// What ParaView is to open beside or in place of the trajectory itself.
enum class ParaView { automatic, vtp, xdmf, none };
inline constexpr std::string_view paraview_names[] = {"auto", "vtp", "xdmf", "none"};

/// What a scene may add to its observables.
inline constexpr std::string_view observable_set_names[] = {"angular_momentum", "curvature", "knots"};

/// Intervals in seconds, rounded to whole steps; 0 switches an output off: it is then not opened, called or allocated.
struct OutputSpec {
    double trajectory = 0; ///< every node, into HDF5 + XDMF
    bool directors = true; ///< trajectory holds directors too
    Precision precision = Precision::single;
    ParaView paraview = ParaView::automatic;
    double tips = 0;                      ///< last node of every rod, into HDF5
    double series = 0;                    ///< observables.csv
    std::vector<std::string> observables; ///< sets beyond energies, momentum and extremes
    bool audit = false;                   ///< energy audit
    double contacts = 0;                  ///< all contacts with their forces, into tables
    double checkpoint = 0;                ///< 0: only at the end

    /// Frames also as poly data: asked for, or by themselves where they are small. `nodes`: of all rods.
    bool writes_vtp(std::int64_t nodes) const;
    static constexpr std::int64_t most_nodes_of_vtp = 100000; ///< 5 MB a frame, less than the trajectory with its directors

    bool observes(std::string_view set) const;

    void fields(FieldVisitor& f);
};

} // namespace skein
