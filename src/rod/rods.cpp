#include "rod/rods.hpp"

#include "rod/figures.hpp"
#include "rod/rod_profile.hpp"
#include "rod/synchronise.hpp"

namespace skein {

std::uint64_t hash_numbers(std::int64_t gid, std::span<const double> numbers) {
    std::uint64_t h = hash_begin(gid);
    for (const double x : numbers) h = hash_with(h, x);
    return hash_end(h);
}

std::uint64_t hash_rod(std::int64_t gid, std::span<const Slot<1>> state) {
    return hash_numbers(gid, {reinterpret_cast<const double*>(state.data()), state.size() * slot_doubles});
}

std::uint64_t sum_of_hashes(std::int64_t first_gid, std::span<const double> numbers, std::size_t per_rod) {
    constexpr std::size_t together = 4; // chains of multiplications under way at once
    const std::size_t rods = numbers.size() / per_rod;
    const auto gid = [first_gid](std::size_t rod) { return first_gid + static_cast<std::int64_t>(rod); };
    std::uint64_t sum = 0;
    std::size_t rod = 0;
    for (; rod + together <= rods; rod += together) {
        const double* x = numbers.data() + rod * per_rod;
        std::uint64_t a = hash_begin(gid(rod)), b = hash_begin(gid(rod + 1)), c = hash_begin(gid(rod + 2)),
                      d = hash_begin(gid(rod + 3));
        for (std::size_t i = 0; i < per_rod; ++i) {
            a = hash_with(a, x[i]);
            b = hash_with(b, x[i + per_rod]);
            c = hash_with(c, x[i + 2 * per_rod]);
            d = hash_with(d, x[i + 3 * per_rod]);
        }
        sum += hash_end(a) + hash_end(b) + hash_end(c) + hash_end(d);
    }
    for (; rod < rods; ++rod) sum += hash_numbers(gid(rod), numbers.subspan(rod * per_rod, per_rod));
    return sum;
}

void synchronise_positions(const RodGroup& group, std::span<Slot<1>> state, double h) {
    synchronise_positions(tile_of(group, state), h);
}

void synchronise(const RodGroup& group, std::span<Slot<1>> state, double h) { synchronise(tile_of(group, state), h); }

RodFigures figures_of(const RodGroup& group, std::span<const Slot<1>> state, double time, std::int64_t index) {
    std::vector<Slot<1>> copy(state.begin(), state.end()); // a tile may be written to, and this one is not
    RodFigures figures;
    put_figures(figures_of(tile_of(group, copy, index), time), std::span(&figures, 1));
    return figures;
}

void rod_profile(const RodGroup& group, std::span<const Slot<1>> state, double time, std::span<NodeProfile> out,
                 std::int64_t index) {
    std::vector<Slot<1>> copy(state.begin(), state.end());
    std::vector<NodeProfileOf<Pack<1>>> profile(state.size());
    rod_profile(tile_of(group, copy, index), time, profile.data());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = {profile[i].strain[0], profile[i].curvature[0], profile[i].energy[0]};
}

} // namespace skein
