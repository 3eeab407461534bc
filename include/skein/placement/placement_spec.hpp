// Keys of the places where rods start.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/placement/packing_spec.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class PlacementKind { single, line, lattice, mask, list, packing, file };
inline constexpr std::string_view placement_names[] = {"single", "line", "lattice", "mask", "list", "packing", "file"};

/// Meaning of the nodes of a file: shape at rest, or shape at the start alone.
enum class Trace { rest, start };
inline constexpr std::string_view trace_names[] = {"rest", "start"};

/// Places and directions of rods at the start. All rods share tangent and normal (d1), unless they are packed or each
/// has its own. The kind determines `origins`.
struct Placement {
    PlacementKind kind = PlacementKind::single;
    Vec3d origin{0, 0, 0};
    Vec3d tangent{0, 0, 1};          ///< d3 at s = 0
    std::optional<Vec3d> normal;     ///< d1 at s = 0, made orthogonal to the tangent; absent: x, or y for rods along x
    std::vector<long> counts;        ///< line: [n]; lattice: [nx, ny] or [nx, ny, nz]
    std::vector<double> spacing;     ///< m, one per count
    double stagger = 0;              ///< lattice: shift of every other row along x, m
    std::string file;                ///< mask: PBM (P1) bitmap, its "1" pixels carry a rod; file: see docs/files.md
    std::vector<Vec3d> origins;      ///< list
    std::vector<Vec3d> tangents;     ///< list: empty, or d3 at s = 0 of every rod
    std::vector<Vec3d> normals;      ///< list: empty, or d1 at s = 0 of every rod
    Trace trace = Trace::rest;       ///< file with nodes or points
    double unit = 1;                 ///< file: length of 1 in its coordinates, lengths and radii, m
    std::string id;                  ///< file with a row per point: column that names the rod; empty: a common name
    std::vector<std::string> ignore; ///< file of columns: names of those that are skipped
    Packing packing;                 ///< packing

    void fields(FieldVisitor& f);
};

} // namespace skein
