// Vertices of pairs, and contacts that begin near one: there the spring of a neighbour's contact is taken over.
#pragma once

#include "contact/broad_phase.hpp"

namespace skein {

constexpr double shallow =
    0.25; ///< sine of the angle below which elements begin to push by themselves near their vertices
constexpr double blend = 0.05; ///< sine of the angle below which elements meet at both ends of their overlap as well
constexpr double least_lying = 0.125; ///< Q/S above which a rod begins to lie along the other one
constexpr double most_lying = 0.5;    ///< Q/S from which it does; two rods wound round each other do from 1/2 on

/// Side of a contact on its element: -1 near a vertex at the start, 1 near one at the end, 0 elsewhere, where no
/// neighbour has its spring.
inline std::int8_t vertex_side(double s, unsigned vertices, double reach) {
    const double near = 1.25 * reach * (1 + 1e-6);
    return static_cast<std::int8_t>(static_cast<int>((vertices & at_end) && s > 1 - near) -
                                    static_cast<int>((vertices & at_start) && s < near));
}

/// Vertices of both elements of a pair: of the first as bits of Vertex, of the second two bits higher.
inline std::uint8_t vertices_of_pair(const Exposure& bodies, Pair pair) {
    return static_cast<std::uint8_t>(bodies.vertices[pair.a] | bodies.vertices[pair.b] << 2);
}

/// A weight in steps of 2^-20, so that sums of them are the same in any order.
template <int W> SKEIN_INLINE Pack<W> in_steps(Pack<W> weight) {
    constexpr double large = 1.5 * 4294967296.0; // whose last place is such a step
    return (weight + Pack<W>(large)) - Pack<W>(large);
}

} // namespace skein
