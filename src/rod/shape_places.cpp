#include "rod/shape_places.hpp"

#include "skein/core/index.hpp"

namespace skein {

std::vector<double> nodes_of(const Shape& shape) {
    std::vector<double> at{0};
    for (long i = 0; i < shape.elements; ++i)
        at.push_back(at.back() + (shape.length_profile.empty() ? 1 : nth(shape.length_profile, i)));
    for (double& s : at) s /= at.back();
    return at;
}

std::vector<double> middles_of(const Shape& shape) {
    const auto node = nodes_of(shape);
    std::vector<double> at;
    for (std::size_t i = 0; i + 1 < node.size(); ++i) at.push_back(0.5 * (node[i] + node[i + 1]));
    return at;
}

std::vector<double> vertices_of(const Shape& shape) {
    const auto node = nodes_of(shape);
    return {node.begin() + 1, node.end() - (shape.closed ? 0 : 1)};
}

} // namespace skein
