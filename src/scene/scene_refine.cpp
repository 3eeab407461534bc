#include "scene/scene_refine.hpp"

#include "io/rod_file.hpp"
#include "rod/shape_places.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_rebuild.hpp"
#include "scene/scene_stages.hpp"
#include "skein/core/error.hpp"
#include "skein/rod/rod_group.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

namespace skein {

namespace {

std::vector<double> shared_lengths(const std::vector<double>& lengths, const Refinement& by) {
    std::vector<double> out;
    const auto step = static_cast<std::size_t>(by.over);
    for (std::size_t i = 0; i < lengths.size(); i += step) {
        double sum = 0;
        for (std::size_t k = i; k < i + step; ++k) sum += lengths[k];
        for (long k = 0; k < by.times; ++k) out.push_back(sum / static_cast<double>(by.times));
    }
    return out;
}

/// Nodes of a file are as many as they are; a row that says no more than where a rod stands goes with any.
void refuse_nodes_of_file(const RodSpec& rods, const std::string& directory) {
    if (rods.placement.kind != PlacementKind::file) return;
    const auto source = open_rod_file(directory, rods);
    if (source->elements() > 0)
        refuse_refinement(
            rods.source,
            fmt::format("placement.file: '{}' gives the rods of '{}' node by node, so their number of elements "
                        "cannot be changed; a file of places, with a shape of the scene, can be refined",
                        rods.placement.file, rods.name));
}

void refine_hold(RodSpec& rods, long was, const Refinement& by) {
    std::vector<long> nodes, elements, held;
    for (const long given : rods.hold.nodes) {
        const long node = by.of(given < 0 ? given + was + 1 : given);
        if (node < 0)
            refuse_refinement(
                rods.source, fmt::format("hold.nodes: node {} of '{}' falls between two nodes of half as many elements",
                                         given, rods.name));
        nodes.push_back(node);
    }
    for (const long given : rods.hold.elements) held.push_back(given < 0 ? given + was : given);
    std::sort(held.begin(), held.end());
    for (std::size_t i = 0; i < held.size();) {
        std::size_t end = i + 1;
        while (end < held.size() && held[end] == held[end - 1] + 1) ++end;
        if (end - i > 1) { // a stretch of the rod
            const long first = by.of(held[i]), past = by.of(held[end - 1] + 1);
            if (first < 0 || past < 0)
                refuse_refinement(
                    rods.source,
                    fmt::format("hold.elements: elements {} to {} of '{}' are no whole number of elements twice as "
                                "long",
                                held[i], held[end - 1], rods.name));
            for (long k = first; k < past; ++k) elements.push_back(k);
        } else if (held[i] == 0) {
            elements.push_back(0);
        } else if (held[i] == was - 1) {
            elements.push_back(-1);
        } else {
            refuse_refinement(
                rods.source,
                fmt::format("hold.elements: element {} of '{}' is held alone inside the rod, which means something "
                            "else with other elements; hold two or more side by side, or one at an end",
                            held[i], rods.name));
        }
        i = end;
    }
    rods.hold.nodes = std::move(nodes);
    rods.hold.elements = std::move(elements);
}

/// The rotary inertia stays that of the elements as given: what lifts the limit of others would make another rod of it.
/// Elements near ends, whose neighbours are fewer, follow the others. What "auto" chooses changes with the elements as
/// their error does.
void keep_inertia(RodSpec& rods) {
    Material& material = rods.material;
    if (material.rotary_inertia_for_dt == 0 || material.chooses_inertia()) return;
    RodSpec one = rods;
    one.placement = {};
    const std::vector<double> j = RodGroup(one, 0, 0, "").rotary_inertia_scale;
    material.rotary_inertia_for_dt = 0;
    if (j.empty()) return;
    const double middle = j[j.size() / 2];
    for (std::size_t k = 1; k + 1 < j.size(); ++k)
        if (std::abs(j[k] - middle) > 0.02 * middle)
            refuse_refinement(
                rods.source,
                fmt::format("material.rotary_inertia_for_dt: it scales the elements of '{}' differently, {:.4g} times "
                            "element {} and {:.4g} times another; give one 'rotary_inertia_scale' for all of them",
                            rods.name, j[k], k, middle));
    material.rotary_inertia_scale = middle;
}

void refine_rods(RodSpec& rods, const Refinement& by) {
    keep_inertia(rods);
    const Shape was = rods.shape;
    Shape& shape = rods.shape;
    const auto& given = was.length_profile;
    shape.elements = by.of(was.elements);
    if (shape.elements < 0)
        refuse_refinement(rods.source,
                          fmt::format("shape.elements: {} elements of '{}' cannot be halved: give an even number",
                                      was.elements, rods.name));
    if (shape.elements < 2)
        refuse_refinement(rods.source, fmt::format("shape.elements: '{}' has too few to be halved", rods.name));
    if (!given.empty()) shape.length_profile = shared_lengths(given, by);
    for (auto* profile : {&rods.section.profile, &rods.section.profile_2}) {
        if (profile->empty()) continue;
        const double least = 0.5 * *std::min_element(profile->begin(), profile->end());
        *profile = between(middles_of(was), *profile, middles_of(shape), was.closed);
        for (double& radius : *profile) radius = std::max(radius, least); // the last pieces go on as straight lines
    }
    for (auto* curvature : {&shape.rest_curvature_profile, &shape.start_curvature_profile})
        if (!curvature->empty()) *curvature = between(vertices_of(was), *curvature, vertices_of(shape), was.closed);
    refine_hold(rods, was.elements, by);
}

using Json = nlohmann::json;

/// Keys that have another value in the second of two scenes with the same tables, each "path=value".
void append_changes(const Json& was, const Json& now, const std::string& path, std::vector<std::string>& changes) {
    const auto has_tables = [](const Json& list) { return list.is_array() && !list.empty() && list[0].is_object(); };
    if (was == now) return;
    if (now.is_object() && was.is_object()) {
        for (const auto& [key, value] : now.items())
            append_changes(was.value(key, Json()), value, path.empty() ? key : path + "." + key, changes);
    } else if (has_tables(now) && has_tables(was)) {
        for (std::size_t i = 0; i < now.size(); ++i)
            append_changes(was[i], now[i], fmt::format("{}.{}", path, i), changes);
    } else {
        changes.push_back(fmt::format("{}={}", path, now.dump()));
    }
}

} // namespace

std::vector<std::string> changes_between(const SceneSpec& was, const SceneSpec& now) {
    std::vector<std::string> changes;
    append_changes(Json::parse(physics_json(was, {}, 1)), Json::parse(physics_json(now, {}, 1)), "", changes);
    return changes;
}

namespace {

SceneSpec with_other_elements(const SceneSpec& scene, const Refinement& by) {
    SceneSpec out = scene;
    const std::string directory = std::filesystem::path(scene.file).parent_path().string();
    for (RodSpec& rods : out.rods) {
        if (rods.body) continue;
        refuse_nodes_of_file(rods, directory);
        refine_rods(rods, by);
    }
    PhysicsTables::refine(out, scene, by);
    return out;
}

/// What stages change by element, node or vertex goes along, and what follows from it in the refined scene.
void refine_stages(const SceneSpec& scene, SceneSpec& out, const Refinement& by) {
    for (std::size_t i = 1; i < scene.stages.size(); ++i) {
        if (scene.stages[i].change.empty()) continue;
        const SceneSpec was = with_changes(scene, i - 1), now = with_changes(scene, i);
        std::vector<std::string> changes;
        try {
            changes = changes_between(with_other_elements(was, by), with_other_elements(now, by));
        } catch (const InputError& error) {
            throw InputError(
                fmt::format("{}: stage '{}': {}", scene.stages[i].source, scene.stages[i].name, error.what()));
        }
        if (changes != changes_between(was, now)) out.stages[i].change = std::move(changes);
    }
}

} // namespace

SceneSpec refined(const SceneSpec& scene, const Refinement& by) {
    if (!scene.start.from.empty())
        refuse_refinement(
            scene.file,
            fmt::format("start.from: the state of '{}' has its own elements; a scene that begins with shapes of its "
                        "own can be refined",
                        scene.start.from));
    SceneSpec out = with_other_elements(scene, by);
    refine_stages(scene, out, by);
    check_scene(out);
    return out;
}

std::vector<std::string> refinement_notes(const SceneSpec& scene) {
    std::vector<std::string> notes;
    for (const RodSpec& rods : scene.rods) {
        if (rods.body) continue;
        if (!rods.section.profile.empty())
            notes.push_back(fmt::format(
                "section.profile of '{}' is taken as linear between the middles of its elements", rods.name));
        if (!rods.shape.rest_curvature_profile.empty() || !rods.shape.start_curvature_profile.empty())
            notes.push_back(
                fmt::format("curvature profiles of '{}' are taken as linear between its vertices", rods.name));
        if (rods.material.rotary_inertia_for_dt > 0)
            notes.push_back(fmt::format(
                "rotary_inertia_for_dt of '{}': all runs have the inertia that it gives to the elements of the "
                "scene",
                rods.name));
        if (rods.material.chooses_inertia())
            notes.push_back(fmt::format("rotary_inertia_for_dt of '{}' is chosen for each number of elements: its "
                                        "effect falls as their error does",
                                        rods.name));
        if (!rods.hold.elements.empty())
            notes.push_back(fmt::format(
                "hold.elements of '{}': a stretch that is held keeps its length; one element at an end stays "
                "one, an error of first order",
                rods.name));
    }
    PhysicsTables::note_refinement(scene, notes);
    return notes;
}

} // namespace skein
