#include "rod/bearing.hpp"

#include "skein/core/index.hpp"

#include <string>

namespace skein {

std::vector<Bearing> bearings_of(const RodGroup& group) {
    std::vector<Bearing> all;
    const Hold& hold = group.spec().hold;
    if (hold.elements.empty() || group.law() == Law::elastica) return all;
    const auto is_held = [&](char axis) { return hold.axes.find(axis) != std::string::npos ? 1.0 : 0.0; };
    const Vec3d held{is_held('x'), is_held('y'), is_held('z')};
    const double axes = held.x + held.y + held.z;
    if (axes == 3) return all;
    const bool turns_about = axes == 2;
    const Vec3d axis = turns_about ? Vec3d{1, 1, 1} - held : held;
    for (const long k : hold.elements) {
        const int element = static_cast<int>(k < 0 ? group.elements() + k : k);
        if (!group.holds_element(element)) all.push_back({element, axis, turns_about});
    }
    return all;
}

} // namespace skein
