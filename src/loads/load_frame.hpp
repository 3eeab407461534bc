// Axes of a load's couple: fixed in the lab, or in the material, turning with it.
#pragma once

#include <string_view>

namespace skein {

enum class LoadFrame { lab, body };
inline constexpr std::string_view load_frame_names[] = {"lab", "body"};

} // namespace skein
