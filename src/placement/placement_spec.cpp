#include "skein/placement/placement_spec.hpp"

namespace skein {

void Placement::fields(FieldVisitor& f) {
    f.choice(
        {.name = "kind",
         .text =
             "single rod, `line` or `lattice` of rods, `mask` bitmap, `list` of origins, `packing` at random without "
             "overlap, `file` of "
             "rods"},
        kind, placement_names);
    f.visit({.name = "origin", .unit = "m", .text = "start of the first rod"}, origin);
    f.visit({.name = "tangent", .unit = "-", .text = "direction of every rod at its start (d3)"}, tangent);
    f.visit_optional(
        {.name = "normal",
         .unit = "-",
         .text = "direction of d1 at the start, made orthogonal to the tangent; default: x, or y for rods along x"},
        normal);
    f.visit(
        {.name = "counts", .unit = "-", .text = "line: [n] along x; lattice: [nx, ny] or [nx, ny, nz]", .at_least = 1},
        counts);
    f.visit({.name = "spacing",
             .unit = "m",
             .text = "distance between neighbours, one per count (mask: [dx, dy])",
             .above = 0},
            spacing);
    f.visit({.name = "stagger",
             .unit = "m",
             .text = "lattice: shift of every other row along x, of rows whose numbers along y and z have an odd sum",
             .at_least = 0},
            stagger);
    f.visit({.name = "file",
             .text = "path relative to the scene; mask: PBM (P1) bitmap, each 1 carries a rod, the last row is y = 0; "
                     "file: .h5, .npz, .npy, .csv, .tsv, .swc or .bcc, with a row per rod or points along rods "
                     "(docs/files.md)"},
            file);
    f.visit({.name = "origins", .unit = "m", .text = "list: start of every rod"}, origins);
    f.visit({.name = "tangents", .unit = "-", .text = "list: direction of each rod at its start; replaces `tangent`"},
            tangents);
    f.visit({.name = "normals",
             .unit = "-",
             .text = "list: direction of d1 of each rod, beside `tangents`; replaces `normal`"},
            normals);
    f.choice({.name = "trace",
              .text = "file with nodes or points: they give the shape at rest, or the shape at the start alone"},
             trace, trace_names);
    f.visit({.name = "unit",
             .unit = "m",
             .text = "file: length of 1 in its coordinates, lengths and radii; 1e-6 for a file in micrometres",
             .above = 0},
            unit);
    f.visit({.name = "id",
             .text = "file with a row per point: column that names the rod; default: `filament`, `track`, `rod` or "
                     "another of the names in docs/files.md"},
            id);
    f.visit({.name = "ignore", .text = "file of columns: names of columns that are skipped"}, ignore);
    packing.fields(f);
}

void Packing::fields(FieldVisitor& f) {
    f.visit(
        {.name = "count",
         .unit = "-",
         .text = "packing: number of rods; straight rods are placed clear of all groups above this one in the scene",
         .at_least = 1},
        count);
    f.visit(
        {.name = "seed",
         .unit = "-",
         .text = "packing: seed of the random numbers; a placement depends on nothing else, so give each group its own",
         .at_least = 0},
        seed);
    f.choice({.name = "region",
              .text = "packing: region that contains the rods with their whole width; a slab is a box that grows "
                      "upwards as needed"},
             region, packing_region_names);
    f.visit({.name = "lower", .unit = "m", .text = "packing: corner of the box or slab"}, lower);
    f.visit({.name = "upper", .unit = "m", .text = "packing: opposite corner; a slab uses x and y alone"}, upper);
    f.visit({.name = "point", .unit = "m", .text = "packing: cylinder, centre of its base; its axis is z"}, point);
    f.visit({.name = "radius", .unit = "m", .text = "packing: radius of the cylinder", .at_least = 0}, radius);
    f.visit({.name = "height", .unit = "m", .text = "packing: height of the cylinder", .at_least = 0}, height);
    f.visit({.name = "elevation",
             .unit = "deg",
             .text = "packing: least and largest angle of the rods above the horizontal plane",
             .at_least = -90,
             .at_most = 90},
            elevation);
    f.visit({.name = "azimuth",
             .unit = "deg",
             .text = "packing: least and largest angle of the rods around z, from x",
             .at_least = -360,
             .at_most = 360},
            azimuth);
    f.choice({.name = "elevation_law",
              .text = "packing: distribution of the elevation, even in solid angle or in the angle itself"},
             elevation_law, elevation_law_names);
    f.visit({.name = "gap",
             .unit = "m",
             .text = "packing: least distance of surfaces; 0 stands for 0.05 radii",
             .at_least = 0},
            gap);
    f.visit({.name = "attempts",
             .unit = "-",
             .text = "packing: attempts to place a rod in one direction, then as many in new directions, before the "
                     "packing fails; a "
                     "slab grows by a layer after a hundredth of them",
             .at_least = 1},
            attempts);
}

} // namespace skein
