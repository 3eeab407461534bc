// Masses of the nodes and rotary inertia of the elements of a rod. theory.md (4a), (26), end of section 3
#pragma once

#include "rod/sections.hpp"
#include "skein/rod/rod_group.hpp"

#include <vector>

namespace skein {

/// RodGroup::nodal_density of a rod with these sections, kg/m^3.
double nodal_density(const RodSpec& spec, const Sections& sections);

/// Scales of the rotary inertia of each element; empty where all are 1. The elements and cells of `group` must be
/// known, without these scales. Throws InputError where `rotary_inertia_for_dt` cannot be reached.
std::vector<double> rotary_inertia_scales(const RodGroup& group);

/// Multiplies J1 and J2 by j. J3 stays: with it scaled too, piles with friction rise by 2.5 to 2.9 %, with J1 and J2
/// alone by 0.3 %.
void scale_rotary_inertia(ElementConstants& c, double j);

/// Replaces node_mass and node_length [n + 1]: masses and lengths of the elements, divided among their nodes. Node n of
/// a ring has none, as it is node 0.
void divide_among_nodes(const RodSpec& spec, const Sections& sections, const std::vector<ElementConstants>& element,
                        std::vector<double>& node_mass, std::vector<double>& node_length);

} // namespace skein
