// A key of a scene whose value is another one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace skein {

struct KeyChange {
    std::string key;      ///< "rods.0.material.density"
    std::string was, now; ///< values in JSON, or "absent"

    /// Part i of the key between its dots; empty: there are fewer.
    std::string_view part(std::size_t i) const {
        std::string_view rest = key;
        for (; i > 0; --i) {
            const std::size_t dot = rest.find('.');
            if (dot == std::string_view::npos) return {};
            rest.remove_prefix(dot + 1);
        }
        return rest.substr(0, rest.find('.'));
    }
    std::string_view last() const { return std::string_view(key).substr(key.rfind('.') + 1); }
    std::size_t parts() const { return 1 + static_cast<std::size_t>(std::count(key.begin(), key.end(), '.')); }
};

} // namespace skein
