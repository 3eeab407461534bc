#include "skein/core/objections.hpp"

#include <charconv>

namespace skein {

void Objections::unused(std::initializer_list<std::string_view> keys, const std::string& where) {
    for (const std::string_view key : keys)
        if (given(key)) add(key, "'" + std::string(key) + "' has no use " + where);
}

void Objections::length(std::string_view key, std::size_t has, long needs, const std::string& why) {
    if (static_cast<long>(has) == needs) return;
    add(key, "'" + std::string(key) + "' has " + std::to_string(has) + " value" + (has == 1 ? "" : "s") +
                 ", but needs " + std::to_string(needs) + ": " + why);
}

std::string number_text(double x) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, x).ptr};
}

} // namespace skein
