// A scene as plain data: the content of a TOML file or of a C++ author's program, before any decision about how to run
// it.
#pragma once

#include "physics/tables.hpp"
#include "plan/core_tables.hpp"

#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace skein {

struct SceneSpec : CoreTables, PhysicsTables {};

/// Path of the table of a group: "rods.0", "bodies.0"; each kind is counted by itself.
std::string path_of_group(const CoreTables& scene, std::size_t group);
/// A [[bodies]] with its defaults.
RodSpec default_body();

/// A member that holds a [[list]] of tables, or a [table] that may be absent.
template <class> inline constexpr bool is_list_of_tables = false;
template <class Spec> inline constexpr bool is_list_of_tables<std::vector<Spec>> = true;
template <class> inline constexpr bool is_optional_table = false;
template <class Spec> inline constexpr bool is_optional_table<std::optional<Spec>> = true;

/// Tables that come in kinds, each with its own keys: `kind` names one of Spec::kinds().
template <class Spec>
concept HasKinds = requires(const Spec& spec, int kind) {
    Spec::kinds();
    { Spec::of_kind(kind) } -> std::same_as<Spec>;
    { spec.kind_number() } -> std::same_as<int>;
};
/// A table with all defaults, of the same kind.
template <class Spec> Spec defaults_of(const Spec& spec) {
    if constexpr (HasKinds<Spec>) return Spec::of_kind(spec.kind_number());
    else return {};
}

/// False of tables that say what is written, not what happens: they do not identify a run.
template <class Spec> inline constexpr bool decides_state = !requires { Spec::output_only; };

/// Calls f(name, member, stands) for each [table] of the physics, in the order of scene files. `stands`: files write
/// it.
template <class Scene, class F> void for_each_table(Scene&& scene, F&& f) {
    PhysicsTables::visit_tables(scene, [&](const char* name, auto& member, bool stands = true) {
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (!is_list_of_tables<Member>) f(name, member, stands);
    });
}

/// Calls f(name, spec) for each [table] of the physics that stands in a scene.
template <class Scene, class F> void for_each_spec(Scene&& scene, F&& f) {
    for_each_table(scene, [&](const char* name, auto& member, bool stands) {
        if constexpr (is_optional_table<std::remove_cvref_t<decltype(member)>>) {
            if (member) f(name, *member);
        } else if (stands) {
            f(name, member);
        }
    });
}

/// Calls f(name, list) for each [[list]] besides rods and bodies, in the order of scene files.
template <class Scene, class F> void for_each_list(Scene&& scene, F&& f) {
    f("table", scene.tables);
    f("stage", scene.stages);
    PhysicsTables::visit_tables(scene, [&](const char* name, auto& member, bool = true) {
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (is_list_of_tables<Member>) f(name, member);
    });
}

} // namespace skein
