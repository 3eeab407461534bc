// The tables of a scene: what they are called, and the keys that a load or a damping has besides its own.
#pragma once

#include "scene/scene_spec.hpp"

#include <string_view>

namespace skein {

inline constexpr Field title_field{.name = "title", .unit = "", .text = "what the scene shows, for summaries and pictures"};

/// Keys of a [[load]]: kind, rods, and the load's own. Where a visitor changes the kind, the load starts from its defaults.
void load_fields(FieldVisitor& f, LoadSpec& spec);

/// Keys of a [[damping]].
void damping_fields(FieldVisitor& f, DampingSpec& spec);

} // namespace skein
