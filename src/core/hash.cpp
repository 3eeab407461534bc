#include "core/hash.hpp"

namespace skein {

std::uint64_t hash_numbers(std::int64_t gid, std::span<const double> numbers) {
    std::uint64_t h = hash_begin(gid);
    for (const double x : numbers) h = hash_with(h, x);
    return hash_end(h);
}

std::uint64_t sum_of_hashes(std::int64_t first_gid, std::span<const double> numbers, std::size_t per_rod) {
    constexpr std::size_t together = 4; // chains of multiplications in flight at once
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

} // namespace skein
