#include "rod/body_name.hpp"

#include <fmt/format.h>

namespace skein {

std::string name_of_body(std::span<const RodGroup> groups, std::int64_t gid) {
    for (const RodGroup& group : groups)
        if (gid < group.first_gid() + group.count())
            return fmt::format("{} {} of '{}'", group.strained() ? "rod" : "body", gid - group.first_gid(),
                               group.name());
    return {};
}

} // namespace skein
