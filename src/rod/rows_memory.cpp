#include "rod/rows_memory.hpp"

#include "core/memory.hpp"
#include "core/share_text.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

namespace skein {

void require_memory_of_rows(const RodGroup& group, std::int64_t rows) {
    constexpr double little = 1 << 20; // bytes below which no check is worth its time
    const double needed = static_cast<double>(rows) * static_cast<double>(group.places().record_bytes());
    if (needed < little) return;
    const double there = free_memory();
    if (!(needed > there)) return;
    const RodSpec& spec = group.spec();
    throw InputError(fmt::format("{}: file '{}': {} rods (rows) of '{}' need {} of memory, and {} are free here",
                                 spec.source, spec.placement.file, rows, spec.name, bytes_text(needed),
                                 bytes_text(there)));
}

} // namespace skein
