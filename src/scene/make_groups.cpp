#include "scene/make_groups.hpp"

#include "io/rod_file.hpp"
#include "physics/assemblies.hpp"
#include "physics/rods/rotary_inertia.hpp"
#include "placement/packing.hpp"
#include "rod/formulas_along.hpp"
#include "scene/memory_check.hpp"
#include "scene/scene_stages.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace skein {

namespace {

/// Formulas along rods are those of each rod's own length, and so is rotary inertia that is chosen.
void use_formulas(RodGroup& group, const SceneSpec& scene, const FormulaScope& names) {
    const RodSpec& spec = group.spec();
    const Section& section = spec.section;
    const bool radii = !section.radius_formula.empty() || !section.radius_2_formula.empty();
    if (spec.shape.rest_curvature_formula.empty() && !radii && !spec.material.inertia_chosen) return;
    if (const RodColumns& has = group.places().columns(); radii && (has.radius || has.radii))
        throw InputError(fmt::format("{}: file '{}' has radii, and 'radius_formula' of '{}' too: leave one of them out",
                                     spec.source, spec.placement.file, spec.name));
    if (group.places().columns().nodes && spec.placement.trace == Trace::rest &&
        !spec.shape.rest_curvature_formula.empty())
        throw InputError(fmt::format("{}: the nodes of file '{}' are the shape at rest of '{}', and "
                                     "'rest_curvature_formula' too: leave it out, or give placement.trace = \"start\"",
                                     spec.source, spec.placement.file, spec.name));
    group.use_formulas([names, scene](RodSpec& own) {
        const auto refuse = [&](const std::string& key, const FormulaFault& fault) {
            throw InputError(fmt::format("{}: '{}' along a rod of '{}' that is {:g} m long: {}", own.source, key,
                                         own.name, own.shape.length, fault.message));
        };
        for (const FormulaFault& fault : read_rest_curvature(own.shape, names)) refuse("rest_curvature_formula", fault);
        for (const SectionFault& fault : read_section(own, names)) refuse(fault.key, fault.fault);
        if (own.material.inertia_chosen) own.material.rotary_inertia_for_dt = automatic_inertia(scene, own).dt;
    });
}

} // namespace

std::vector<RodGroup> make_groups(const SceneSpec& scene) { return make_groups(scene, std::vector<double>{0.0}); }

std::vector<RodGroup> make_groups(const SceneSpec& as_written, std::span<const double> begins) {
    refuse_beyond_memory(as_written);
    const SceneSpec scene = stage_scene(as_written, begins);
    const std::vector<int> assembly_of_group = assembly_of_groups(scene);
    std::map<int, std::shared_ptr<const AssemblyCopies>> copies; // by assembly
    std::vector<RodGroup> groups;
    std::int64_t first = 0;
    const std::string directory = std::filesystem::path(scene.file).parent_path().string();
    std::vector<Capsule> occupied;
    const FormulaScope names = names_for_formulas(scene);
    const bool needs_all = PhysicsTables::needs_all_rods(scene);
    for (std::size_t g = 0; g < scene.rods.size(); ++g) {
        const auto packed = [](const RodSpec& spec) { return spec.placement.kind == PlacementKind::packing; };
        RodSpec spec = scene.rods[g];
        spec.start_motion.use(names);
        spec.end_motion.use(names);
        read_rest_curvature(spec.shape, names);
        read_section(spec, names);
        if (spec.material.rotary_inertia_for_dt == Material::automatic_inertia) {
            spec.material.rotary_inertia_for_dt = automatic_inertia(scene, spec).dt;
            spec.material.inertia_chosen = true;
        }
        const bool in_file = spec.placement.kind == PlacementKind::file;
        auto source = in_file ? open_rod_file(directory, spec) : nullptr;
        if (source && source->elements() > 0 && source->elements() != spec.shape.elements)
            throw InputError(fmt::format("{}: file '{}' is of rods of {} elements, but shape.elements of '{}' is {}",
                                         spec.source, spec.placement.file, source->elements(), spec.name,
                                         spec.shape.elements));
        groups.emplace_back(spec, static_cast<int>(g), first, directory, &occupied, std::move(source));
        if (groups.back().heterogeneous()) use_formulas(groups.back(), scene, names);
        if (const int assembly = assembly_of_group[g]; assembly >= 0) {
            auto& of_assembly = copies[assembly];
            const bool named = assembly < static_cast<int>(scene.assemblies.size());
            if (!of_assembly) {
                AssemblyCopies all = named ? copies_of(nth(scene.assemblies, assembly), assembly, directory)
                                           : AssemblyCopies{.number = assembly};
                all.lane_each = is_implicit(scene.time.integrator);
                of_assembly = std::make_shared<AssemblyCopies>(std::move(all));
            }
            groups.back().read_all(); // which rods are connected follows from the places of all
            groups.back().join(of_assembly);
        }
        first += groups.back().count();
        if (needs_all || (groups.back().heterogeneous() && PhysicsTables::look_at_whole_rods(scene, spec)))
            groups.back().read_all();
        if (packed(scene.rods[g]) || std::none_of(scene.rods.begin() + static_cast<long>(g), scene.rods.end(), packed))
            continue;
        groups.back().read_all(); // what is packed keeps clear of all of them
        for (std::int64_t i = 0; i < groups.back().count(); ++i) groups.back().append_capsules(i, occupied);
    }
    return groups;
}

std::vector<RodGroup> make_whole_groups(const SceneSpec& scene) {
    std::vector<RodGroup> groups = make_groups(scene);
    for (RodGroup& group : groups) group.read_all();
    return groups;
}

} // namespace skein
