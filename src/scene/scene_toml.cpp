#include "scene/scene_toml.hpp"

#include "scene/toml_parser.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace skein {

const TomlEntry* TomlValue::find(std::string_view key) const {
    const auto* table = as<TomlTable>();
    if (!table) return nullptr;
    const auto at = std::find_if(table->begin(), table->end(), [&](const TomlEntry& e) { return e.key == key; });
    return at == table->end() ? nullptr : &*at;
}

TomlEntry* TomlValue::find(std::string_view key) { return const_cast<TomlEntry*>(std::as_const(*this).find(key)); }

std::string found(const TomlValue& value) {
    struct Words {
        std::string operator()(bool b) const { return b ? "the boolean true" : "the boolean false"; }
        std::string operator()(std::int64_t i) const { return fmt::format("the integer {}", i); }
        std::string operator()(double x) const {
            return fmt::format("the number {}{}", x, x == std::floor(x) && std::abs(x) < 1e16 ? ".0" : "");
        }
        std::string operator()(const std::string& s) const { return fmt::format("the string \"{}\"", s); }
        std::string operator()(TomlDate) const { return "a date or time"; }
        std::string operator()(const TomlArray& a) const {
            return fmt::format("an array of {} value{}", a.size(), a.size() == 1 ? "" : "s");
        }
        std::string operator()(const TomlTable&) const { return "a table"; }
    };
    return std::visit(Words{}, value.value);
}

TomlValue parse_toml(const std::string& text, std::shared_ptr<const SourceText> source) {
    return TomlParser(text, std::move(source)).parse();
}

std::shared_ptr<const SourceText> source_text(const std::string& name, const std::string& text) {
    auto source = std::make_shared<SourceText>(SourceText{name, {}});
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        if (line.ends_with('\r')) line.pop_back();
        // Lines are for messages, and a message must not steer the terminal.
        for (char& c : line)
            if (c != '\t' && std::iscntrl(static_cast<unsigned char>(c))) c = '?';
        source->lines.push_back(line);
    }
    if (source->lines.empty()) source->lines.emplace_back();
    return source;
}

} // namespace skein
