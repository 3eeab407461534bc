// Payne and Hanek's reduction of angles of many turns to an eighth of a turn about 0, in whole numbers. With 1/pi = sum
// b_i 2^-i and x = m 2^e, m whole, bits of weights above 2^-e change x/pi by even numbers. These are whole turns and
// are left out.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace skein::detail {

/// x = k pi/2 + rest with whole k, |rest| at most pi/4.
struct Remainder {
    double rest;
    int quarters; ///< k without whole turns
};

/// 64 zeros, then the first 1216 bits of 1/pi.
inline constexpr std::uint64_t inverse_pi[] = {
    0x0000000000000000, 0x517cc1b727220a94, 0xfe13abe8fa9a6ee0, 0x6db14acc9e21c820, 0xff28b1d5ef5de2b0,
    0xdb92371d2126e970, 0x0324977504e8c90e, 0x7f0ef58e5894d39f, 0x74411afa975da242, 0x74ce38135a2fbf20,
    0x9cc8eb1cc1a99cfa, 0x4e422fc5defc941d, 0x8ffc4bffef02cc07, 0xf79788c5ad05368f, 0xb69b3f6793e584db,
    0xa7a31fb34f2ff516, 0xba93dd63f5f2f8bd, 0x9e839cfbc5294975, 0x35fdafd88fc6ae84, 0x2b0198237e3db5d5};

/// Remainder of x from 2^30 on, within 0.6 units in the last place; not a number where x is infinite.
[[gnu::noinline, gnu::cold]] inline Remainder large_remainder(double x) {
    using Natural = unsigned __int128;
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const int exponent = static_cast<int>(bits >> 52) - 1075;
    if (!(x <= std::numeric_limits<double>::max())) return {std::numeric_limits<double>::quiet_NaN(), 0};
    const std::uint64_t m = (bits & ((std::uint64_t{1} << 52) - 1)) | std::uint64_t{1} << 52;
    // Bits of 1/pi of weights 2^-e to 2^-(e + 191). Their product with x begins at weight 1; the omitted rest is below
    // 2^-138.
    const auto first = static_cast<unsigned>(exponent + 63), word = first / 64, shift = first % 64;
    const auto from = [&](unsigned i) {
        return shift == 0 ? inverse_pi[word + i]
                          : inverse_pi[word + i] << shift | inverse_pi[word + i + 1] >> (64 - shift);
    };
    Natural sum = static_cast<Natural>(m) * from(2);
    const auto low = static_cast<std::uint64_t>(sum);
    sum = (sum >> 64) + static_cast<Natural>(m) * from(1);
    const auto middle = static_cast<std::uint64_t>(sum);
    std::uint64_t high = static_cast<std::uint64_t>(sum >> 64) + m * from(0);
    // Number of quarter turns less the nearest whole number: from -1/2 to 1/2, in units of 2^-192.
    const int quarters = static_cast<int>((high >> 61) + 1) >> 1 & 3;
    std::uint64_t a = high << 2 | middle >> 62, b = middle << 2 | low >> 62, c = low << 2;
    const bool negative = a >> 63 != 0;
    if (negative) {
        c = -c;
        b = ~b + (c == 0);
        a = ~a + (c == 0 && b == 0);
    }
    unsigned zeros = 0;
    if (a == 0) {
        a = b;
        b = c;
        c = 0;
        zeros = 64;
    }
    if (const auto more = static_cast<unsigned>(std::countl_zero(a)); more > 0) {
        a = a << more | b >> (64 - more);
        b = b << more | c >> (64 - more);
        zeros += more;
    }
    const double scale = std::bit_cast<double>(std::uint64_t{1023 - zeros} << 52) * (negative ? -1 : 1);
    const double share = scale * 0x1p-64 * static_cast<double>(a & ~std::uint64_t{0x7ff});
    const double less = scale * 0x1p-117 * static_cast<double>((a & 0x7ff) << 53 | b >> 11);
    constexpr double quarter = 0x1.921fb54442d18p+0, quarter_low = 0x1.1a62633145c07p-54; // a quarter turn in two parts
    const double rest = share * quarter;
    return {rest + (std::fma(share, quarter, -rest) + (share * quarter_low + less * quarter)), quarters};
}

} // namespace skein::detail
