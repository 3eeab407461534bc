// The tables of a scene: what they are called, and the keys that a load or a damping has besides its own.
#pragma once

#include "scene/scene_spec.hpp"

#include <array>
#include <string_view>

namespace skein {

inline constexpr Field title_field{.name = "title", .unit = "", .text = "what the scene shows, for summaries and pictures"};

/// Names of the loads, in the order of the variant `Load`.
inline constexpr auto load_kinds = []<class... L>(std::type_identity<std::variant<L...>>) {
    return std::array<std::string_view, sizeof...(L)>{L::kind...};
}(std::type_identity<Load>{});

/// The load of kind load_kinds[kind], with its defaults.
Load make_load(int kind);

/// Keys of a [[load]]: kind, rods, and the load's own. Where a visitor changes the kind, the load starts from its defaults.
void load_fields(FieldVisitor& f, LoadSpec& spec);

/// Keys of a [[damping]].
void damping_fields(FieldVisitor& f, DampingSpec& spec);

} // namespace skein
