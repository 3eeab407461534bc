#include "io/series_names.hpp"

#include <algorithm>
#include <iterator>

namespace skein {

namespace {

struct Renamed {
    std::string_view now, earlier;
};
constexpr Renamed renamed[] = {
    {"contact_friction_work[J]", "contact_rubbed[J]"}, {"contact_viscous_work[J]", "contact_damped[J]"},
    {"wall_friction_work[J]", "wall_rubbed[J]"},       {"wall_viscous_work[J]", "wall_damped[J]"},
    {"max_overlap[-]", "deepest_overlap[-]"},          {"rebuilds[-]", "renewals[-]"}};

} // namespace

std::string earlier_header(std::string_view header) {
    std::string text;
    for (std::size_t begin = 0; begin < header.size();) {
        const std::size_t end = std::min(header.find_first_of(",\n", begin), header.size());
        const std::string_view name = header.substr(begin, end - begin);
        const auto* found =
            std::find_if(std::begin(renamed), std::end(renamed), [&](const Renamed& r) { return r.now == name; });
        text += found == std::end(renamed) ? name : found->earlier;
        text += header.substr(end, 1);
        begin = end + 1;
    }
    return text;
}

} // namespace skein
