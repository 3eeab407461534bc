#include "scene/scene_description.hpp"

#include "core/nearest.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_examples.hpp"
#include "scene/scene_keys.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace skein {

namespace {

using OrderedJson = nlohmann::ordered_json;

bool is_within(const KeyEntry& key, const std::string& path) {
    return path.empty() || key.path() == path || key.table == path || key.table.starts_with(path + ".");
}

OrderedJson json_of_key(const KeyEntry& key) {
    OrderedJson json = {{"path", key.path()},    {"table", key.table},     {"key", key.field.name},
                        {"type", key.type},      {"unit", key.field.unit}, {"required", key.field.required},
                        {"text", key.field.text}};
    if (!key.field.required) json["default"] = key.value == "-" ? OrderedJson() : OrderedJson(key.value);
    if (!key.choices.empty()) json["choices"] = std::vector<std::string_view>(key.choices.begin(), key.choices.end());
    for (const auto& [name, bound] : {std::pair{"above", key.field.above}, std::pair{"at_least", key.field.at_least},
                                      std::pair{"at_most", key.field.at_most}})
        if (std::isfinite(bound)) json[name] = bound;
    return json;
}

} // namespace

std::string description_json(const std::string& path) {
    OrderedJson tables = OrderedJson::array(), keys = OrderedJson::array(), examples = OrderedJson::object();
    std::vector<std::string> named;
    for (const KeyEntry& key : all_keys()) {
        if (!is_within(key, path)) continue;
        keys.push_back(json_of_key(key));
        examples[key.table] = example_of(key.table);
        const std::string table =
            key.table.empty() && key.field.name == "constants" ? "constants" : key.table.substr(0, key.table.find('.'));
        if (table.empty() || std::find(named.begin(), named.end(), table) != named.end()) continue;
        named.push_back(table);
        tables.push_back({{"name", table}, {"heading", table_heading(table)}, {"list", is_list(table)}});
    }
    if (keys.empty()) return {};
    return OrderedJson{{"tables", tables}, {"keys", keys}, {"examples", examples}}.dump(1) + "\n";
}

std::string nearest_key(const std::string& path) {
    std::vector<std::string> known;
    for (const KeyEntry& key : all_keys()) {
        if (known.empty() || known.back() != key.table) known.push_back(key.table);
        known.push_back(key.path());
    }
    const std::vector<std::string_view> names(known.begin(), known.end());
    const std::string_view near = nearest_name(path, names);
    return near.empty() ? "; skein describe lists all" : fmt::format("; did you mean '{}'?", near);
}

} // namespace skein
