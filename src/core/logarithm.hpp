// Logarithms over packs: ln(x) for slender bodies, theory.md (38), and x - ln(1 + x) for the axial energy of a rod
// whose section shrinks as it stretches, theory.md (11).
#pragma once

#include "skein/core/pack.hpp"

namespace skein {

namespace detail {
// Series with s = x/(2 + x): x - ln(1 + x) = s (x - 2 s^2 (1/3 + s^2/5 + s^4/7 + ...)), where nothing cancels. First
// omitted term 0.03^10/23 = 3e-17.
inline constexpr double inverse_odd[] = {1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9,  1.0 / 11,
                                         1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21};
inline constexpr double small_log_argument = 0.03; // bound of s^2; x from -0.295 to 0.419

template <int W>
[[gnu::noinline, gnu::cold]] void less_log_rarely(const Pack<W>& x, const Pack<W>& squared, Pack<W>& r) {
    for (int i = 0; i < W; ++i)
        if (!(squared[i] <= small_log_argument)) r.set(i, x[i] - std::log1p(x[i]));
}
} // namespace detail

/// x - ln(1 + x) with a relative error below 1e-15 for any x > -1; not a number below.
template <int W> SKEIN_INLINE Pack<W> less_log(const Pack<W>& x) {
    using P = Pack<W>;
    const P s = x / (P(2.0) + x), squared = s * s;
    P r = s * fnma(squared + squared, polynomial(squared, detail::inverse_odd), x);
    if (any(!(squared <= P(detail::small_log_argument)))) [[unlikely]]
        detail::less_log_rarely(x, squared, r);
    return r;
}

/// ln(x) with a relative error below 5e-16; x positive, finite and normal.
template <int W> SKEIN_INLINE Pack<W> log(const Pack<W>& x) {
    using P = Pack<W>;
    const auto [m, k] = split(x);
    const P s = (m - P(1.0)) / (m + P(1.0)), squared = s * s; // up to 0.0295
    const P of_m = fma(squared + squared, s * polynomial(squared, detail::inverse_odd), s + s);
    constexpr double high = 0x1.62e42fefa38p-1,
                     low = 0x1.ef35793c7673p-45; // second part of ln(2); whole multiples of `high` are exact
    return fma(k, P(high), fma(k, P(low), of_m));
}

} // namespace skein
