#include "fluid/fluid_probe.hpp"

#include "fluid/pressure_gain.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

void FluidProbeSpec::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "first part of its columns in observables.csv", .required = true},
            name);
    f.visit({.name = "at",
             .unit = "m",
             .text = "place, which stays; velocity and pressure are interpolated between the middles of cells",
             .required = true},
            at);
}

namespace {

struct LineShare {
    int cell;
    double share;
};

/// Shares of two cells of a line of `cells` at a distance from the first face, in cells.
std::array<LineShare, 2> line_shares(double distance, int cells, bool periodic) {
    if (cells == 1) return {{{0, 1}, {0, 0}}};
    double first = std::floor(distance - 0.5);
    if (!periodic) first = std::clamp(first, 0.0, cells - 2.0);
    const double share = distance - 0.5 - first;
    const auto within = [&](double cell) { return static_cast<int>(cell - cells * std::floor(cell / cells)); };
    return {{{within(first), 1 - share}, {within(first + 1), share}}};
}

} // namespace

std::vector<CellShare> cell_shares(const FluidGrid& grid, const Vec3d& place) {
    std::array<std::array<LineShare, 2>, 3> line;
    for (int d = 0; d < 3; ++d)
        nth(line, d) = line_shares((component_of(place, d) - component_of(grid.lower, d)) / grid.h, nth(grid.cells, d),
                                   grid.periodic(d));
    std::vector<CellShare> shares;
    for (const LineShare& z : line[2])
        for (const LineShare& y : line[1])
            for (const LineShare& x : line[0])
                if (const double share = x.share * y.share * z.share; share != 0)
                    shares.push_back({{x.cell, y.cell, z.cell}, share});
    return shares;
}

std::array<std::vector<double>, 4> probe_terms(const FlowSolver& flow, const Vec3d& place) {
    const Pencils& pencils = flow.pencils();
    const FieldLayout layout = pencils.layout();
    const Slab rows = pencils.rows(), planes = pencils.planes();
    const std::array<std::ptrdiff_t, 3> ahead{1, layout.row, layout.plane};
    const auto [gain, times] = pressure_in_time(flow).pressure_gain(); // theory.md (77a)
    std::array<std::vector<double>, 4> terms;
    for (const auto& [cell, share] : cell_shares(flow.constants().grid, place)) {
        const int j = cell[1] - rows.first, k = cell[2] - planes.first;
        if (j < 0 || j >= rows.count || k < 0 || k >= planes.count) continue;
        const std::ptrdiff_t at = layout.at(cell[0], j, k);
        for (int c = 0; c < 3; ++c) {
            const std::span<const double> face = flow.velocity(c);
            nth(terms, c).push_back(share * 0.5 * (face[to_index(at)] + face[to_index(at - nth(ahead, c))]));
        }
        const double more = times == 0 ? 0 : times * gain[to_index(at)];
        terms[3].push_back(share * flow.constants().density * (flow.pressure()[to_index(at)] + more));
    }
    return terms;
}

} // namespace skein
