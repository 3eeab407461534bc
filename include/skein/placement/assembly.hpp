// Assemblies: rods and bodies that are described once, joined to each other, and copied as a whole. The copies of an
// assembly are alike but for where they stand; groups that belong to one have all their rods in each of them, copy
// after copy.
#pragma once

#include "skein/core/quaternion.hpp"
#include "skein/placement/placement_spec.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace skein {

struct AssemblySpec {
    std::string name;
    Placement placement;    ///< of the copies: where the origin of the assembly's axes is, and their d1 and d3
    Vec3d scatter{0, 0, 0}; ///< m: copies are moved by up to so much, at random, lab
    double magnetisation_scatter = 0; ///< share: the strengths of copies differ by up to so much, at random
    long seed = 1;                    ///< of the random numbers
    std::string source;               ///< file:line of the table, for messages

    void fields(FieldVisitor& f);
};

/// Copies of an assembly. One of its groups that is not copied has one copy, in the lab's axes.
struct AssemblyCopies {
    int number = 0; ///< of the assembly in the scene
    std::vector<Vec3d> origins{{0, 0, 0}};
    std::vector<Quaterniond> turns; ///< from the lab's axes to the copy's; empty: none is turned

    std::vector<double> magnetisation; ///< over that of the group; empty: all alike

    std::int64_t count() const { return static_cast<std::int64_t>(origins.size()); }
};

/// Even over [-1, 1), a function of both numbers alone.
double even_random(long seed, std::int64_t number);

/// Throws InputError where a mask file cannot be read; `directory` is where it is looked for.
AssemblyCopies copies_of(const AssemblySpec& spec, int number, const std::string& directory);

} // namespace skein
