#include "tiles/rods.hpp"

namespace skein {

std::uint64_t hash_rod(std::int64_t gid, std::span<const Slot<1>> state) {
    return hash_numbers(gid, {reinterpret_cast<const double*>(state.data()), state.size() * slot_doubles});
}

} // namespace skein
