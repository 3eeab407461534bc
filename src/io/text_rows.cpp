#include "io/text_rows.hpp"

#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace skein {

namespace {

constexpr std::size_t buffer_bytes = 1 << 20;

constexpr bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view without_blanks(std::string_view text) {
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

/// Takes the first cell off a line; false where its quotes are wrong. `more`: another cell follows.
bool take_cell(std::string_view& rest, char separator, std::string_view& cell, bool& more) {
    std::size_t start = 0;
    while (start < rest.size() && rest[start] == ' ') ++start;
    if (start == rest.size() || rest[start] != '"') {
        const std::size_t end = std::min(rest.find(separator), rest.size());
        cell = without_blanks(rest.substr(0, end));
        more = end < rest.size();
        rest.remove_prefix(more ? end + 1 : end);
        return true;
    }
    std::size_t close = start + 1;
    for (;; close += 2) { // two quotes stand for one
        close = rest.find('"', close);
        if (close == std::string_view::npos) return false;
        if (close + 1 >= rest.size() || rest[close + 1] != '"') break;
    }
    cell = without_blanks(rest.substr(start + 1, close - start - 1));
    rest.remove_prefix(close + 1);
    while (!rest.empty() && rest.front() != separator && blank(rest.front())) rest.remove_prefix(1);
    more = !rest.empty();
    if (more && rest.front() != separator) return false;
    if (more) rest.remove_prefix(1);
    return true;
}

} // namespace

TextLines::TextLines(const std::string& path, std::int64_t offset, std::int64_t line)
    : path_(path), file_(path, std::ios::binary), buffer_(buffer_bytes) {
    if (!file_) throw InputError(fmt::format("{}: cannot be opened for reading", path_));
    seek(offset, line);
}

void TextLines::seek(std::int64_t offset, std::int64_t line) {
    line_ = line;
    if (offset >= offset_ && offset <= offset_ + static_cast<std::int64_t>(filled_)) {
        at_ = static_cast<std::size_t>(offset - offset_);
        return;
    }
    file_.clear();
    file_.seekg(offset);
    offset_ = offset;
    at_ = filled_ = 0;
}

/// Moves what is left to the front of the buffer and reads behind it; false at the end of the file.
bool TextLines::fill() {
    std::memmove(buffer_.data(), buffer_.data() + at_, filled_ - at_);
    offset_ += static_cast<std::int64_t>(at_);
    filled_ -= at_;
    at_ = 0;
    if (filled_ == buffer_.size())
        throw InputError(fmt::format("{}:{}: the line is longer than 1 MiB: this is no table of text", path_, line_));
    file_.read(buffer_.data() + filled_, static_cast<std::streamsize>(buffer_.size() - filled_));
    if (file_.bad()) throw InputError(fmt::format("{}: cannot be read behind line {}", path_, line_ - 1));
    const auto got = static_cast<std::size_t>(file_.gcount());
    filled_ += got;
    return got > 0;
}

bool TextLines::next(std::string_view& line) {
    const void* end = nullptr;
    while (at_ == filled_ || !(end = std::memchr(buffer_.data() + at_, '\n', filled_ - at_)))
        if (!fill()) {
            if (at_ == filled_) return false;
            break;
        }
    begin_ = offset_ + static_cast<std::int64_t>(at_);
    const char* first = buffer_.data() + at_;
    ended_ = end != nullptr;
    const std::size_t size = ended_ ? static_cast<std::size_t>(static_cast<const char*>(end) - first) : filled_ - at_;
    at_ += size + (ended_ ? 1 : 0);
    line = {first, size};
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (begin_ == 0 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3); // byte order mark of spreadsheets
    ++line_;
    return true;
}

std::string TextLines::place() const { return fmt::format("{}:{}", path_, line()); }

char separator_of(std::string_view names) {
    for (const char separator : {'\t', ';'})
        if (names.find(separator) != std::string_view::npos) return separator;
    return ',';
}

bool split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
    cells.clear();
    bool more = true;
    while (more)
        if (!take_cell(line, separator, cells.emplace_back(), more)) return false;
    return true;
}

std::optional<std::string_view> cell_of(std::string_view line, char separator, std::size_t column) {
    std::string_view cell;
    bool more = true;
    for (std::size_t c = 0; c <= column; ++c)
        if (!more || !take_cell(line, separator, cell, more)) return std::nullopt;
    return cell;
}

std::string shown(std::string_view text) {
    constexpr std::size_t most = 40;
    std::string out(text.substr(0, most));
    for (char& c : out)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
    return text.size() > most ? out + "..." : out;
}

std::string not_a_number(std::string_view cell) {
    if (cell.empty()) return "an empty cell is not a number";
    return fmt::format("'{}' is not a number{}", shown(cell),
                       cell.find(',') != std::string_view::npos ? ": decimals need a point" : "");
}

} // namespace skein
