#include "rod/rest_curvature.hpp"

#include "rod/formulas_along.hpp"
#include "rod/shape_places.hpp"

#include <fmt/format.h>

namespace skein {

std::vector<FormulaFault> read_rest_curvature(Shape& shape, const FormulaScope& names) {
    const std::vector<std::string>& texts = shape.rest_curvature_formula;
    if (texts.empty() || !faults(names).empty()) return {};
    if (texts.size() != 3) return {{{}, fmt::format("a vector is 3 formulas, not {}", texts.size())}};
    std::vector<FormulaFault> found;
    const auto values = values_along(texts, "1/m", shape, vertices_of(shape), names, found);
    if (!found.empty()) return found;
    shape.rest_curvature_profile.clear();
    for (std::size_t k = 0; k < values.front().size(); ++k)
        shape.rest_curvature_profile.push_back({values[0][k], values[1][k], values[2][k]});
    return found;
}

} // namespace skein
