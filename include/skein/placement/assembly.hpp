// Assemblies: rods and bodies that are described once, joined to each other, and copied as a whole. Copies of an
// assembly differ in their places alone. Groups of an assembly have all their rods in each copy, copy after copy.
#pragma once

#include "skein/core/quaternion.hpp"
#include "skein/placement/placement_spec.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace skein {

struct AssemblySpec {
    std::string name;
    Placement placement;              ///< places of the copies: origin, d1 and d3 of the assembly's axes
    Vec3d scatter{0, 0, 0};           ///< m: largest random displacement of a copy, lab
    double magnetisation_scatter = 0; ///< largest random relative difference in the strength of copies
    long seed = 1;                    ///< seed of the random numbers
    std::string source;               ///< file:line of the table, for messages

    void fields(FieldVisitor& f);
};

/// Copies of an assembly. A group that is joined but not copied has one copy, in lab axes.
struct AssemblyCopies {
    int number = 0; ///< number of the assembly in the scene
    std::vector<Vec3d> origins{{0, 0, 0}};
    std::vector<Quaterniond> turns; ///< rotations from lab axes to the axes of the copies; empty where none is turned

    std::vector<double> magnetisation; ///< strengths over that of the group; empty where all are alike
    bool lane_each = false;            ///< true where the rods of a copy step as one, in a lane of its own

    std::int64_t count() const { return static_cast<std::int64_t>(origins.size()); }
};

/// Random number, even over [-1, 1): a function of both numbers alone.
double even_random(long seed, std::int64_t number);

/// Reads the copies of an assembly; mask files are searched in `directory`. Throws InputError where one cannot be read.
AssemblyCopies copies_of(const AssemblySpec& spec, int number, const std::string& directory);

} // namespace skein
