// Passes of all loads of the list.
#pragma once

#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"

namespace skein {

namespace detail {

template <int W, class Map, class... L>
std::unique_ptr<TilePass<W>> make_pass_of(LoadTypes<L...>, const Load& load, const RodGroup& group) {
    std::unique_ptr<TilePass<W>> pass;
    const auto make = [&]<class One>(const One* one) {
        if (!one) return false;
        if constexpr (!Map::along || !needs_whole_rods<One>)
            pass = std::make_unique<LoadPass<One, W, Map>>(*one, group);
        return true;
    };
    static_cast<void>((make(load.get_if<L>()) || ...));
    return pass;
}

} // namespace detail

template <int W, class Map> std::unique_ptr<TilePass<W>> make_pass(const Load& load, const RodGroup& group) {
    return detail::make_pass_of<W, Map>(LoadList{}, load, group);
}

} // namespace skein
