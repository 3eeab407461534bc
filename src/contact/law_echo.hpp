// A contact law in the JSON of a scene.
#pragma once

#include "contact/contact_law.hpp"

#include <nlohmann/json.hpp>

namespace skein {

/// An automatic stiffness is a word, and its accepted overlap stands beside it alone.
inline void tidy_law(nlohmann::json& table, const ContactLaw& law) {
    if (law.stiffness_is_automatic()) table["stiffness"] = "auto";
    else table.erase("accepted_overlap");
}

} // namespace skein
