#include "io/start_spec.hpp"

#include "skein/core/error.hpp"

#include <charconv>

namespace skein {

void StartSpec::fields(FieldVisitor& f) {
    f.visit({.name = "from",
             .unit = "",
             .text = "run whose state is the initial state: its directory (newest checkpoint) or directory@step; "
                     "relative to this file's folder"},
            from);
    f.choice({.name = "time",
              .unit = "",
              .text = "goes_on: time and steps continue from this state; zero: both begin at zero, and with them all "
                      "functions of time"},
             time, start_time_names);
}

CheckpointName checkpoint_name(const std::string& text) {
    const std::size_t at = text.rfind('@');
    if (at == std::string::npos) return {text, std::nullopt};
    std::int64_t step = 0;
    const char *begin = text.data() + at + 1, *end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(begin, end, step);
    if (at == 0 || begin == end || error != std::errc{} || rest != end || step < 0)
        throw InputError("'" + text +
                         "' names no checkpoint: expected DIRECTORY or DIRECTORY@STEP, e.g. out/first@12800");
    return {text.substr(0, at), step};
}

} // namespace skein
