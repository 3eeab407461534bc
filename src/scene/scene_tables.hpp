// The tables of a scene: what they are called, and the keys that a load or a damping has besides its own.
#pragma once

#include "scene/scene_spec.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace skein {

inline constexpr Field include_field{.name = "include",
                                     .unit = "",
                                     .text = "files beside this one whose tables are part of the scene: their lists "
                                             "stand before its own, and where both set a key, the "
                                             "scene's counts"};
inline constexpr Field title_field{
    .name = "title", .unit = "", .text = "what the scene shows, for summaries and pictures"};

/// Keys of a [[load]]: kind, rods, and the load's own. Where a visitor changes the kind, the load starts from its
/// defaults.
void load_fields(FieldVisitor& f, LoadSpec& spec);

/// What formulas of the scene may name.
FormulaScope names_for_formulas(const SceneSpec& scene);

/// Loads of the scene, in its order, whose formulas have been read.
std::vector<Load> loads_with_formulas(const SceneSpec& scene);

/// Keys of a [[damping]].
void damping_fields(FieldVisitor& f, DampingSpec& spec);

/// Keys of a table of one of the lists below.
template <class Spec> void table_fields(FieldVisitor& f, Spec& spec) { spec.fields(f); }
inline void table_fields(FieldVisitor& f, LoadSpec& spec) { load_fields(f, spec); }
inline void table_fields(FieldVisitor& f, DampingSpec& spec) { damping_fields(f, spec); }

/// Such a table, with all defaults.
template <class Spec> Spec defaults_of(const Spec&) { return {}; }
inline LoadSpec defaults_of(const LoadSpec& spec) { return {.load = make_load(spec.load.number())}; }

/// A list that says what is written, not what happens: no part of what identifies a run.
inline constexpr const char* fluid_output_list = "fluid_output";

/// Calls f(name, list) for each [[list]] of a scene besides rods and bodies, in the order of scene files: the one place
/// that names them all.
template <class Scene, class F> void for_each_list(Scene& scene, F&& f) {
    f("table", scene.tables);
    f("load", scene.loads);
    f("damping", scene.damping);
    f("contact_pair", scene.contact_pairs);
    f("wall", scene.walls);
    f("assembly", scene.assemblies);
    f("joint", scene.joints);
    f("obstacle", scene.obstacles);
    f(fluid_output_list, scene.fluid_outputs);
}
/// Whether a scene has a list of tables of this name.
bool is_list(std::string_view name);

/// Where what was said by a word of a key is said now, as the end of a message about that word.
std::optional<std::string> moved_to(std::string_view table, std::string_view key, std::string_view word);

/// Path of the table of a group: "rods.0", "bodies.0"; each kind is counted by itself.
std::string path_of_group(const SceneSpec& scene, std::size_t group);

/// A [[bodies]] with its defaults.
RodSpec default_body();

/// The number that stands for the word "auto", where a key of a table takes it.
std::optional<double> what_auto_means(std::string_view table, std::string_view key);

} // namespace skein
