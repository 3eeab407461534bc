// Fields of a flow at the middles of cells, for output. Velocity is the mean of a cell's faces, and its gradient uses
// centred differences.
#pragma once

#include "fluid/whole_planes.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <cstddef>
#include <string_view>

namespace skein {

enum class CellField {
    velocity,
    vorticity,
    q, ///< (|rotation|^2 - |strain rate|^2)/2, positive in vortices
    pressure
};

struct CellFieldEntry {
    std::string_view name, unit;
    int components;
};
inline constexpr CellFieldEntry cell_field_table[] = {
    {"velocity", "m/s", 3}, {"vorticity", "1/s", 3}, {"q", "1/s^2", 1}, {"pressure", "Pa", 1}};
inline const CellFieldEntry& entry_of(CellField field) { return nth(cell_field_table, field); }

/// Computes fields of a flow at cells.
class CellReader {
public:
    explicit CellReader(const FlowPlanes& flow);

    /// Writes `count` cells from (i, j, k) on along x, [cell][component]. Planes k count from the first of `flow`.
    void row(CellField field, int i, int j, int k, int count, double* out) const;

private:
    /// [component][direction].
    using Gradient = std::array<std::array<double, 3>, 3>;
    double centred(std::size_t c, std::ptrdiff_t at) const {
        return 0.5 * (velocity_[c][at] + velocity_[c][at - ahead_[c]]);
    }
    Gradient gradient(std::ptrdiff_t at) const;

    FieldLayout layout_;
    std::array<std::ptrdiff_t, 3> ahead_;
    std::array<const double*, 3> velocity_;
    const double* pressure_;
    double h_, density_;
};

} // namespace skein
