#include "scene/scene_file.hpp"

#include "io/csv_table.hpp"
#include "physics/scene_spec.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_override.hpp"
#include "scene/scene_reader.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>

#include <fmt/format.h>

namespace skein {

namespace {

/// The place of a path, or of the innermost table around it that the scene has.
Place nearest_place(const TomlValue& root, std::string_view path) {
    const TomlValue* at = &root;
    Place nearest{root.place.text, 1, 1, 1};
    while (at && !path.empty()) {
        const std::string_view name = path.substr(0, path.find('.'));
        path.remove_prefix(std::min(path.size(), name.size() + 1));
        if (const auto* list = at->as<TomlArray>()) {
            std::size_t i = list->size();
            std::from_chars(name.data(), name.data() + name.size(), i);
            at = i < list->size() ? &(*list)[i] : nullptr;
            if (at) nearest = at->place;
        } else {
            const TomlEntry* entry = at->find(name);
            at = entry ? &entry->value : nullptr;
            if (entry) nearest = entry->place;
        }
    }
    return nearest;
}

/// The part of a text that a contradiction names, where the text stands on one line as it is.
Place part_of(Place place, const Contradiction& c) {
    const auto line = static_cast<std::size_t>(place.line), column = static_cast<std::size_t>(place.column);
    if (c.length == 0 || line < 1 || line > place.text->lines.size()) return place;
    const std::string& text = place.text->lines[line - 1];
    if (column < 1 || column + c.begin >= text.size()) return place;
    const char quote = text[column - 1];
    const std::string_view before = std::string_view(text).substr(column, c.begin);
    const bool plain = (quote == '"' || quote == '\'') && !before.starts_with(std::string(2, quote)) &&
                       before.find('\\') == std::string::npos;
    if (!plain) return place;
    place.column += 1 + static_cast<int>(c.begin);
    place.length = static_cast<int>(std::min(c.length, text.size() - column - c.begin));
    return place;
}

void add_contradictions(const SceneSpec& scene, const TomlValue& root, Problems& problems) {
    for (const Contradiction& c : contradictions(scene, given_keys(root)))
        problems.add(part_of(nearest_place(root, c.path), c), c.message);
}

bool lists_tables(const TomlValue& value) {
    const auto* list = value.as<TomlArray>();
    return list && (list->empty() || list->front().as<TomlTable>());
}

/// Tables of another file become part of this one: lists of tables stand before its own, and where both set a key, its
/// own counts.
void merge(TomlValue& own, TomlValue&& other) {
    for (TomlEntry& entry : *other.as<TomlTable>()) {
        TomlEntry* const same = own.find(entry.key);
        if (!same) {
            own.as<TomlTable>()->push_back(std::move(entry));
        } else if (lists_tables(same->value) && lists_tables(entry.value)) {
            auto &mine = *same->value.as<TomlArray>(), &theirs = *entry.value.as<TomlArray>();
            mine.insert(mine.begin(), std::make_move_iterator(theirs.begin()), std::make_move_iterator(theirs.end()));
        } else if (same->value.as<TomlTable>() && entry.value.as<TomlTable>()) {
            merge(same->value, std::move(entry.value));
        }
    }
}

/// The files that a scene includes, last first, so that a later one counts before an earlier one.
void include_files(TomlValue& root, const std::string& file) {
    const TomlEntry* entry = root.find(include_field.name);
    const auto* names = entry ? entry->value.as<TomlArray>() : nullptr;
    if (!names) return; // none, or something that the reader will refuse
    const std::vector<TomlValue> listed(*names);
    for (auto name = listed.rbegin(); name != listed.rend(); ++name) {
        const auto* text = name->as<std::string>();
        if (!text) return;
        const std::string path = (std::filesystem::path(file).parent_path() / *text).string();
        try {
            const std::string included = read_scene_text(path);
            TomlValue other = parse_toml(included, source_text(path, included));
            if (other.find(include_field.name))
                throw InputError(fmt::format("{} includes other files, and is included here", path));
            merge(root, std::move(other));
        } catch (const InputError& error) {
            throw InputError(message_at(name->place, fmt::format("'include': {}", error.what())));
        }
    }
}

/// Throws IoError naming the file and what is wrong with it.
void read_table_file(const std::string& path, FormulaTable& table) {
    CsvTable file = read_csv(path);
    if (file.names.size() != 2)
        throw IoError(fmt::format("{}: has {} columns; a table has two, points and values", path, file.names.size()));
    for (const auto& column : file.columns)
        for (const double number : column)
            if (!std::isfinite(number)) throw IoError(fmt::format("{}: {} is out of range", path, number));
    table.at = std::move(file.columns[0]);
    table.value = std::move(file.columns[1]);
    for (std::size_t k = 1; k < table.at.size(); ++k)
        if (!(table.at[k] > table.at[k - 1]))
            throw IoError(
                fmt::format("{}: points must rise, but {:g} follows {:g}", path, table.at[k], table.at[k - 1]));
    table.file.clear();
}

/// Tables of the scene have their numbers from then on, wherever they stood.
void read_tables_of_files(SceneSpec& scene, const TomlValue& root, Problems& problems) {
    const std::filesystem::path directory = std::filesystem::path(scene.file).parent_path();
    for (std::size_t i = 0; i < scene.tables.size(); ++i) {
        FormulaTable& table = scene.tables[i];
        if (table.file.empty()) continue;
        const auto refuse = [&](const std::string& message) {
            problems.add(nearest_place(root, fmt::format("table.{}.file", i)), message);
        };
        if (!table.at.empty() || !table.value.empty()) {
            refuse("'file' gives the points and their values: leave out 'at' and 'value', or 'file'");
            continue;
        }
        try {
            read_table_file((directory / table.file).string(), table);
        } catch (const IoError& error) {
            refuse(fmt::format("'file': {}", error.what()));
        }
    }
}

} // namespace

std::string read_scene_text(const std::string& file) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status) && (!error || error == std::errc::no_such_file_or_directory))
        throw InputError(fmt::format("{}: there is no such file", file));
    if (error) throw InputError(fmt::format("{}: {}", file, error.message()));
    if (!std::filesystem::is_regular_file(status)) throw InputError(fmt::format("{}: not a file", file));
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(fmt::format("{}: cannot be opened for reading", file));
    return {std::istreambuf_iterator<char>(in), {}};
}

SceneSpec read_scene(const std::string& file, const std::vector<std::string>& overrides) {
    return parse_scene(file, read_scene_text(file), overrides);
}

SceneSpec parse_scene(const std::string& file, const std::string& text, const std::vector<std::string>& overrides) {
    TomlValue root = parse_toml(text, source_text(file, text));
    include_files(root, file);
    for (const std::string& override : overrides) apply_override(root, override);
    Problems problems;
    SceneSpec scene = read_tables(root, problems);
    scene.file = file;
    if (problems.empty()) read_tables_of_files(scene, root, problems);
    // A value that could not be read is still the default, which would only contradict the others.
    if (problems.empty()) add_contradictions(scene, root, problems);
    problems.raise();
    return scene;
}

} // namespace skein
