#include "loads/load_list.hpp"

#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"

#include <array>

namespace skein {

namespace {

template <class> struct Table;
template <class... L> struct Table<LoadTypes<L...>> {
    static constexpr std::array<std::string_view, sizeof...(L)> kinds = {L::kind...};
    static constexpr std::array<Load (*)(), sizeof...(L)> make = {[] { return Load(L{}); }...};
};
using All = Table<LoadList>;

/// Loads must differ in their names.
static_assert(
    [] {
        for (std::size_t i = 0; i < All::kinds.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (All::kinds[i] == All::kinds[j]) return false;
        return true;
    }(),
    "two loads have one `kind`");

} // namespace

std::span<const std::string_view> load_kinds() { return All::kinds; }

Load make_load(int number) { return All::make.at(to_index(number))(); }

Load::Load() : Load(make_load(0)) {}

} // namespace skein
