// TOML text as a tree that remembers where each key and value stands. The parser's own header stays in scene_toml.cpp.
#pragma once

#include "scene/problems.hpp"

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace skein {

struct TomlValue;
struct TomlEntry;
struct TomlDate {}; ///< no key of a scene takes a date: only its presence matters
using TomlArray = std::vector<TomlValue>;
using TomlTable = std::vector<TomlEntry>; ///< in the order of the file

struct TomlValue {
    std::variant<bool, std::int64_t, double, std::string, TomlDate, TomlArray, TomlTable> value;
    Place place;

    template <class T> const T* as() const { return std::get_if<T>(&value); }
    template <class T> T* as() { return std::get_if<T>(&value); }
    /// The entry of a table; null where it is absent or this is no table.
    const TomlEntry* find(std::string_view key) const;
    TomlEntry* find(std::string_view key);
};

struct TomlEntry {
    std::string key;
    Place place; ///< of the key
    TomlValue value;
};

/// "the string "abc"", "an array of 2 values", ...: what a message says was found.
std::string found(const TomlValue& value);

/// The table of a whole document. Throws InputError "file:line:column: ..." on a syntax error or a key given twice.
TomlValue parse_toml(const std::string& text, std::shared_ptr<const SourceText> source);

/// Paths of every key, table and item of a list of tables: "rods.0.section". Other lists are long, and no check asks
/// for their items.
std::set<std::string> given_keys(const TomlValue& root);

/// Text cut into lines, without line ends.
std::shared_ptr<const SourceText> source_text(const std::string& name, const std::string& text);

} // namespace skein
