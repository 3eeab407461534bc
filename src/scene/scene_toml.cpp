#include "scene/scene_toml.hpp"

#include "skein/core/error.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <toml++/toml.h>

namespace skein {

namespace {

using Source = std::shared_ptr<const SourceText>;

constexpr auto npos = std::string::npos;
constexpr int longest_key = 16; ///< names in a dotted key; no key of a scene has more than five

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_bare(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; }

/// From the parser's places, which count characters, to those of messages, which count bytes.
class TomlPlaces {
public:
    explicit TomlPlaces(Source source) : source_(std::move(source)) {}

    Place operator()(const toml::source_position& at, int length = 1) {
        if (source_->lines.empty()) return {source_};
        return {source_, static_cast<int>(at.line), byte_column(at), length};
    }
    Place operator()(const toml::source_region& at) {
        if (at.begin.line == at.end.line)
            return (*this)(at.begin, std::max(1, byte_column(at.end) - byte_column(at.begin)));
        const std::size_t line = at.begin.line - 1;
        const std::size_t size = line < source_->lines.size() ? source_->lines[line].size() : 0;
        return (*this)(at.begin, std::max(1, static_cast<int>(size) + 1 - byte_column(at.begin)));
    }

private:
    /// Byte at which each character of a line begins, found once per line: a list of numbers may well be one line.
    int byte_column(const toml::source_position& at) {
        if (at.line < 1 || at.line > source_->lines.size()) return static_cast<int>(at.column);
        const auto [entry, is_new] = starts_.try_emplace(at.line);
        std::vector<int>& starts = entry->second;
        const std::string& line = source_->lines[at.line - 1];
        if (is_new &&
            std::any_of(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; }))
            for (std::size_t i = 0; i < line.size(); ++i)
                if ((static_cast<unsigned char>(line[i]) & 0xC0) != 0x80) starts.push_back(static_cast<int>(i));
        if (starts.empty()) return static_cast<int>(at.column); // plain ASCII
        const std::size_t i = at.column - 1;
        return 1 + (i < starts.size() ? starts[i] : static_cast<int>(line.size()));
    }

    Source source_;
    std::unordered_map<toml::source_index, std::vector<int>> starts_;
};

TomlValue convert(const toml::node& in, TomlPlaces& places) {
    TomlValue out{TomlDate{}, places(in.source())};
    if (const auto* b = in.as_boolean()) out.value = b->get();
    if (const auto* i = in.as_integer()) out.value = i->get();
    if (const auto* x = in.as_floating_point()) out.value = x->get();
    if (const auto* s = in.as_string()) out.value = s->get();
    if (const auto* list = in.as_array()) {
        TomlArray items;
        items.reserve(list->size());
        for (const toml::node& item : *list) items.push_back(convert(item, places));
        out.value = std::move(items);
    }
    if (const auto* table = in.as_table()) {
        TomlTable entries;
        entries.reserve(table->size());
        for (const auto& [key, value] : *table)
            entries.push_back({std::string(key.str()), places(key.source()), convert(value, places)});
        std::sort(entries.begin(), entries.end(), [](const TomlEntry& a, const TomlEntry& b) {
            return std::tuple(a.place.line, a.place.column, a.key) < std::tuple(b.place.line, b.place.column, b.key);
        });
        out.value = std::move(entries);
    }
    return out;
}

/// Refuses dotted keys of very many names: the parser makes a table in a table of each, and its recursion over them has
/// no limit.
void refuse_long_keys(std::string_view text, const Source& source) {
    int line = 1, dots = 0;
    std::size_t line_start = 0;
    bool named = false, apart = false; ///< a name has begun since the last dot; blanks have followed it
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (is_blank(c)) {
            apart = named;
            continue;
        }
        if (c == '.' && named) {
            named = apart = false;
            if (++dots < longest_key) continue;
            const Place place =
                source->lines.empty() ? Place{source} : Place{source, line, static_cast<int>(i - line_start) + 1, 1};
            throw InputError(message_at(place, fmt::format("a key of more than {} names", longest_key)));
        }
        std::size_t end = npos; // of a name in quotes
        if (c == '"' || c == '\'') {
            end = i + 1;
            while (end < text.size() && text[end] != c && text[end] != '\n')
                end += c == '"' && text[end] == '\\' ? 2 : 1;
            if (end >= text.size() || text[end] != c) end = npos;
        }
        if (!is_bare(c) && end == npos) {
            dots = 0;
            named = apart = false;
            if (c == '\n') {
                ++line;
                line_start = i + 1;
            }
        } else {
            if (apart) dots = 0; // another word, so no key
            named = true;
            apart = false;
            if (end != npos) i = end;
        }
    }
}

/// The last name of the key that a line with a place in it assigns to or opens, and the column where it begins, from 0.
std::pair<std::string, std::size_t> key_at(const std::string& line, std::size_t at) {
    at = std::min(at, line.size());
    std::size_t end = at;
    if (const std::size_t bracket = line.find_first_not_of("[ \t", at); at < line.size() && line[at] == '[') {
        end = std::min(line.find(']', at), line.size()); // a header: the name before its end
        at = bracket;
    } else if (const std::size_t equals = at == 0 ? npos : line.find_last_not_of(" \t", at - 1);
               equals != npos && line[equals] == '=') {
        end = equals; // a value: the name before it
    } else {
        while (end < line.size() && is_bare(line[end])) ++end;
    }
    while (end > 0 && is_blank(line[end - 1])) --end;
    const char quote = end > 0 ? line[end - 1] : ' ';
    if (quote == '"' || quote == '\'') {
        const std::size_t begin = end > 1 ? line.rfind(quote, end - 2) : npos;
        if (begin != npos) return {line.substr(begin + 1, end - begin - 2), begin + 1};
    }
    std::size_t begin = end;
    while (begin > 0 && is_bare(line[begin - 1])) --begin;
    return {line.substr(begin, end - begin), begin};
}

/// True if a table stands in the text under a [header], not in a line.
bool has_header(const TomlValue& table) {
    const auto& lines = table.place.text->lines;
    const auto line = static_cast<std::size_t>(table.place.line), column = static_cast<std::size_t>(table.place.column);
    return table.as<TomlTable>() && line >= 1 && line <= lines.size() && column >= 1 &&
           column <= lines[line - 1].size() && lines[line - 1][column - 1] == '[';
}

/// The table itself, or the last one of a list of tables, which is what later headers add to.
const TomlValue* opened(const TomlValue& value) {
    const auto* list = value.as<TomlArray>();
    return !list ? &value : list->empty() ? nullptr : &list->back();
}

/// The table to which lines at the end of a text belong: that of its last header.
const TomlValue* last_table(const TomlValue& root) {
    const TomlValue* last = &root;
    const auto look = [&](const TomlValue& in, const auto& self) -> void {
        for (const TomlEntry& entry : *in.as<TomlTable>())
            if (const TomlValue* table = opened(entry.value); table && table->as<TomlTable>()) {
                if (has_header(*table) && table->place.line >= last->place.line) last = table;
                self(*table, self);
            }
    };
    look(root, look);
    return last;
}

/// The line of the entry that the key or header of line `at` names again, counted from 1; 0 where that is not to be
/// told from the lines above.
int line_of_first(std::string_view text, int at, const Source& source) {
    std::size_t begin = 0;
    for (int line = 1; line < at; ++line) begin = text.find('\n', begin) + 1;
    try {
        TomlPlaces places(source);
        const TomlValue above = convert(toml::parse(text.substr(0, begin)), places);
        const TomlValue again = convert(toml::parse(text.substr(begin, text.find('\n', begin) - begin)), places);
        const bool header = text.substr(begin, text.find_first_not_of(" \t", begin) + 1 - begin).ends_with('[');
        const TomlValue* in = header ? &above : last_table(above);
        int line = 0;
        for (const TomlValue* key = &again; in && key && key->as<TomlTable>() && key->as<TomlTable>()->size() == 1;) {
            const TomlEntry& name = key->as<TomlTable>()->front();
            const TomlEntry* first = in->find(name.key);
            if (!first) break;
            line = first->place.line;
            in = opened(first->value);
            key = opened(name.value);
        }
        return line;
    } catch (const toml::parse_error&) { // a key in an array or a table over several lines
        return 0;
    }
}

/// The parser's words for what it found, in those of other messages. `at_end`: of a line.
std::string reworded(std::string said, bool at_end) {
    if (said.starts_with("Error while parsing ")) said.erase(0, std::min(said.find(": "), said.size() - 2) + 2);
    if (said.find("maximum nested value depth") != npos)
        return "arrays or tables within each other, more than 256 deep";
    if (said.find("could not determine value type") != npos) return "not a TOML value; text stands in double quotes";
    if (at_end && said.find("unescaped control characters") != npos) return "a string that does not end on its line";
    if (said.find("encountered end-of-file") != npos) return "the text ends here, within what has begun";
    for (const auto& [was, is] :
         {std::pair<std::string_view, std::string_view>{", saw '\\n'", ", found the end of the line"},
          {", saw '\\r'", ", found the end of the line"},
          {", saw ", ", found "},
          {"could not be interpreted as a value", "is a number too large or too small"},
          {"is not representable in 64 bits", "is a number too large"}})
        if (const std::size_t at = said.find(was); at != npos) {
            said.replace(at, was.size(), is);
            break;
        }
    return said;
}

[[noreturn]] void raise_syntax_error(const toml::parse_error& e, std::string_view text, const Source& source) {
    const std::string said(e.description());
    Place place = TomlPlaces(source)(e.source().begin);
    const bool known = place.line >= 1 && place.line <= static_cast<int>(source->lines.size());
    if (!known || (said.find("cannot redefine") == npos && said.find("cannot insert") == npos))
        throw InputError(message_at(
            place, reworded(said, known && place.column >
                                               static_cast<int>(
                                                   source->lines[static_cast<std::size_t>(place.line) - 1].size()))));
    const auto [name, begin] =
        key_at(source->lines[static_cast<std::size_t>(place.line) - 1], static_cast<std::size_t>(place.column) - 1);
    place.column = static_cast<int>(begin) + 1;
    place.length = std::max(1, static_cast<int>(name.size()));
    const int first = line_of_first(text, place.line, source);
    throw InputError(message_at(place, first > 0
                                           ? fmt::format("'{}' is given twice; the first is on line {}", name, first)
                                           : fmt::format("'{}' is given twice", name)));
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
    refuse_long_keys(text, source);
    try {
        TomlPlaces places(source);
        return convert(toml::parse(text), places);
    } catch (const toml::parse_error& e) {
        raise_syntax_error(e, text, source);
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

namespace {

void collect_given(const TomlValue& value, const std::string& path, std::set<std::string>& given) {
    const auto child = [&](const std::string& name) { return path.empty() ? name : path + "." + name; };
    if (const auto* table = value.as<TomlTable>()) {
        for (const TomlEntry& entry : *table) {
            given.insert(child(entry.key));
            collect_given(entry.value, child(entry.key), given);
        }
    }
    if (const auto* list = value.as<TomlArray>(); list && !list->empty() && list->front().as<TomlTable>()) {
        for (std::size_t i = 0; i < list->size(); ++i) {
            given.insert(child(std::to_string(i)));
            collect_given((*list)[i], child(std::to_string(i)), given);
        }
    }
}

} // namespace

std::set<std::string> given_keys(const TomlValue& root) {
    std::set<std::string> given;
    collect_given(root, "", given);
    return given;
}

} // namespace skein
