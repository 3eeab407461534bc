#include "rod/rods.hpp"

#include "rod/drift.hpp"
#include "rod/rigid.hpp"
#include "rod/top.hpp"

#include <bit>

namespace skein {

std::uint64_t hash_numbers(std::int64_t gid, std::span<const double> numbers) {
    constexpr std::uint64_t prime = 0x9e3779b97f4a7c15ull;
    const auto mix = [](std::uint64_t h) { // finaliser of splitmix64: every input bit reaches every output bit
        h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
        h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
        return h ^ (h >> 31);
    };
    std::uint64_t h = mix(static_cast<std::uint64_t>(gid) + prime);
    for (const double x : numbers) h = std::rotl((h ^ std::bit_cast<std::uint64_t>(x)) * prime, 27);
    return mix(h);
}

std::uint64_t hash_rod(std::int64_t gid, std::span<const Slot<1>> state) {
    return hash_numbers(gid, {reinterpret_cast<const double*>(state.data()), state.size() * slot_doubles});
}

void synchronise_positions(const RodGroup& group, std::span<Slot<1>> state, double h) {
    if (is_rigid(group)) return rigid_drift(tile_of(group, state), h);
    for (Slot<1>& slot : state) slot.position = fma(Pack<1>(h), slot.velocity, slot.position);
    if (group.closed()) close_ring(tile_of(group, state));
}

void synchronise(const RodGroup& group, std::span<Slot<1>> state, double h) {
    const RodTile<1> rod = tile_of(group, state);
    if (is_rigid(group)) return rigid_drift(rod, h);
    with_top(group, [&]<class Top>(Top) { drift<Top>(rod, h); });
    if (group.closed()) close_ring(rod);
}

} // namespace skein
