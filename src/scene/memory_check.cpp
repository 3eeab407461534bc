#include "scene/memory_check.hpp"

#include "core/memory.hpp"
#include "core/share_text.hpp"
#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"
#include "skein/core/error.hpp"
#include "skein/rod/rod_group.hpp"

#include <cmath>
#include <string>

#include <fmt/format.h>

namespace skein {

namespace {

/// Places and directions, and of rods that are packed a capsule in the list and in the cells of the grid.
constexpr double bytes_per_place = sizeof(Vec3d) + sizeof(Quaterniond), bytes_per_packed_rod = 4 * bytes_per_place;
/// Constants of an element and its cell, in a group and in the plan's passes over it.
constexpr double bytes_per_element = 2 * (sizeof(ElementConstants) + sizeof(VoronoiConstants));

void refuse(const std::string& where, const std::string& count, double needed) {
    constexpr double little = 1 << 20; // for which nobody looks
    if (needed < little) return;
    const double there = free_memory();
    if (!(needed > there)) return;
    throw InputError(fmt::format("{}: {} need {} of memory, and {} are free here", where, count, bytes_text(needed),
                                 bytes_text(there)));
}

} // namespace

void refuse_beyond_memory(const SceneSpec& scene) {
    for (std::size_t g = 0; g < scene.rods.size(); ++g) {
        const RodSpec& rods = scene.rods[g];
        const std::string where = rods.source.empty() ? path_of_group(scene, g) : rods.source;
        const double elements = rods.body ? 1 : static_cast<double>(rods.shape.elements);
        refuse(where, fmt::format("shape.elements = {} of '{}'", rods.shape.elements, rods.name),
               elements * bytes_per_element);
        if (rods.placement.kind == PlacementKind::packing)
            refuse(where,
                   fmt::format("placement.count = {} packed rods of '{}'", rods.placement.packing.count, rods.name),
                   static_cast<double>(rods.placement.packing.count) * bytes_per_packed_rod);
    }
    for (std::size_t a = 0; a < scene.assemblies.size(); ++a) {
        const AssemblySpec& assembly = scene.assemblies[a];
        double copies = 1;
        for (const long n : assembly.placement.counts) copies *= static_cast<double>(n);
        double rods = 0;
        for (const RodSpec& of : scene.rods)
            if (of.assembly == assembly.name) {
                double here = std::max<double>(1, static_cast<double>(of.placement.origins.size()));
                for (const long n : of.placement.counts) here *= static_cast<double>(n);
                rods += here;
            }
        refuse(
            assembly.source.empty() ? fmt::format("assembly.{}", a) : assembly.source,
            fmt::format("placement.counts: {:.6g} copies of '{}' with {:.6g} rods each", copies, assembly.name, rods),
            copies * (1 + rods) * bytes_per_place);
    }
}

void refuse_run_beyond_memory(const SceneSpec& scene, const Plan& plan) {
    const double needed = plan.state_bytes + plan.frame_bytes, there = free_memory();
    if (!(needed > there)) return;
    throw InputError(fmt::format(
        "{}: {} rods with {} elements need {} of memory to run, and {} are free here; fewer would do, or more "
        "machines: skein plan --ranks tells how many",
        scene.file, plan.rods, plan.elements, bytes_text(needed), bytes_text(there)));
}

} // namespace skein
