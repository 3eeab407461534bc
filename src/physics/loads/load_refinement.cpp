#include "physics/group_names.hpp"
#include "physics/refinement.hpp"
#include "physics/scene_spec.hpp"

#include <fmt/format.h>

namespace skein {

namespace {

/// Places of what a load gives along the first of the groups that it acts on.
const Shape* shape_of(const SceneSpec& scene, const LoadSpec& load) {
    for (const RodSpec& rods : scene.rods)
        if (!rods.body && names_group(load.rods, rods.name)) return &rods.shape;
    return nullptr;
}

/// Coefficients per node and per element; a body has one of each.
void refine_damping(DampingSpec& spec, const SceneSpec& scene, const Refinement& by) {
    if (spec.damping.kind != DampingKind::physical) return;
    bool bodies = false, rods = false;
    for (const RodSpec& group : scene.rods)
        if (names_group(spec.rods, group.name)) (group.body ? bodies : rods) = true;
    if (bodies && rods)
        refuse_refinement(
            spec.source,
            "damping.rods: coefficients of a damping of kind \"physical\" are shared among more nodes of rods, but "
            "not of bodies: give it once for rods and once for bodies");
    if (bodies) return;
    const double share = static_cast<double>(by.over) / static_cast<double>(by.times);
    spec.damping.translational *= share;
    spec.damping.rotational *= share;
}

} // namespace

void LoadTables::refine(SceneSpec& out, const SceneSpec& scene, const Refinement& by) {
    for (LoadSpec& load : out.loads)
        if (const Shape* shape = shape_of(out, load)) load.load.refine(*shape_of(scene, load), *shape);
    for (DampingSpec& spec : out.damping) refine_damping(spec, scene, by);
}

void LoadTables::note_refinement(const SceneSpec& scene, std::vector<std::string>& notes) {
    for (const LoadSpec& spec : scene.loads) {
        const Shape* shape = shape_of(scene, spec);
        if (!shape) continue;
        Load load = spec.load;
        if (std::string note = load.refine(*shape, *shape); !note.empty())
            notes.push_back(fmt::format("{}: {}", load.kind(), note));
    }
    for (const DampingSpec& spec : scene.damping) {
        if (spec.damping.kind == DampingKind::physical)
            notes.emplace_back(
                "damping of kind \"physical\": its coefficients, per node and element, are shared among more of them");
        if (is_filter(spec.damping))
            notes.emplace_back(
                "damping of kind \"laplacian\": its rate stays, so that what it takes from long waves counts as an "
                "error that more elements lessen");
    }
}

} // namespace skein
