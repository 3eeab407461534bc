#include "studies/scene_number.hpp"

#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <vector>

namespace skein {

namespace {

using Json = nlohmann::ordered_json;

bool is_count(const std::string& part) {
    return !part.empty() && part.size() < 10 && part.find_first_not_of("0123456789") == std::string::npos;
}

/// The member or item that part of a path means; null where there is none.
const Json* inside(const Json& at, const std::string& part) {
    if (at.is_object()) return at.contains(part) ? &at.at(part) : nullptr;
    if (!at.is_array()) return nullptr;
    if (is_count(part)) {
        const std::size_t number = std::stoul(part);
        return number < at.size() ? &at.at(number) : nullptr;
    }
    for (const Json& item : at)
        for (const char* key : {"name", "kind"})
            if (item.is_object() && item.contains(key) && item.at(key) == part) return &item;
    return nullptr;
}

/// Unit and type of a key as the reference page has them; `kind`: of the table that it is in.
void describe(SceneNumber& number, const std::string& table, const std::string& kind, const std::string& rest) {
    for (const KeyEntry& key : all_keys())
        if (key.path() == table + "." + kind + rest || key.path() == table + rest) {
            number.unit = key.field.unit;
            number.whole = key.type.starts_with("integer");
            return;
        }
}

} // namespace

SceneNumber number_at(const SceneSpec& scene, const std::string& path) {
    const Json root = Json::parse(scene_json(scene, false));
    const Json *at = &root, *above = nullptr;
    std::string table, kind, rest; // of the key without the numbers of tables and components
    std::size_t from = 0;
    while (at && from <= path.size()) {
        const std::size_t dot = std::min(path.find('.', from), path.size());
        const std::string part = path.substr(from, dot - from);
        above = at;
        at = inside(*above, part);
        if (above == &root) table = part;
        else if (above->is_object()) rest += "." + part;
        else if (rest.empty() && at && at->is_object() && at->contains("kind") && at->at("kind").is_string())
            kind = at->at("kind").get<std::string>();
        from = dot + 1;
    }
    SceneNumber number;
    if (at && table == "constants") {
        const Json& constant = at->is_object() ? *at : *above;
        if (constant.contains("unit")) number.unit = constant.at("unit").get<std::string>();
        if (at->is_object() && number.unit.empty() && at->contains("value")) at = &at->at("value");
    } else if (at) {
        describe(number, table, kind, rest);
    }
    if (!at || !at->is_number())
        throw InputError(
            fmt::format("'{}' is no number of {}; a path such as load.0.end.2 names one: a key, the name or "
                        "number of a table, the number of a component, counted from 0",
                        path, scene.file));
    number.value = at->get<double>();
    return number;
}

void refuse_whole(const SceneNumber& number, const std::string& path) {
    if (number.whole)
        throw InputError(fmt::format("'{}' is a whole number, and has no values between: numbers of elements and of "
                                     "copies change what is unknown; skein converge compares numbers of elements",
                                     path));
}

} // namespace skein
