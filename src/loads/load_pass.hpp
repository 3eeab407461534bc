// A load of the scene as a pass over the tiles of one group. What a load does not define, it does not pay for.
#pragma once

#include "loads/load_spec.hpp"
#include "rod/tile.hpp"

#include <memory>
#include <vector>

namespace skein {

template <class L, int W> class LoadPass final : public TilePass<W> {
public:
    LoadPass(L load, const RodGroup& group) : load_(std::move(load)) {
        if constexpr (requires { load_.bind_group(group); }) load_.bind_group(group);
    }
    std::string_view name() const override { return L::kind; }
    void prepare(std::span<const Step> steps) override {
        if constexpr (requires { load_.prepare(steps); }) load_.prepare(steps);
    }
    void bind(const RodTile<W>& rod) override {
        if constexpr (has_tile_data) tile_data_.push_back(load_.template bind<W>(rod));
    }
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        if constexpr (has_tile_data) load_.add(rod, tile_data_[rod.number], load, step);
        else load_.add(rod, load, step);
    }

private:
    static constexpr bool has_tile_data = requires { typename L::template TileData<W>; };
    struct Nothing {};
    L load_;
    std::vector<decltype([] {
        if constexpr (has_tile_data) return typename L::template TileData<W>{};
        else return Nothing{};
    }())> tile_data_;
};

template <int W> std::unique_ptr<TilePass<W>> make_pass(const Load& load, const RodGroup& group) {
    return std::visit([&](const auto& l) -> std::unique_ptr<TilePass<W>> { return std::make_unique<LoadPass<std::decay_t<decltype(l)>, W>>(l, group); },
                      load);
}

} // namespace skein
