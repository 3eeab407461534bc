// Ghosts of velocities and pressure: conditions at the faces of the box, and values of neighbouring ranks.
#pragma once

#include "fluid/flow.hpp"
#include "fluid/ghost_exchange.hpp"
#include "fluid/line_ends.hpp"
#include "skein/core/index.hpp"

namespace skein {

/// Fields have numbers: 0 to 2 for velocities, then the pressure, then changes of velocities, which are 0 at moving
/// walls.
class FlowBoundary {
public:
    static constexpr int pressure = 3, change = 4;

    /// Condition at a face: ghost = mirrored * inner + fixed. Normal velocities are `fixed` at the face itself.
    struct Edge {
        double mirrored, fixed;
        bool periodic, on_face;
    };

    /// `constants` must outlive the object.
    FlowBoundary(const Communicator& comm, const Threads& threads, const FlowConstants& constants,
                 const Pencils& pencils)
        : threads_(threads), constants_(constants), pencils_(pencils), layout_(pencils.layout()),
          exchange_(comm, pencils, constants.grid) {}

    /// Sets the factor of velocities of walls in ghosts that are filled from now on.
    void set_oscillation(double factor) { oscillation_ = factor; }
    double oscillation() const { return oscillation_; }

    /// Condition of field c at the lower or upper face of direction d.
    Edge edge(int c, int d, bool upper) const {
        const FluidBoundary kind = nth(constants_.grid.boundary, d);
        if (kind == FluidBoundary::periodic) return {0, 0, true, false};
        if (c == pressure) return {1, 0, false, false};
        if (c >= change) {
            Edge same = edge(c - change, d, upper);
            same.fixed = 0;
            return same;
        }
        const double inflow = component_of(constants_.inflow, c);
        if (kind == FluidBoundary::through) {
            if (upper) return {1, 0, false, false}; // pass_outflow() has set the normal velocity at the face
            return {-1, c == d ? inflow : 2 * inflow, false, c == d};
        }
        if (c == d) return {-1, 0, false, true};
        if (kind == FluidBoundary::free_slip) return {1, 0, false, false};
        const Vec3d& wall = nth(constants_.wall_velocity, d)[upper ? 1 : 0];
        return {-1, 2 * oscillation_ * component_of(wall, c), false, false};
    }
    /// Condition at the ends of lines of field c in direction d.
    LineEnds ends(int c, int d) const {
        const Edge lower = edge(c, d, false);
        if (lower.periodic) return LineEnds::periodic;
        if (lower.on_face) return LineEnds::faces_zero;
        return lower.mirrored > 0 ? LineEnds::gradient_zero : LineEnds::value_zero;
    }
    /// True if this rank has the lower or upper face of direction d, and it is not periodic.
    bool has_end(int d, bool upper) const {
        if (constants_.grid.periodic(d)) return false;
        if (d == 1) return pencils_.share() == (upper ? pencils_.across() - 1 : 0);
        return d == 0 || pencils_.slab() == (upper ? pencils_.slabs() - 1 : 0);
    }

    /// Fills ghosts along x and y of a plane, except rows of neighbours.
    void fill_plane(int c, double* field, int k) const {
        const Edge lower_x = edge(c, 0, false), upper_x = edge(c, 0, true);
        const bool shared = pencils_.across() > 1;
        const int beyond = shared ? FieldLayout::ghosts : 0; // rows of neighbours too, since walls may have changed
        const bool profile = constants_.inflow_profile != InflowProfile::uniform && lower_x.fixed != 0;
        for (int j = -beyond; j < layout_.ny + beyond; ++j) {
            Edge lower = lower_x;
            if (profile)
                lower.fixed *= inflow_share(constants_, pencils_.rows().first + j, pencils_.planes().first + k);
            fill_line(field + layout_.at(0, j, k), layout_.nx, 1, 1, lower, upper_x);
        }
        double* const first = field + layout_.at(0, 0, k) - FieldLayout::before;
        if (!shared) return fill_line(first, layout_.ny, layout_.row, layout_.row, edge(c, 1, false), edge(c, 1, true));
        if (has_end(1, false)) fill_below(first, layout_.row, layout_.row, edge(c, 1, false));
        if (has_end(1, true)) fill_above(first, layout_.ny, layout_.row, layout_.row, edge(c, 1, true));
    }
    /// Fills planes of ghosts beyond the box along z.
    void fill_planes(int c, double* field) const {
        double* const first = field + FieldLayout::ghosts * layout_.plane;
        if (has_end(2, false)) fill_below(first, layout_.plane, layout_.plane, edge(c, 2, false));
        if (has_end(2, true)) fill_above(first, layout_.nz, layout_.plane, layout_.plane, edge(c, 2, true));
    }
    /// Fills all ghosts of velocities except those of neighbouring ranks. Not collective.
    void fill_beyond_walls(const std::array<double*, 3>& velocity) const {
        // Planes of neighbours are included, since their walls change too.
        threads_.for_each(to_index(layout_.nz + 2 * FieldLayout::ghosts), [&](std::size_t k, int) {
            for (int c = 0; c < 3; ++c) fill_plane(c, nth(velocity, c), static_cast<int>(k) - FieldLayout::ghosts);
        });
        for (int c = 0; c < 3; ++c) fill_planes(c, nth(velocity, c));
    }
    /// Fills rows and planes of ghosts of fields number `first`, first + 1, ... from neighbours and beyond the box
    /// along z. Collective.
    void fill_ghosts(int first, std::span<double* const> fields) {
        exchange_.exchange_rows(fields);
        exchange_.exchange_planes(fields);
        for (std::size_t f = 0; f < fields.size(); ++f) fill_planes(first + static_cast<int>(f), fields[f]);
    }
    /// Fills rows of ghosts from neighbours. Collective.
    void exchange_rows(std::span<double* const> fields) { exchange_.exchange_rows(fields); }

private:
    /// Fills ghosts below numbers `stride` apart, the first of which is `f`, for `width` adjacent lines.
    static void fill_below(double* f, std::ptrdiff_t stride, std::ptrdiff_t width, const Edge& edge) {
        const auto at = [&](int i) { return f + i * stride; };
        for (std::ptrdiff_t x = 0; x < width; ++x)
            if (edge.on_face) {
                at(-1)[x] = edge.fixed;
                at(-2)[x] = 2 * edge.fixed + edge.mirrored * at(0)[x];
            } else {
                at(-1)[x] = edge.mirrored * at(0)[x] + edge.fixed;
                at(-2)[x] = edge.mirrored * at(1)[x] + edge.fixed;
            }
    }
    /// Fills ghosts above n such numbers.
    static void fill_above(double* f, int n, std::ptrdiff_t stride, std::ptrdiff_t width, const Edge& edge) {
        const auto at = [&](int i) { return f + (n + i) * stride; };
        for (std::ptrdiff_t x = 0; x < width; ++x)
            if (edge.on_face) {
                at(-1)[x] = edge.fixed;
                at(0)[x] = 2 * edge.fixed + edge.mirrored * at(-2)[x];
                at(1)[x] = 2 * edge.fixed + edge.mirrored * at(-3)[x];
            } else {
                at(0)[x] = edge.mirrored * at(-1)[x] + edge.fixed;
                at(1)[x] = edge.mirrored * at(-2)[x] + edge.fixed;
            }
    }
    /// Fills ghosts on both sides.
    static void fill_line(double* f, int n, std::ptrdiff_t stride, std::ptrdiff_t width, const Edge& lower,
                          const Edge& upper) {
        if (!lower.periodic) {
            fill_below(f, stride, width, lower);
            fill_above(f, n, stride, width, upper);
            return;
        }
        const auto at = [&](int i) { return f + i * stride; };
        for (std::ptrdiff_t x = 0; x < width; ++x) {
            at(-1)[x] = at(n - 1)[x];
            at(-2)[x] = at(n - 2)[x];
            at(n)[x] = at(0)[x];
            at(n + 1)[x] = at(1)[x];
        }
    }

    const Threads& threads_;
    const FlowConstants& constants_;
    Pencils pencils_;
    FieldLayout layout_;
    GhostExchange exchange_;
    double oscillation_ = 1; ///< factor of velocities of walls
};

} // namespace skein
