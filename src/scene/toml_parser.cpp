#include "scene/toml_parser.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace skein {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_bare(char c) { return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-'; }
bool is_end(char c) { return c == '\n' || c == '\r' || c == '\0'; }

/// The table that a key written within another table opens: the table itself, or the last one of a list of tables.
TomlTable* table_of(TomlEntry& entry) {
    if (auto* table = entry.value.as<TomlTable>()) return table;
    auto* list = entry.value.as<TomlArray>();
    return list && !list->empty() ? list->back().as<TomlTable>() : nullptr;
}

TomlEntry* find(TomlTable& table, std::string_view key) {
    const auto at = std::find_if(table.begin(), table.end(), [&](const TomlEntry& e) { return e.key == key; });
    return at == table.end() ? nullptr : &*at;
}

void append_utf8(std::string& out, std::uint32_t code) {
    const auto put = [&](std::uint32_t byte) { out += static_cast<char>(byte); };
    if (code < 0x80) return put(code);
    if (code < 0x800) return put(0xC0 | code >> 6), put(0x80 | (code & 0x3F));
    if (code >= 0x10000) put(0xF0 | code >> 18), put(0x80 | (code >> 12 & 0x3F));
    else put(0xE0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3F)), put(0x80 | (code & 0x3F));
}

/// Bytes of the character of UTF-8 at the start of `text`; 0 where there is none.
std::size_t character_bytes(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    if (byte(0) < 0x80) return 1;
    const std::size_t bytes = byte(0) >> 5 == 6 ? 2 : byte(0) >> 4 == 14 ? 3 : byte(0) >> 3 == 30 ? 4 : 0;
    if (bytes == 0 || text.size() < bytes) return 0;
    std::uint32_t code = byte(0) & (0x7Fu >> bytes);
    for (std::size_t i = 1; i < bytes; ++i) {
        if (byte(i) >> 6 != 2) return 0;
        code = code << 6 | (byte(i) & 0x3F);
    }
    constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    return code < least[bytes] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000) ? 0 : bytes;
}

/// Digits with single underscores between them, without these; nothing where it is no such number.
template <class IsDigit> std::optional<std::string> plain_digits(std::string_view text, IsDigit is) {
    std::string digits;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (is(text[i])) digits += text[i];
        else if (text[i] != '_' || i == 0 || i + 1 == text.size() || !is(text[i - 1]) || !is(text[i + 1])) return std::nullopt;
    }
    return digits.empty() ? std::nullopt : std::optional(digits);
}

using Number = std::variant<std::int64_t, double>;

/// Too large for a machine number: infinite, which no key accepts.
Number whole_number(std::string_view digits, int base, bool negative) {
    std::int64_t i = 0;
    const std::string text = (negative ? "-" : "") + std::string(digits);
    if (std::from_chars(text.data(), text.data() + text.size(), i, base).ec == std::errc{}) return i;
    const double infinite = std::numeric_limits<double>::infinity();
    return negative ? -infinite : infinite;
}

std::optional<Number> number_of(std::string_view word) {
    std::string_view rest = word;
    const bool sign = rest.starts_with('+') || rest.starts_with('-'), negative = rest.starts_with('-');
    if (sign) rest.remove_prefix(1);
    if (rest == "inf" || rest == "nan") {
        const double x = rest == "inf" ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
        return negative ? -x : x;
    }
    for (const auto& [prefix, base] : {std::pair{"0x", 16}, {"0o", 8}, {"0b", 2}})
        if (!sign && rest.starts_with(prefix)) {
            const auto in_base = [base = base](char c) {
                const int value = is_digit(c)            ? c - '0'
                                  : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                  : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                                         : 99;
                return value < base;
            };
            const auto digits = plain_digits(rest.substr(2), in_base);
            return digits ? std::optional(whole_number(*digits, base, false)) : std::nullopt;
        }
    const std::size_t e = rest.find_first_of("eE");
    const std::string_view mantissa = rest.substr(0, e);
    const std::size_t point = mantissa.find('.');
    const auto whole = plain_digits(mantissa.substr(0, point), is_digit);
    if (!whole || (whole->size() > 1 && whole->front() == '0')) return std::nullopt;
    std::string plain = (negative ? "-" : "") + *whole;
    if (point == std::string_view::npos && e == std::string_view::npos) return whole_number(*whole, 10, negative);
    if (point != std::string_view::npos) {
        const auto fraction = plain_digits(mantissa.substr(point + 1), is_digit);
        if (!fraction) return std::nullopt;
        plain += "." + *fraction;
    }
    if (e != std::string_view::npos) {
        std::string_view exponent = rest.substr(e + 1);
        const bool signed_exponent = exponent.starts_with('+') || exponent.starts_with('-');
        const auto digits = plain_digits(exponent.substr(signed_exponent ? 1 : 0), is_digit);
        if (!digits) return std::nullopt;
        plain += (exponent.starts_with('-') ? "e-" : "e") + *digits;
    }
    double x = 0;
    if (std::from_chars(plain.data(), plain.data() + plain.size(), x).ec == std::errc{}) return x;
    return std::strtod(plain.c_str(), nullptr); // beyond the range: infinite or denormal
}

/// 1979-05-27, 07:32:00, or both.
bool is_date_or_time(std::string_view word) {
    const auto digits = [&](std::size_t from, std::size_t n) {
        return word.size() >= from + n && std::all_of(word.begin() + static_cast<std::ptrdiff_t>(from),
                                                      word.begin() + static_cast<std::ptrdiff_t>(from + n), is_digit);
    };
    const bool date = digits(0, 4) && digits(5, 2) && digits(8, 2) && word[4] == '-' && word[7] == '-';
    const bool time = digits(0, 2) && digits(3, 2) && digits(6, 2) && word[2] == ':' && word[5] == ':';
    return date || time;
}

} // namespace

/// One level deeper for the life of the object.
class TomlParser::Nested {
public:
    Nested(TomlParser& parser, const Place& place) : parser_(parser) {
        if (++parser_.depth_ > deepest) parser_.fail(place, fmt::format("nested deeper than {} levels", deepest));
    }
    ~Nested() { --parser_.depth_; }
    Nested(const Nested&) = delete;
    Nested& operator=(const Nested&) = delete;

private:
    TomlParser& parser_;
};

TomlParser::TomlParser(std::string_view text, std::shared_ptr<const SourceText> source) : text_(text), source_(std::move(source)) {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3); // the mark that some editors put before UTF-8
}

bool TomlParser::accept(char c) {
    if (ended() || peek() != c) return false;
    ++at_;
    return true;
}

void TomlParser::new_line() {
    line_start_ = ++at_;
    ++line_;
}

Place TomlParser::place(std::size_t length) const {
    if (source_->lines.empty()) return {source_};
    return {source_, line_, static_cast<int>(at_ - line_start_) + 1, static_cast<int>(length)};
}

Place TomlParser::since(Place begin) const {
    if (begin.line == line_) begin.length = std::max(1, static_cast<int>(at_ - line_start_) + 1 - begin.column);
    return begin;
}

void TomlParser::fail(const Place& place, const std::string& message) const { throw InputError(message_at(place, message)); }

void TomlParser::twice(const TomlEntry& first, const Key& again) const {
    fail(again.place, fmt::format("'{}' is given twice; the first is on line {}", again.name, first.place.line));
}

std::string TomlParser::next() const {
    if (ended()) return "the end of the text";
    return is_end(peek()) ? "the end of the line"
                          : fmt::format("'{}'", text_.substr(at_, std::max<std::size_t>(1, character_bytes(text_.substr(at_)))));
}

void TomlParser::skip_spaces() {
    while (!ended() && (peek() == ' ' || peek() == '\t')) ++at_;
}

void TomlParser::skip_comment() {
    if (!ended() && peek() == '#')
        while (!ended() && peek() != '\n') ++at_;
    if (peek() == '\r' && peek(1) == '\n') ++at_;
}

void TomlParser::skip_lines() {
    for (;;) {
        skip_spaces();
        skip_comment();
        if (ended() || peek() != '\n') return;
        new_line();
    }
}

void TomlParser::expect_line_end() {
    skip_spaces();
    skip_comment();
    if (!ended() && peek() != '\n') fail(place(), fmt::format("expected the end of the line, found {}", next()));
}

TomlValue TomlParser::parse() {
    // What no part of TOML takes, told by its cause wherever it stands.
    for (std::size_t begin = 0; begin < text_.size();) {
        const auto c = static_cast<unsigned char>(text_[begin]);
        const std::size_t bytes = c < 0x80 ? 1 : character_bytes(text_.substr(begin));
        const bool control = (c < 0x20 && c != '\t' && c != '\n' && !(c == '\r' && text_.substr(begin, 2) == "\r\n")) || c == 0x7F;
        if (bytes == 0 || control) {
            line_ = 1 + static_cast<int>(std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(begin), '\n'));
            line_start_ = begin == 0 ? 0 : text_.rfind('\n', begin - 1) + 1;
            at_ = begin;
            fail(place(), bytes == 0 ? fmt::format("the byte 0x{:02x} is no text in UTF-8", c)
                                     : fmt::format("the control character 0x{:02x}; a scene is plain text", c));
        }
        begin += bytes;
    }
    for (skip_lines(); !ended(); skip_lines()) {
        if (peek() == '[') header();
        else assignment(*open_);
        expect_line_end();
    }
    return {std::move(root_), {source_, source_->lines.empty() ? 0 : 1, 1, 1}};
}

void TomlParser::header() {
    const Place begin = place();
    const std::size_t from = at_;
    const bool list = starts("[[");
    at_ += list ? 2 : 1;
    const Path keys = path();
    if (!accept(']') || (list && !accept(']'))) fail(begin, "neither 'key = value' nor a closed [table] header");
    Place whole = begin;
    whole.length = static_cast<int>(at_ - from);
    TomlTable& parent = parent_of(keys);
    const Key& last = keys.back();
    TomlEntry* entry = find(parent, last.name);
    if (!entry)
        entry = &parent.emplace_back(
            TomlEntry{last.name, last.place, {TomlTable{}, whole}, list ? TomlEntry::Made::list : TomlEntry::Made::header});
    else if (!list && entry->made == TomlEntry::Made::implied)
        *entry = {last.name, last.place, std::move(entry->value), TomlEntry::Made::header};
    else if (!list || entry->made != TomlEntry::Made::list) twice(*entry, last);
    if (list) {
        if (!entry->value.as<TomlArray>()) entry->value = {TomlArray{}, whole};
        entry->value.as<TomlArray>()->push_back({TomlTable{}, whole});
    }
    open_ = table_of(*entry);
}

/// The table around the last key of a header, made where it is not there yet.
TomlTable& TomlParser::parent_of(const Path& keys) {
    TomlTable* table = &root_;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        TomlEntry* entry = find(*table, keys[i].name);
        if (!entry)
            entry = &table->emplace_back(
                TomlEntry{keys[i].name, keys[i].place, {TomlTable{}, keys[i].place}, TomlEntry::Made::implied});
        if (entry->made == TomlEntry::Made::value) twice(*entry, keys[i]);
        table = table_of(*entry);
    }
    return *table;
}

TomlParser::Path TomlParser::path() {
    Path keys;
    do {
        skip_spaces();
        keys.push_back(key());
        if (keys.size() > deepest) fail(keys.front().place, fmt::format("nested deeper than {} levels", deepest));
        skip_spaces();
    } while (accept('.'));
    return keys;
}

TomlParser::Key TomlParser::key() {
    const Place begin = place();
    if (peek() == '"' || peek() == '\'') {
        std::string name = line_string(peek());
        Place inside = since(begin); // without the quotes
        if (inside.line > 0) ++inside.column, inside.length = std::max(1, inside.length - 2);
        return {std::move(name), inside};
    }
    const std::size_t from = at_;
    while (!ended() && is_bare(peek())) ++at_;
    if (at_ == from) fail(begin, "neither 'key = value' nor a closed [table] header");
    return {std::string(text_.substr(from, at_ - from)), since(begin)};
}

void TomlParser::assignment(TomlTable& into) {
    const Path keys = path();
    if (!accept('=')) fail(place(), "missing '=' after the key");
    skip_spaces();
    if (ended() || is_end(peek()) || peek() == '#') fail(place(), "missing value after '='");
    TomlTable* table = &into;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        TomlEntry* entry = find(*table, keys[i].name);
        if (!entry)
            entry =
                &table->emplace_back(TomlEntry{keys[i].name, keys[i].place, {TomlTable{}, keys[i].place}, TomlEntry::Made::dotted});
        if (entry->made != TomlEntry::Made::dotted && entry->made != TomlEntry::Made::implied) twice(*entry, keys[i]);
        table = table_of(*entry);
    }
    if (const TomlEntry* first = find(*table, keys.back().name)) twice(*first, keys.back());
    TomlValue given = value();
    table->push_back({keys.back().name, keys.back().place, std::move(given), TomlEntry::Made::value});
}

TomlValue TomlParser::value() {
    const Place begin = place();
    TomlValue read{TomlDate{}, begin};
    switch (peek()) {
    case '"':
    case '\'':
        read.value = string();
        break;
    case '[':
        read.value = array();
        break;
    case '{':
        read.value = inline_table();
        break;
    default:
        return word();
    }
    read.place = since(begin);
    return read;
}

std::string TomlParser::string() {
    const char quote = peek();
    return peek(1) == quote && peek(2) == quote ? block_string(quote) : line_string(quote);
}

std::string TomlParser::line_string(char quote) {
    const Place begin = place();
    ++at_;
    std::string out;
    while (!accept(quote)) {
        if (ended() || is_end(peek())) fail(begin, "a string that does not end on its line");
        if (quote == '"' && peek() == '\\') escape(out);
        else out += text_[at_++];
    }
    return out;
}

std::string TomlParser::block_string(char quote) {
    const Place begin = place(3);
    const std::string end(3, quote);
    at_ += 3;
    if (peek() == '\r') ++at_;
    if (peek() == '\n') new_line();
    std::string out;
    while (!starts(end)) {
        if (ended()) fail(begin, "a string that does not end");
        if (quote == '"' && peek() == '\\') {
            const std::size_t behind = text_.find_first_not_of(" \t\r", at_ + 1);
            if (behind == std::string_view::npos || text_[behind] != '\n') {
                escape(out);
                continue;
            }
            at_ = behind; // a line that goes on in the next
            while (!ended() && (peek() == ' ' || peek() == '\t' || is_end(peek())))
                if (peek() == '\n') new_line();
                else ++at_;
        } else if (peek() == '\n') {
            out += '\n';
            new_line();
        } else out += text_[at_++];
    }
    at_ += 3;
    for (int i = 0; i < 2 && accept(quote); ++i) out += quote; // up to two belong to the text
    return out;
}

void TomlParser::escape(std::string& out) {
    const Place begin = place(2);
    ++at_;
    constexpr std::string_view letters = "btnfr\"\\", meant = "\b\t\n\f\r\"\\";
    const char c = peek();
    ++at_;
    if (const std::size_t i = letters.find(c); i != std::string_view::npos && c != '\0') {
        out += meant[i];
        return;
    }
    if (c == 'u' || c == 'U') {
        const std::string_view digits = text_.substr(std::min(at_, text_.size()), c == 'u' ? 4 : 8);
        std::uint32_t code = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
        const bool all = digits.size() == (c == 'u' ? 4u : 8u) && end == digits.data() + digits.size() && error == std::errc{};
        if (all && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF)) {
            at_ += digits.size();
            append_utf8(out, code);
            return;
        }
    }
    fail(begin, "no escape of TOML; '\\\\' stands for a backslash");
}

TomlArray TomlParser::array() {
    const Place begin = place();
    const Nested nested(*this, begin);
    ++at_;
    TomlArray items;
    for (skip_lines(); !accept(']'); skip_lines()) {
        if (ended()) fail(begin, "an array that does not end");
        items.push_back(value());
        skip_lines();
        if (!accept(',') && peek() != ']')
            fail(place(), begin.line > 0 ? fmt::format("expected ',' or ']' in the array of line {}, found {}", begin.line, next())
                                         : "expected ',' or ']'");
    }
    return items;
}

TomlTable TomlParser::inline_table() {
    const Place begin = place();
    const Nested nested(*this, begin);
    ++at_;
    TomlTable table;
    skip_spaces();
    if (accept('}')) return table;
    for (;;) {
        skip_spaces();
        if (ended() || is_end(peek())) fail(begin, "a { table } that does not end on its line");
        assignment(table);
        skip_spaces();
        if (accept('}')) return table;
        if (!accept(',')) fail(place(), fmt::format("expected ',' or '}}', found {}", next()));
    }
}

/// A boolean, number or date.
TomlValue TomlParser::word() {
    const Place begin = place();
    const std::size_t from = at_;
    const auto run = [&] {
        while (!ended() && (is_bare(peek()) || peek() == '+' || peek() == '.' || peek() == ':')) ++at_;
    };
    run();
    if (is_date_or_time(text_.substr(from, at_ - from)) && peek() == ' ' && is_digit(peek(1)) && is_digit(peek(2)) &&
        peek(3) == ':') {
        ++at_;
        run();
    }
    const std::string_view read = text_.substr(from, at_ - from);
    TomlValue value{TomlDate{}, since(begin)};
    if (read == "true" || read == "false") value.value = read == "true";
    else if (is_date_or_time(read)) return value;
    else if (const auto number = number_of(read)) std::visit([&](auto x) { value.value = x; }, *number);
    else if (!read.empty() && (is_digit(read[0]) || ((read[0] == '.' || read[0] == '-' || read[0] == '+') && read.size() > 1)))
        fail(since(begin),
             fmt::format("'{}' is no number as TOML writes them: digits on both sides of the point, a unit nowhere", read));
    else fail(read.empty() ? begin : since(begin), "not a TOML value; text stands in double quotes");
    return value;
}

} // namespace skein
