#include "scene/scene_override.hpp"

#include "core/nearest.hpp"
#include "physics/scene_spec.hpp"
#include "scene/scene_keys.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace skein {

namespace {

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::vector<std::string> split(const std::string& path) {
    std::vector<std::string> parts(1);
    for (const char c : path) {
        if (c == '.') parts.emplace_back();
        else parts.back() += c;
    }
    return parts;
}

/// The value in TOML, or, where it is none, as the text it is: rods.cilia.start=pinned.
TomlValue value_of(const std::string& text, const Place& place) {
    TomlValue value{text, place};
    try {
        const TomlValue document = parse_toml("value = " + text, place.text);
        const auto& entries = *document.as<TomlTable>();
        if (entries.size() == 1) value = entries.front().value;
    } catch (const InputError&) { // no TOML, so it stays text
    }
    return value;
}

/// Name of an item of a list of tables: a group's name, a load's or damping's kind.
std::string_view name_of(const TomlValue& item) {
    for (const char* key : {"name", "kind"})
        if (const TomlEntry* entry = item.find(key))
            if (const auto* name = entry->value.as<std::string>()) return *name;
    return "";
}

class Override {
public:
    explicit Override(const std::string& text) : text_(text), place_{source(text)} {}

    void apply(TomlValue& root) const {
        const auto [path, value] = key_value(text_, place_);
        TomlValue* at = &root;
        std::string so_far;
        for (const std::string& part : path) {
            at = &step(*at, part, so_far);
            so_far += (so_far.empty() ? "" : ".") + part;
        }
        if (path.size() == 1 && (at->as<TomlArray>() || at->as<TomlTable>()))
            fail("a path names a key, not a whole table");
        *at = value;
    }

private:
    static std::shared_ptr<const SourceText> source(const std::string& text) {
        return std::make_shared<SourceText>(SourceText{"--set " + text, {}});
    }
    [[noreturn]] void fail(const std::string& message) const { throw InputError(message_at(place_, message)); }

    /// One part of the path further down; tables on the way are made where the scene leaves them out.
    TomlValue& step(TomlValue& at, const std::string& part, const std::string& so_far) const {
        if (auto* list = at.as<TomlArray>()) return item(*list, part, so_far);
        if (TomlEntry* entry = at.find(part)) return entry->value;
        if (so_far.empty() && is_list(part)) fail(fmt::format("the scene has no [[{}]] to change", part));
        auto* table = at.as<TomlTable>();
        if (!table) fail(fmt::format("'{}' is no table: it has no '{}'", so_far, part));
        table->push_back({part, place_, TomlValue{TomlTable{}, place_}});
        return table->back().value;
    }

    TomlValue& item(TomlArray& list, const std::string& part, const std::string& so_far) const {
        std::vector<std::string_view> names;
        for (const TomlValue& one : list) names.push_back(name_of(one));
        return list[number_of_table(so_far, part, names, place_)];
    }

    std::string text_;
    Place place_;
};

} // namespace

KeyValue key_value(const std::string& text, const Place& place) {
    constexpr const char* expected = "expected path=value, e.g. time.duration=10";
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) throw InputError(message_at(place, expected));
    std::vector<std::string> path = split(trimmed(text.substr(0, equals)));
    for (const std::string& part : path)
        if (part.empty())
            throw InputError(message_at(place, fmt::format("a name is missing in the path; {}", expected)));
    return {std::move(path), value_of(trimmed(text.substr(equals + 1)), place)};
}

std::size_t number_of_table(const std::string& list, const std::string& part, std::span<const std::string_view> names,
                            const Place& place) {
    const auto fail = [&](const std::string& message) { throw InputError(message_at(place, message)); };
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error == std::errc{} && end == part.data() + part.size()) {
        if (number >= names.size())
            fail(fmt::format("there is no '{}.{}': '{}' has {}, counted from 0", list, part, list, names.size()));
        return number;
    }
    const auto match = std::find(names.begin(), names.end(), part);
    if (match == names.end())
        fail(fmt::format("there is no '{}.{}'{}", list, part, suggestion(part, names, "there are")));
    if (std::find(match + 1, names.end(), part) != names.end())
        fail(fmt::format("'{}.{}' is not the only one of this name; use its number, counted from 0", list, part));
    return static_cast<std::size_t>(match - names.begin());
}

void apply_override(TomlValue& root, const std::string& override) { Override(override).apply(root); }

} // namespace skein
