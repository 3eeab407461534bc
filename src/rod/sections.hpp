// Cross-sections along a rod, and the stiffness that elements, cells and half cells have from them. theory.md (3),
// (3a), (4a), (4b)
#pragma once

#include "rod/taper.hpp"
#include "skein/rod/rod_group.hpp"

#include <cstddef>
#include <vector>

namespace skein {

/// Rest length of an element and arc length of its middle, both over the length of the rod.
struct ElementShare {
    double length, middle;
};

/// Shares of all elements. Access in rising order costs no memory and no search.
class ElementShares {
public:
    explicit ElementShares(const Shape& shape);
    std::size_t size() const { return to_index(shape_.elements); }
    ElementShare operator[](std::size_t k) const;

private:
    const Shape& shape_;
    double sum_ = 0;
    mutable double before_ = 0; ///< sum of the profile before element `next_`
    mutable std::size_t next_ = 0;
};

/// Radius of element k that holds its section in any direction, m.
double outer_radius(const RodSpec& spec, std::size_t k, const ElementShare& share);

/// Constants of element k; its rotary inertia is not scaled yet.
ElementConstants element_constants(const RodSpec& spec, std::size_t k, const ElementShare& share);

/// Rest curvature of Voronoi cell k, 1/m.
Vec3d rest_curvature_at(const Shape& shape, long k);

/// Sections at elements and nodes. Cells and half cells have the stiffness of the section at their node. Its scale is
/// interpolated between elements, or is that of taper.hpp. A mean of stiffnesses would be wrong, as they go with the
/// fourth power of the scale.
class Sections {
public:
    /// `element`: constants of the elements, which must outlive this object, as `spec` must.
    Sections(const RodSpec& spec, const std::vector<ElementConstants>& element);

    /// True where the section differs from element to element.
    bool vary() const { return vary_; }
    /// Replaces `cells` by the constants of all cells between elements.
    void put_cells(std::vector<VoronoiConstants>& cells) const;
    VoronoiConstants start_wall() const;
    VoronoiConstants end_wall() const;
    /// Share of the mass of element k that its first node has.
    double mass_share_before(std::size_t k) const;

private:
    const SectionScales& second() const { return two_ ? second_ : first_; }
    NodeScales at_node(std::size_t i) const { return {first_.node[i], second().node[i]}; }
    Vec3d stiffness_at_node(std::size_t i) const;
    Vec3d stiffness_at_end(std::size_t k, std::size_t node) const;
    VoronoiConstants cell(std::size_t k) const;

    const RodSpec& spec_;
    const std::vector<ElementConstants>& element_;
    bool two_;             ///< true where the semi-axis along d2 has a profile of its own
    SectionScales first_;  ///< scales along d1; empty where the section is uniform
    SectionScales second_; ///< scales along d2, where `two_`
    bool vary_ = false;
};

} // namespace skein
