#include "rod/section_formula.hpp"

#include "rod/formulas_along.hpp"
#include "rod/shape_places.hpp"

#include <fmt/format.h>

namespace skein {

std::vector<SectionFault> read_section(RodSpec& rods, const FormulaScope& names) {
    if (!faults(names).empty()) return {};
    std::vector<SectionFault> found;
    const auto read = [&](const char* key, const std::string& text, double radius, std::vector<double>& profile) {
        if (text.empty() || !(radius > 0)) return;
        std::vector<FormulaFault> of_formula;
        const std::vector<double> places = middles_of(rods.shape);
        auto values = values_along({&text, 1}, "m", rods.shape, places, names, of_formula);
        for (std::size_t k = 0; of_formula.empty() && k < places.size(); ++k)
            if (values[0][k] <= 0)
                of_formula.push_back({{0, text.size(), 0},
                                      fmt::format("it is {:g} m at s = {:.6g} m: above 0 is needed", values[0][k],
                                                  places[k] * rods.shape.length)});
        for (const FormulaFault& fault : of_formula) found.push_back({key, fault});
        if (!of_formula.empty()) return;
        for (double& value : values[0]) value /= radius;
        profile = std::move(values[0]);
    };
    Section& section = rods.section;
    read("radius_formula", section.radius_formula, section.radius, section.profile);
    read("radius_2_formula", section.radius_2_formula, section.radius_2, section.profile_2);
    return found;
}

} // namespace skein
