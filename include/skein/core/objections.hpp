// Objections of a spec struct's check() to its numbers: contradictions that no single key shows. The receiver knows the
// lines of the scene; structs do not.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>

namespace skein {

class Objections {
public:
    virtual ~Objections() = default;

    /// Adds an objection to a key of the struct's own table, or to no single key where it is empty.
    virtual void add(std::string_view key, const std::string& message) = 0;
    /// Adds an objection to part of a key's text, in bytes; a length of 0 stands for all of it.
    virtual void add_within(std::string_view key, [[maybe_unused]] std::size_t begin,
                            [[maybe_unused]] std::size_t length, const std::string& message) {
        add(key, message);
    }
    /// True where the scene sets the key, be it to its default.
    virtual bool given(std::string_view key) const = 0;

    /// Objects to keys that are set and have no use; `where`, e.g. "without 'hold' [s]".
    void unused(std::initializer_list<std::string_view> keys, const std::string& where);
    /// Objects to a list of wrong length; `why`, e.g. "one for each of the elements".
    void length(std::string_view key, std::size_t has, long needs, const std::string& why);
};

/// Shortest text that is read back as the same number.
std::string number_text(double x);

} // namespace skein
