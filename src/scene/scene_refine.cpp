#include "scene/scene_refine.hpp"

#include "io/rod_file.hpp"
#include "loads/muscle_torques.hpp"
#include "loads/muscle_wave.hpp"
#include "loads/plane_friction.hpp"
#include "scene/group_names.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "skein/rod/rod_group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

namespace skein {

namespace {

[[noreturn]] void refuse(const std::string& source, const std::string& what) {
    throw InputError(source + (source.empty() ? "" : ": ") + what);
}

/// Of nodes 0 to n from the start, over the length.
std::vector<double> nodes_of(const Shape& shape) {
    std::vector<double> at{0};
    for (long i = 0; i < shape.elements; ++i)
        at.push_back(at.back() + (shape.length_profile.empty() ? 1 : shape.length_profile[static_cast<std::size_t>(i)]));
    for (double& s : at) s /= at.back();
    return at;
}

std::vector<double> middles_of(const Shape& shape) {
    const auto node = nodes_of(shape);
    std::vector<double> at;
    for (std::size_t i = 0; i + 1 < node.size(); ++i) at.push_back(0.5 * (node[i] + node[i + 1]));
    return at;
}

/// Inner vertices; of a ring also where it closes, as the last.
std::vector<double> vertices_of(const Shape& shape) {
    const auto node = nodes_of(shape);
    return {node.begin() + 1, node.end() - (shape.closed ? 0 : 1)};
}

/// Values at `to` of what is linear between values at rising places, of a ring round it; beyond them as in the last piece.
template <class T>
std::vector<T> between(const std::vector<double>& at, const std::vector<T>& value, const std::vector<double>& to, bool ring) {
    const std::size_t n = at.size();
    std::vector<T> out;
    for (const double s : to) {
        std::size_t after = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), s) - at.begin());
        if (n == 1) {
            out.push_back(value[0]);
            continue;
        }
        double from = 0, till = 0;
        std::size_t a = 0, b = 0;
        if (ring && (after == 0 || after == n)) {
            a = n - 1, b = 0;
            from = at[a] - (after == 0 ? 1 : 0), till = at[b] + (after == 0 ? 0 : 1);
        } else {
            after = std::clamp<std::size_t>(after, 1, n - 1);
            a = after - 1, b = after;
            from = at[a], till = at[b];
        }
        const double share = (s - from) / (till - from);
        out.push_back(share == 0 ? value[a] : share == 1 ? value[b] : (1 - share) * value[a] + share * value[b]);
    }
    return out;
}

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
    const auto source = open_rod_file((std::filesystem::path(directory) / rods.placement.file).string(), rods.source);
    if (source->elements() > 0)
        refuse(rods.source, fmt::format("placement.file: '{}' gives the rods of '{}' node by node, so their number of elements "
                                        "cannot be changed; a file of places, with a shape of the scene, can be refined",
                                        rods.placement.file, rods.name));
}

void refine_hold(RodSpec& rods, long was, const Refinement& by) {
    std::vector<long> nodes, elements, held;
    for (const long given : rods.hold.nodes) {
        const long node = by.of(given < 0 ? given + was + 1 : given);
        if (node < 0)
            refuse(rods.source,
                   fmt::format("hold.nodes: node {} of '{}' falls between two nodes of half as many elements", given, rods.name));
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
                refuse(rods.source, fmt::format("hold.elements: elements {} to {} of '{}' are no whole number of elements twice as "
                                                "long",
                                                held[i], held[end - 1], rods.name));
            for (long k = first; k < past; ++k) elements.push_back(k);
        } else if (held[i] == 0) {
            elements.push_back(0);
        } else if (held[i] == was - 1) {
            elements.push_back(-1);
        } else {
            refuse(rods.source, fmt::format("hold.elements: element {} of '{}' is held alone inside the rod, which means something "
                                            "else with other elements; hold two or more side by side, or one at an end",
                                            held[i], rods.name));
        }
        i = end;
    }
    rods.hold.nodes = std::move(nodes);
    rods.hold.elements = std::move(elements);
}

/// The rotary inertia stays that of the elements as given: what lifts the limit of others would make another rod of it. Those near
/// ends, whose neighbours are fewer, follow the others.
void keep_inertia(RodSpec& rods) {
    Material& material = rods.material;
    if (material.rotary_inertia_for_dt == 0) return;
    RodSpec one = rods;
    one.placement = {};
    const std::vector<double> j = RodGroup(one, 0, 0, "").rotary_inertia_scale;
    material.rotary_inertia_for_dt = 0;
    if (j.empty()) return;
    const double middle = j[j.size() / 2];
    for (std::size_t k = 1; k + 1 < j.size(); ++k)
        if (std::abs(j[k] - middle) > 0.02 * middle)
            refuse(rods.source,
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
        refuse(rods.source,
               fmt::format("shape.elements: {} elements of '{}' cannot be halved: give an even number", was.elements, rods.name));
    if (shape.elements < 2) refuse(rods.source, fmt::format("shape.elements: '{}' has too few to be halved", rods.name));
    if (!given.empty()) shape.length_profile = shared_lengths(given, by);
    if (auto& profile = rods.section.profile; !profile.empty()) {
        const double least = 0.5 * *std::min_element(profile.begin(), profile.end());
        profile = between(middles_of(was), profile, middles_of(shape), was.closed);
        for (double& radius : profile) radius = std::max(radius, least); // the last pieces go on as straight lines
    }
    for (auto* curvature : {&shape.rest_curvature_profile, &shape.start_curvature_profile})
        if (!curvature->empty()) *curvature = between(vertices_of(was), *curvature, vertices_of(shape), was.closed);
    refine_hold(rods, was.elements, by);
}

/// Places of what a load gives along the first of the groups that it acts on.
const Shape* shape_of(const SceneSpec& scene, const LoadSpec& load) {
    for (const RodSpec& rods : scene.rods)
        if (!rods.body && names_group(load.rods, rods.name)) return &rods.shape;
    return nullptr;
}

void refine_load(LoadSpec& spec, const Shape& was, const Shape& shape, const Refinement& by) {
    const double share = static_cast<double>(by.over) / static_cast<double>(by.times);
    if (auto* wave = spec.load.get_if<MuscleWave>(); wave && !wave->profile.empty())
        wave->profile = between(vertices_of(was), wave->profile, vertices_of(shape), was.closed);
    if (auto* muscles = spec.load.get_if<MuscleTorques>(); muscles && !muscles->table.empty()) {
        const auto from = nodes_of(was), to = nodes_of(shape); // s_i: where element i ends
        muscles->table = between<double>({from.begin() + 1, from.end()}, muscles->table, {to.begin() + 1, to.end()}, was.closed);
    }
    if (auto* plane = spec.load.get_if<PlaneFriction>()) plane->stiffness *= share, plane->damping *= share;
}

/// Coefficients per node and per element; a body has one of each.
void refine_damping(DampingSpec& spec, const SceneSpec& scene, const Refinement& by) {
    if (spec.damping.kind != DampingKind::physical) return;
    bool bodies = false, rods = false;
    for (const RodSpec& group : scene.rods)
        if (names_group(spec.rods, group.name)) (group.body ? bodies : rods) = true;
    if (bodies && rods)
        refuse(spec.source, "damping.rods: coefficients of a damping of kind \"physical\" are shared among more nodes of rods, but "
                            "not of bodies: give it once for rods and once for bodies");
    if (bodies) return;
    const double share = static_cast<double>(by.over) / static_cast<double>(by.times);
    spec.damping.translational *= share, spec.damping.rotational *= share;
}

} // namespace

SceneSpec refined(const SceneSpec& scene, const Refinement& by) {
    if (!scene.start.from.empty())
        refuse(scene.file, fmt::format("start.from: the state of '{}' has its own elements; a scene that begins with shapes of its "
                                       "own can be refined",
                                       scene.start.from));
    SceneSpec out = scene;
    const std::string directory = std::filesystem::path(scene.file).parent_path().string();
    for (RodSpec& rods : out.rods) {
        if (rods.body) continue;
        refuse_nodes_of_file(rods, directory);
        refine_rods(rods, by);
    }
    for (LoadSpec& load : out.loads)
        if (const Shape* shape = shape_of(out, load)) refine_load(load, *shape_of(scene, load), *shape, by);
    for (DampingSpec& spec : out.damping) refine_damping(spec, scene, by);
    check_scene(out);
    return out;
}

std::vector<std::string> refinement_notes(const SceneSpec& scene) {
    std::vector<std::string> notes;
    for (const RodSpec& rods : scene.rods) {
        if (rods.body) continue;
        if (!rods.section.profile.empty())
            notes.push_back(
                fmt::format("section.profile of '{}' is taken as linear between the middles of its elements", rods.name));
        if (!rods.shape.rest_curvature_profile.empty() || !rods.shape.start_curvature_profile.empty())
            notes.push_back(fmt::format("curvature profiles of '{}' are taken as linear between its vertices", rods.name));
        if (rods.material.rotary_inertia_for_dt > 0)
            notes.push_back(
                fmt::format("rotary_inertia_for_dt of '{}': all runs have the inertia that it gives to the elements of the "
                            "scene",
                            rods.name));
        if (!rods.hold.elements.empty())
            notes.push_back(
                fmt::format("hold.elements of '{}': a stretch that is held keeps its length; one element at an end stays "
                            "one, an error of first order",
                            rods.name));
    }
    for (const LoadSpec& spec : scene.loads) {
        if (spec.load.get_if<PlaneFriction>())
            notes.emplace_back("anisotropic_plane: stiffness and damping per element are shared among more elements");
        if (const auto* wave = spec.load.get_if<MuscleWave>(); wave && !wave->profile.empty())
            notes.emplace_back("muscle_wave: 'profile' is taken as linear between vertices");
        if (const auto* muscles = spec.load.get_if<MuscleTorques>(); muscles && !muscles->table.empty())
            notes.emplace_back("muscle_torques: 'table' is taken as linear between its places");
    }
    for (const DampingSpec& spec : scene.damping) {
        if (spec.damping.kind == DampingKind::physical)
            notes.emplace_back(
                "damping of kind \"physical\": its coefficients, per node and element, are shared among more of them");
        if (is_filter(spec.damping))
            notes.emplace_back("damping of kind \"laplacian\": its rate stays, so that what it takes from long waves counts as an "
                               "error that more elements lessen");
    }
    if (scene.contact || !scene.walls.empty())
        notes.emplace_back("laws of contacts and walls stay as they are, per pair of elements and per node: rods that lie against "
                           "something along their length meet it harder with more elements");
    return notes;
}

} // namespace skein
