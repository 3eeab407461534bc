#include "studies/observable_slopes.hpp"

#include "core/rotation.hpp"
#include "diagnostics/probes.hpp"
#include "kernels/kernels.hpp"
#include "mechanics/rod_copies.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace skein {

namespace {

/// Slopes of a quantity by displacements of nodes and turns of elements.
StaticLoads no_slopes(const StaticState& state) {
    StaticLoads none;
    none.force.assign(state.slot.size(), Vec3d{0, 0, 0});
    none.couple.assign(state.slot.size(), Vec3d{0, 0, 0});
    return none;
}

enum class Energy { stretch, shear, bend, twist };
constexpr std::array<std::pair<std::string_view, Energy>, 4> energies = {{{"elastic_stretch[J]", Energy::stretch},
                                                                          {"elastic_shear[J]", Energy::shear},
                                                                          {"elastic_bend[J]", Energy::bend},
                                                                          {"elastic_twist[J]", Energy::twist}}};

/// Leaves rods the stiffness of this energy alone.
void keep_stiffness(RodGroup& group, Energy energy) {
    const auto cell = [&](VoronoiConstants& v) {
        if (energy != Energy::bend) v.stiffness.x = v.stiffness.y = 0;
        if (energy != Energy::twist) v.stiffness.z = 0;
    };
    for (VoronoiConstants& v : group.voronoi) cell(v);
    cell(group.start_wall);
    cell(group.end_wall);
    for (ElementConstants& e : group.element) {
        if (energy != Energy::shear) e.stiffness.x = e.stiffness.y = 0;
        if (energy != Energy::stretch) e.stiffness.z = 0;
    }
}

/// An energy falls along the loads of rods that have no other, and on which nothing else acts.
std::optional<Unknown> slope_of_energy(const StaticCase& one, const StaticState& state, Energy energy, double time) {
    for (const RodGroup& group : one.groups)
        if (group.strained() && (group.law() == Law::elastica || group.heterogeneous())) return {};
    std::vector<RodGroup> groups = one.groups;
    for (RodGroup& group : groups)
        if (group.strained()) keep_stiffness(group, energy);
    Plan plan = one.plan;
    plan.physics.clear();
    for (GroupPlan& group : plan.groups) group.program = {};
    const std::unique_ptr<StaticRods> rods = make_static_rods(plan, groups, one.rods, nullptr);
    rods->set_time(time);
    StaticLoads loads;
    rods->evaluate(state.slot, rods->strains(state.slot), false, loads);
    return Unknown(-one.system->gathered(loads, state));
}

std::optional<Unknown> slope_of_centre(const StaticCase& one, const StaticState& state, const Vec3d& axis) {
    StaticLoads slopes = no_slopes(state);
    double mass = 0;
    for (std::size_t i = 0; i < one.rods.size(); ++i)
        with_rod(nth(one.groups, one.rods[i].group), one.rods[i].index, [&](const RodGroup& own) {
            for (std::size_t k = 0; k < own.node_mass.size(); ++k) {
                slopes.force[one.system->first_slot(i) + k] = own.node_mass[k] * axis;
                mass += own.node_mass[k];
            }
        });
    return Unknown(one.system->gathered(slopes, state) / mass);
}

std::optional<Unknown> slope_of_probe(const StaticCase& one, const StaticState& state, const ProbeSpec& probe,
                                      const Vec3d& axis) {
    const auto group = std::find_if(one.groups.begin(), one.groups.end(),
                                    [&](const RodGroup& other) { return other.name() == probe.of; });
    const auto rod = static_cast<std::size_t>(group->first_gid() + probe.number);
    const std::size_t first = one.system->first_slot(rod);
    StaticLoads slopes = no_slopes(state);
    if (!group->strained()) {
        if (probe.quantity != ProbeQuantity::position) return {};
        slopes.force[first] = axis;
        return one.system->gathered(slopes, state);
    }
    ProbePlace place{};
    with_rod(*group, probe.number, [&](const RodGroup& own) { place = probe_place(own, probe.at); });
    const std::size_t slot = first + place.element;
    if (probe.quantity == ProbeQuantity::position) {
        slopes.force[slot] = (1 - place.share) * axis;
        slopes.force[slot + 1] = place.share * axis;
    } else if (probe.quantity == ProbeQuantity::direction) { // d3 moves by Q^T (t x e3)
        slopes.couple[slot] = cross(Vec3d{0, 0, 1}, lane(state.slot[slot].director, 0) * axis);
    } else {
        return {};
    }
    return one.system->gathered(slopes, state);
}

} // namespace

bool is_count(std::string_view name) {
    constexpr std::array<std::string_view, 4> counts = {"contacts[-]", "touching_pairs[-]", "coordination[-]",
                                                        "wall_contacts[-]"};
    return std::find(counts.begin(), counts.end(), name) != counts.end();
}

std::optional<Unknown> slope_by_unknowns(const StaticCase& one, const StaticState& state, const std::string& name,
                                         double time) {
    const std::array<std::pair<std::string_view, Vec3d>, 3> axes = {
        {{"_x[", {1, 0, 0}}, {"_y[", {0, 1, 0}}, {"_z[", {0, 0, 1}}}};
    for (const auto& [energy_name, energy] : energies)
        if (name == energy_name) return slope_of_energy(one, state, energy, time);
    for (const auto& [ending, axis] : axes) {
        if (name.starts_with("centre" + std::string(ending))) return slope_of_centre(one, state, axis);
        for (const ProbeSpec& probe : one.scene.probes)
            if (!probe.strained() && name.starts_with(probe.name + std::string(ending)))
                return slope_of_probe(one, state, probe, axis);
    }
    return {};
}

} // namespace skein
