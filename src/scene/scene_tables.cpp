#include "scene/scene_tables.hpp"

#include "loads/plane_friction.hpp"

#include <fmt/format.h>

namespace skein {

void load_fields(FieldVisitor& f, LoadSpec& spec) {
    int kind = spec.load.number();
    f.visit_choice({.name = "kind", .unit = "", .text = "which load", .required = true}, kind, load_kinds());
    if (kind != spec.load.number()) spec.load = make_load(kind);
    f.visit({.name = "rods", .unit = "", .text = "groups it acts on; all where absent"}, spec.rods);
    spec.load.fields(f);
}

FormulaScope names_for_formulas(const SceneSpec& scene) { return {scene.constants, scene.tables, scene.time.duration}; }

std::vector<Load> loads_with_formulas(const SceneSpec& scene) {
    const FormulaScope names = names_for_formulas(scene);
    std::vector<Load> loads;
    for (const LoadSpec& spec : scene.loads) loads.emplace_back(spec.load).use(names);
    return loads;
}

void damping_fields(FieldVisitor& f, DampingSpec& spec) {
    spec.damping.fields(f);
    f.visit({.name = "rods", .unit = "", .text = "groups it acts on; all where absent"}, spec.rods);
}

bool is_list(std::string_view name) {
    bool found = name == "rods" || name == "bodies";
    const SceneSpec scene;
    for_each_list(scene, [&](std::string_view list, const auto&) { found |= name == list; });
    return found;
}

std::optional<std::string> moved_to(std::string_view table, std::string_view key, std::string_view word) {
    if (table == "rods.material" && key == "law" && word == "rigid")
        return "; rigid bodies have tables of their own, [[bodies]]";
    return std::nullopt;
}

std::string path_of_group(const SceneSpec& scene, std::size_t group) {
    const bool body = scene.rods[group].body.has_value();
    std::size_t number = 0;
    for (std::size_t i = 0; i < group; ++i) number += scene.rods[i].body.has_value() == body;
    return (body ? "bodies." : "rods.") + std::to_string(number);
}

RodSpec default_body() {
    RodSpec spec;
    spec.body.emplace();
    return spec;
}

std::optional<double> what_auto_means(std::string_view table, std::string_view key) {
    if (table == "time" && key == "dt") return 0;
    const bool has_law = table == "contact" || table == "contact_pair" || table == "wall";
    if (has_law && key == "stiffness") return ContactLaw::automatic;
    if (table == "joint" && key == "stiffness") return 0;
    const bool of_plane = key == "tolerance" || key == "slip_speed";
    if (of_plane && (table == "load" || table == fmt::format("load.{}", PlaneFriction::kind)))
        return PlaneFriction::automatic;
    return std::nullopt;
}

} // namespace skein
