// Entries of containers by signed numbers and enumerators: one conversion, checked in debug builds.
#pragma once

#include <cassert>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <type_traits>
#include <utility>

namespace skein {

template <class I>
concept IndexLike = std::integral<I> || std::is_enum_v<I>;

/// Conversion of a number that is not negative to std::size_t.
template <IndexLike I> constexpr std::size_t to_index(I i) {
    if constexpr (std::signed_integral<I>) assert(i >= 0);
    return static_cast<std::size_t>(i);
}

/// Entry i of a container, a span or an array.
template <class Entries, IndexLike I> constexpr decltype(auto) nth(Entries&& entries, I i) {
    if constexpr (requires { std::size(entries); }) assert(to_index(i) < std::size(entries));
    return std::forward<Entries>(entries)[to_index(i)];
}

} // namespace skein
