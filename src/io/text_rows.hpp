// Rows of cells of a large text file, read through a buffer: comma, semicolon or tab between cells, quotes around them.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Lines of a file from a given offset. Throws InputError for a file that cannot be read, and for a line that is longer
/// than any of a table.
class TextLines {
public:
    /// Begins at line `line`, counted from 1, which lies at `offset`.
    explicit TextLines(const std::string& path, std::int64_t offset = 0, std::int64_t line = 1);

    /// The next line without its end, valid until the call after; false at the end of the file.
    bool next(std::string_view& line);
    void seek(std::int64_t offset, std::int64_t line);

    std::int64_t line() const { return line_ - 1; } ///< number of the last line
    std::int64_t offset() const { return begin_; }  ///< where it begins
    bool ended() const { return ended_; }           ///< true if it had an end of line
    /// "file:line", for messages.
    std::string place() const;

private:
    bool fill();

    std::string path_;
    std::ifstream file_;
    std::vector<char> buffer_;
    std::size_t at_ = 0, filled_ = 0;
    std::int64_t offset_ = 0; ///< of the buffer's first byte
    std::int64_t begin_ = 0, line_ = 1;
    bool ended_ = false;
};

/// The separator of a line of names: a tab, a semicolon or a comma, whichever it has first in this order.
char separator_of(std::string_view names);

/// Splits a line into cells without blanks and quotes around them. False where a quote is not closed, or has text
/// behind it.
bool split(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// Finds one cell of a line without looking at those behind it.
std::optional<std::string_view> cell_of(std::string_view line, char separator, std::size_t column);

/// Text of a file as a message shows it: at most 40 characters, and no control characters.
std::string shown(std::string_view text);

/// Fault of a cell that is no number.
std::string not_a_number(std::string_view cell);

} // namespace skein
