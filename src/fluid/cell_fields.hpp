// Fields of a flow at the middles of cells, for pictures: velocity as the mean of a cell's faces, the gradient of it by
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
    q, ///< half of |rotation|^2 - |strain rate|^2: positive in vortices
    pressure
};

struct CellFieldEntry {
    std::string_view name, unit;
    int components;
};
inline constexpr CellFieldEntry cell_field_table[] = {
    {"velocity", "m/s", 3}, {"vorticity", "1/s", 3}, {"q", "1/s^2", 1}, {"pressure", "Pa", 1}};
inline const CellFieldEntry& entry_of(CellField field) { return nth(cell_field_table, field); }

/// What a flow is, as numbers of cells.
class CellReader {
public:
    explicit CellReader(const FlowPlanes& flow);

    /// Of `count` cells from (i, j, k) on along x, k counted from the first of its planes: [cell][component].
    void row(CellField field, int i, int j, int k, int count, double* out) const;

private:
    /// Of component c along d.
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
