// Hashes of the numbers of a rod. A digest of states is their sum, in any order.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace skein {

namespace detail {
inline constexpr std::uint64_t hash_prime = 0x9e3779b97f4a7c15ull;
/// Finaliser of splitmix64: every input bit reaches every output bit.
inline std::uint64_t hash_mixed(std::uint64_t h) {
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
    return h ^ (h >> 31);
}
} // namespace detail

/// Hash of numbers of one rod (FNV-like over 64-bit words, finalised): beginning, a step for each number, end.
inline std::uint64_t hash_begin(std::int64_t gid) {
    return detail::hash_mixed(static_cast<std::uint64_t>(gid) + detail::hash_prime);
}
inline std::uint64_t hash_with(std::uint64_t h, double x) {
    return std::rotl((h ^ std::bit_cast<std::uint64_t>(x)) * detail::hash_prime, 27);
}
inline std::uint64_t hash_end(std::uint64_t h) { return detail::hash_mixed(h); }

/// Hash of a whole record.
std::uint64_t hash_numbers(std::int64_t gid, std::span<const double> numbers);
/// Sum of the hashes of rods with rising numbers from first_gid on, `per_rod` numbers each.
std::uint64_t sum_of_hashes(std::int64_t first_gid, std::span<const double> numbers, std::size_t per_rod);

} // namespace skein
