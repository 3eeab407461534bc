// What a scene wants written, and how often.
#pragma once

#include "core/fields.hpp"

namespace skein {

enum class Precision { single, double_ };
inline constexpr std::string_view precision_names[] = {"single", "double"};

/// Intervals in seconds, rounded to whole steps; 0 switches an output off: it is then not opened, called or allocated.
struct OutputSpec {
    double trajectory = 0; ///< every node, into HDF5 + XDMF
    bool directors = true; ///< trajectory holds directors too
    Precision precision = Precision::single;
    double tips = 0;       ///< last node of every rod, into HDF5
    double series = 0;     ///< observables.csv
    double checkpoint = 0; ///< 0: only at the end

    void fields(FieldVisitor& f);
};

} // namespace skein
