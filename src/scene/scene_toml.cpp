#include "scene/scene_toml.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <sstream>
#include <tuple>

#include <fmt/format.h>
#include <toml.hpp>

namespace skein {

namespace {

using Source = std::shared_ptr<const SourceText>;

constexpr auto npos = std::string::npos;

/// Where `word` stands as a whole word in [from, to) of a line; the last one before `to`.
std::size_t find_word(const std::string& line, const std::string& word, std::size_t from, std::size_t to) {
    const auto in_key = [&](std::size_t i) {
        return i < line.size() && (std::isalnum(static_cast<unsigned char>(line[i])) || line[i] == '_' || line[i] == '-');
    };
    if (to < word.size()) return npos;
    for (std::size_t at = line.rfind(word, to - word.size()); at != npos && at >= from; at = line.rfind(word, at - 1)) {
        if ((at == 0 || !in_key(at - 1)) && !in_key(at + word.size())) return at;
        if (at == 0) break;
    }
    return npos;
}

Place place_of(const toml::value& value, const Source& source) {
    const auto at = value.location();
    if (source->lines.empty()) return {source};
    return {source, static_cast<int>(at.line()), static_cast<int>(at.column()), static_cast<int>(at.region())};
}

/// The parser keeps no position of keys. A key stands before its value, or, in a table header, inside what the parser calls
/// the table's place.
Place place_of_key(const std::string& key, const Place& value) {
    if (value.line < 1 || value.line > static_cast<int>(value.text->lines.size())) return value;
    const std::string& line = value.text->lines[static_cast<std::size_t>(value.line - 1)];
    const auto start = static_cast<std::size_t>(value.column - 1);
    const std::size_t end = std::min(line.size(), start + static_cast<std::size_t>(value.length));
    std::size_t at = find_word(line, key, 0, start);
    if (at == npos) at = find_word(line, key, start, end);
    return at == npos ? value : Place{value.text, value.line, static_cast<int>(at) + 1, static_cast<int>(key.size())};
}

/// The parser turns numbers that fit no machine number into the largest one; here they become infinite, which no key accepts.
double real_or_infinite(double x) {
    constexpr double largest = std::numeric_limits<double>::max();
    return std::abs(x) == largest ? std::copysign(std::numeric_limits<double>::infinity(), x) : x;
}
std::variant<std::int64_t, double> integer_or_infinite(std::int64_t i) {
    using Limits = std::numeric_limits<std::int64_t>;
    if (i == Limits::max()) return std::numeric_limits<double>::infinity();
    if (i == Limits::min()) return -std::numeric_limits<double>::infinity();
    return i;
}

TomlValue convert(const toml::value& in, const Source& source) {
    TomlValue out{TomlDate{}, place_of(in, source)};
    if (in.is_boolean()) out.value = in.as_boolean();
    if (in.is_integer()) std::visit([&](auto x) { out.value = x; }, integer_or_infinite(in.as_integer()));
    if (in.is_floating()) out.value = real_or_infinite(in.as_floating());
    if (in.is_string()) out.value = in.as_string().str;
    if (in.is_array()) {
        TomlArray items;
        for (const toml::value& item : in.as_array()) items.push_back(convert(item, source));
        out.value = std::move(items);
    }
    if (in.is_table()) {
        TomlTable entries;
        for (const auto& [key, value] : in.as_table()) {
            TomlValue converted = convert(value, source);
            entries.push_back({key, place_of_key(key, converted.place), std::move(converted)});
        }
        std::sort(entries.begin(), entries.end(), [](const TomlEntry& a, const TomlEntry& b) {
            return std::tuple(a.place.line, a.place.column, a.key) < std::tuple(b.place.line, b.place.column, b.key);
        });
        out.value = std::move(entries);
    }
    return out;
}

/// One " 12 | line" and " | ^--- note" pair of the parser's own message.
struct Mark {
    int line, column;
    std::string note;
};

/// The marks of the parser's message: more reliable than the exception's location, which is often the start of the line.
std::vector<Mark> marks(const std::string& text) {
    std::vector<Mark> found;
    std::istringstream in(text);
    std::string line;
    int number = 0;
    std::size_t bar = npos;
    while (std::getline(in, line)) {
        const std::size_t first = line.find_first_not_of(' ');
        if (first == npos) continue;
        if (std::isdigit(static_cast<unsigned char>(line[first]))) {
            number = std::stoi(line.substr(first));
            bar = line.find(" | ");
        } else if (number > 0 && line[first] == '|' && bar != npos) {
            const std::size_t mark = line.find_first_of("^~", bar + 3);
            if (mark == npos) continue;
            const std::size_t note = line.find_first_not_of("^~- ", mark);
            found.push_back({number, static_cast<int>(mark - bar) - 2, note == npos ? "" : line.substr(note)});
            number = 0;
        }
    }
    return found;
}

/// What the parser says is there twice: value ("shape.length") already exists.
std::string repeated_name(const std::string& what) {
    const std::size_t quote = what.find("(\""), unquote = what.find("\")"), line_end = what.find('\n');
    return quote < unquote && unquote < line_end ? what.substr(quote + 2, unquote - quote - 2) : "";
}

/// The parser's complaint without its function names, in words for somebody who writes a scene.
std::string reworded(const std::string& what, const std::vector<Mark>& at) {
    std::string said = what.substr(0, what.find('\n'));
    if (said.starts_with("[error] ")) said.erase(0, 8);
    if (said.starts_with("toml::")) said.erase(0, said.find(": ") + 2);
    if (const std::string name = repeated_name(what); !name.empty())
        return fmt::format("'{}' is given twice; the first is on line {}", name, at.front().line);
    if (said.find("an invalid key appeared") != npos) return "neither 'key = value' nor a closed [table] header";
    if (said.find("unknown value appeared") != npos) return "not a TOML value; text stands in double quotes";
    if (said.find("next token is not a valid string") != npos) return "a string that does not end on its line";
    const std::string note = at.empty() ? "" : at.back().note;
    if (!note.empty() && note != "here" && !note.starts_with("should be")) said += ": " + note;
    return said.ends_with('.') ? said.substr(0, said.size() - 1) : said;
}

[[noreturn]] void raise_syntax_error(const toml::syntax_error& e, const Source& source) {
    const std::vector<Mark> at = marks(e.what());
    Place place = at.empty() ? Place{source, static_cast<int>(e.location().line()), 1, 1}
                             : Place{source, at.back().line, at.back().column, 1};
    if (const std::string name = repeated_name(e.what()); !name.empty()) {
        place.length = static_cast<int>(name.size()) + 2; // in case it is a header: name and brackets
        place = place_of_key(name.substr(name.rfind('.') + 1), place);
    }
    throw InputError(message_at(place, reworded(e.what(), at)));
}

} // namespace

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

TomlValue parse_toml(const std::string& text, Source source) {
    std::istringstream in(text);
    try {
        return convert(toml::parse(in, source->name), source);
    } catch (const toml::syntax_error& e) {
        raise_syntax_error(e, source);
    } catch (const std::exception& e) { // what the parser cannot place, e.g. an unreadable byte
        throw InputError(fmt::format("{}: {}", source->name, e.what()));
    }
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
