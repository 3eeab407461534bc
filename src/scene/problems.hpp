// Places in the text of a scene, and a list of its faults.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace skein {

/// A scene file's name and lines, or the text of an override, which has no lines.
struct SourceText {
    std::string name;
    std::vector<std::string> lines;
};

/// Part of one line. `column` and `length` count bytes, `line` and `column` from 1.
struct Place {
    std::shared_ptr<const SourceText> text;
    int line = 0;
    int column = 0;
    int length = 1;

    /// "file:12", or the override's text.
    std::string table_name() const;
};

/// "file:line:column: message" and, below it, the line with carets under the place; "--set path=value: message" for an
/// override.
std::string message_at(const Place& place, const std::string& message);

/// Faults of a scene, gathered so that one run names all.
class Problems {
public:
    void add(const Place& place, const std::string& message);
    bool empty() const { return found_.empty(); }
    std::size_t count() const { return found_.size(); }
    /// Throws InputError with the first ten, in the order of the file, where there are any.
    void raise() const;

private:
    struct Problem {
        Place place;
        std::string message;
    };
    std::vector<Problem> found_;
};

} // namespace skein
