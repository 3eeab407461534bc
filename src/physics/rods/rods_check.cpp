#include "physics/rods/rods_check.hpp"

#include "physics/rods/body_check.hpp"
#include "physics/rods/placement_check.hpp"
#include "physics/table_objections.hpp"
#include "rod/cell_turn.hpp"
#include "rod/end_weights.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include <fmt/format.h>

namespace skein {

namespace {

void rotary_inertia(const RodSpec& rods, Objections& of_group) {
    if (rods.material.rotary_inertia_for_dt != 0)
        TableObjections(of_group, "material")
            .unused({"rotary_inertia_scale"}, "beside 'rotary_inertia_for_dt', which chooses it");
}

void section(const RodSpec& rods, Objections& of_group) {
    TableObjections objections(of_group, "section");
    const Section& s = rods.section;
    if (s.kind == SectionKind::elliptic && s.radius_2 == 0)
        objections.add("", "an elliptic section needs 'radius_2', its semi-axis along d2 [m]");
    if (s.kind == SectionKind::rectangular && s.radius_2 == 0)
        objections.add("", "a rectangular section needs 'radius_2', half of its side along d2 [m]");
    if (s.kind == SectionKind::circular)
        objections.unused({"radius_2"}, "in a circular section; kind = \"elliptic\" has two radii");
    if (!s.shear_factors.empty()) {
        objections.length("shear_factors", s.shear_factors.size(), 2, "one along d1 and one along d2");
        TableObjections(of_group, "material").unused({"shear_factor"}, "beside 'shear_factors' of the section");
    }
    if (!s.bending_stiffness.empty())
        objections.length("bending_stiffness", s.bending_stiffness.size(), 2, "E I1 about d1 and E I2 about d2");
    if (s.kind == SectionKind::circular) objections.unused({"profile_2", "radius_2_formula"}, "in a circular section");
    if (!s.radius_formula.empty()) objections.unused({"profile", "taper"}, "beside 'radius_formula'");
    if (!s.radius_2_formula.empty()) objections.unused({"profile_2"}, "beside 'radius_2_formula'");
    if (!s.profile_2.empty()) {
        if (s.radius_2_formula.empty())
            objections.length("profile_2", s.profile_2.size(), rods.shape.elements, "one for each of the elements");
        objections.unused({"taper"}, "beside radii along d2 of each element's own");
        for (const bool given : {s.torsion_constant > 0, !s.bending_stiffness.empty()})
            if (given)
                objections.add(
                    s.torsion_constant > 0 ? "torsion_constant" : "bending_stiffness",
                    "it goes as the fourth power of one radius along the rod, and this section has two of their own");
    }
    if (s.profile.empty()) return;
    if (s.radius_formula.empty())
        objections.unused({"taper"}, "beside 'profile', which says the radius of every element");
    objections.length("profile", s.profile.size(), rods.shape.elements, "one for each of the elements");
}

/// A cell that is to turn by pi or more never gets there. Rods of a file may be of other lengths: see
/// refuse_large_turns.
void curvatures(const RodSpec& rods, TableObjections& objections) {
    const Shape& s = rods.shape;
    if (rods.placement.kind == PlacementKind::file) return;
    const auto look = [&](const std::string& name, const CellTurn& most, bool listed) {
        if (most.angle < CellTurn::largest) return;
        objections.add(listed ? fmt::format("{}.{}", name, most.cell) : name,
                       fmt::format("'{}' {}; neighbours can be distinguished up to pi: at most {:.4g} 1/m there, or "
                                   "shorter elements",
                                   name, text_of(most), most.curvature(CellTurn::largest)));
    };
    if (!s.rest_curvature_formula.empty()) look("rest_curvature_formula", rest_turn(s), false);
    else if (!s.rest_curvature_profile.empty()) look("rest_curvature_profile", rest_turn(s), true);
    else look("rest_curvature", rest_turn(s), false);
    if (!s.start_curvature_profile.empty()) look("start_curvature_profile", start_turn(s), true);
    else look("start_curvature", start_turn(s), false);
}

void shape(const RodSpec& rods, Objections& of_group) {
    TableObjections objections(of_group, "shape");
    const Shape& s = rods.shape;
    if (s.closed && s.elements < 3) objections.add("elements", "a ring needs at least 3 elements");
    if (s.closed && (rods.start != EndKind::free || rods.end != EndKind::free))
        objections.add("closed", "a ring has no ends: 'start' and 'end' must be free");
    const auto clamped = [](EndKind end) { return end == EndKind::clamped || end == EndKind::clamped_frozen; };
    const bool both = rods.start != EndKind::free && rods.end != EndKind::free;
    if (!zero(s.angular_velocity) && (both || clamped(rods.start) || clamped(rods.end)))
        objections.add("angular_velocity",
                       "'angular_velocity' turns a rod as a whole, which must be free or pinned at one end "
                       "only; 'element_spin' turns elements in their places");
    if (s.rest_strain.z <= -1)
        objections.add("rest_strain", fmt::format("'rest_strain' of {} along d3 leaves no length: it must be above -1",
                                                  s.rest_strain.z));
    if (!s.length_profile.empty())
        objections.length("length_profile", s.length_profile.size(), s.elements, "one for each of the elements");
    if (!s.start_curvature_profile.empty()) {
        objections.unused({"start_curvature"}, "beside 'start_curvature_profile'");
        objections.length("start_curvature_profile", s.start_curvature_profile.size(),
                          s.closed ? s.elements : s.elements - 1,
                          s.closed ? "one for each vertex of the ring" : "one for each inner vertex (elements - 1)");
    }
    curvatures(rods, objections);
    if (s.end_weights == EndWeights::gregory && !takes_end_weights(rods))
        objections.add("end_weights",
                       "'end_weights' = \"gregory\" has no use here: it is for open rods, straight at rest and "
                       "uniform, of 6 equal "
                       "elements or more, of a law with an energy and with no end that is clamped_frozen");
    if (s.rest_curvature_profile.empty() || !s.rest_curvature_formula.empty()) return;
    objections.unused({"rest_curvature"}, "beside 'rest_curvature_profile'");
    objections.length("rest_curvature_profile", s.rest_curvature_profile.size(), s.closed ? s.elements : s.elements - 1,
                      s.closed ? "one for each vertex of the ring" : "one for each inner vertex (elements - 1)");
}

void sliding(EndKind end, const std::string& free, const EndMotion& m, std::string_view name, Objections& of_group) {
    if (free.empty()) return;
    const std::string key = std::string(name) + "_free", motion = std::string(name) + "_motion";
    if (end == EndKind::free) {
        of_group.add(key,
                     fmt::format("'{}' has no use for an end that is free: hold it (\"pinned\" or \"clamped\")", key));
        return;
    }
    std::string once = free;
    std::sort(once.begin(), once.end());
    if (free.find_first_not_of("xyz") != std::string::npos ||
        std::adjacent_find(once.begin(), once.end()) != once.end()) {
        of_group.add(key,
                     fmt::format("'{}' is \"{}\"; it names lab axes, each once, such as \"z\" or \"xy\"", key, free));
        return;
    }
    if (end == EndKind::pinned && free.size() == 3)
        of_group.add(key, "a pinned end that slides in all directions is a free one: say so");
    const Vec3d axes = lab_directions(free);
    const auto along_free = [&](const Vec3d& u) { return !zero(scale(axes, u)); };
    const auto conflict = [&](const char* table) {
        of_group.add(motion + "." + table,
                     fmt::format("'{}' moves the end along {}, where '{}' leaves it free", table, free, key));
    };
    if (std::any_of(m.translation.begin(), m.translation.end(), along_free)) conflict("translation");
    if (along_free(m.amplitude)) conflict("amplitude");
}

void motion(const EndMotion& m, EndKind end, TableObjections objections) {
    if (!m.moves() && !m.turns()) {
        objections.unused({"times", "amplitude", "rotation_amplitude", "period", "phase", "smooth"},
                          "in a motion that neither moves nor turns its end");
        return;
    }
    if (end == EndKind::free) objections.add("", "a free end cannot be moved: hold it (\"pinned\" or \"clamped\")");
    if (end == EndKind::pinned && m.turns())
        objections.add("", "a pinned end turns freely: to prescribe its rotation it must be clamped");
    if (std::adjacent_find(m.times.begin(), m.times.end(), std::greater_equal<>()) != m.times.end())
        objections.add("times", "'times' must rise from entry to entry");
    if (!m.translation.empty())
        objections.length("translation", m.translation.size(), static_cast<long>(m.times.size()),
                          "one for each of 'times'");
    if (!m.rotation.empty())
        objections.length("rotation", m.rotation.size(), static_cast<long>(m.times.size()), "one for each of 'times'");
}

void hold(const RodSpec& rods, Objections& of_group) {
    TableObjections objections(of_group, "hold");
    const auto within = [&](const std::vector<long>& numbers, const char* key, long count) {
        for (const long i : numbers)
            if (i >= count || i < -count) {
                objections.add(key,
                               fmt::format("'{}' names {}, but there are {}: give 0 to {}, or -1 to {} from the end",
                                           key, i, count, count - 1, -count));
                return;
            }
    };
    within(rods.hold.nodes, "nodes", rods.shape.closed ? rods.shape.elements : rods.shape.elements + 1);
    within(rods.hold.elements, "elements", rods.shape.elements);
    for (const auto& [key, letters] :
         {std::pair{"directions", &rods.hold.directions}, std::pair{"axes", &rods.hold.axes}})
        if (letters->empty() || letters->find_first_not_of("xyz") != std::string::npos)
            objections.add(key,
                           fmt::format("'{}' is \"{}\"; it names lab axes, such as \"x\" or \"xy\"", key, *letters));
    if (rods.hold.nodes.empty()) objections.unused({"directions"}, "without 'nodes'");
    if (rods.hold.elements.empty()) objections.unused({"axes"}, "without 'elements'");
}

void magnetisation(const RodSpec& rods, Objections& of_group) {
    TableObjections objections(of_group, "magnetisation");
    const Magnetisation& m = rods.magnetisation;
    const std::string where = fmt::format("for a magnetisation of pattern \"{}\"", nth(magnetisation_names, m.pattern));
    if (m.pattern == MagnetisationPattern::none) {
        objections.unused({"strength", "direction", "wavelength_x", "wavelength_y", "phase"}, where);
        return;
    }
    if (m.strength == 0) objections.add("", fmt::format("'strength' [A/m] is needed {}", where));
    if (m.pattern == MagnetisationPattern::uniform) {
        objections.unused({"wavelength_x", "wavelength_y", "phase"}, where);
        if (zero(m.direction)) objections.add("direction", "'direction' has no direction");
        return;
    }
    objections.unused({"direction"}, where);
    if (m.wavelength_x == 0) objections.add("", fmt::format("'wavelength_x' [m], not 0, is needed {}", where));
    if (m.pattern == MagnetisationPattern::wave_x) objections.unused({"wavelength_y"}, where);
    else if (m.wavelength_y == 0) objections.add("", fmt::format("'wavelength_y' [m], not 0, is needed {}", where));
}

} // namespace

void check_rods(const RodSpec& rods, Objections& objections) {
    if (rods.body) return check_body(rods, objections);
    rotary_inertia(rods, objections);
    section(rods, objections);
    shape(rods, objections);
    check_placement(rods, objections);
    magnetisation(rods, objections);
    motion(rods.start_motion, rods.start, {objections, "start_motion"});
    motion(rods.end_motion, rods.end, {objections, "end_motion"});
    sliding(rods.start, rods.start_free, rods.start_motion, "start", objections);
    sliding(rods.end, rods.end_free, rods.end_motion, "end", objections);
    hold(rods, objections);
}

} // namespace skein
