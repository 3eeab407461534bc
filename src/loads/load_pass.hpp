// A load of the scene as a pass over the tiles of one group. What a load does not define, it does not pay for.
#pragma once

#include "loads/load_spec.hpp"
#include "rod/mapping.hpp"

#include <memory>
#include <vector>

namespace skein {

template <class L, int W, class Map = Across<W>> class LoadPass final : public TilePass<W> {
public:
    LoadPass(L load, const RodGroup& group) : load_(std::move(load)) {
        if constexpr (requires { load_.bind_group(group); }) load_.bind_group(group);
    }
    std::string_view name() const override { return L::kind; }
    void prepare(std::span<const Step> steps) override {
        if constexpr (requires { load_.prepare(steps); }) load_.prepare(steps);
    }
    void expect(std::size_t tiles) override {
        if constexpr (has_tile_data) tile_data_.resize(tiles);
    }
    void bind(const RodTile<W>& rod) override {
        if constexpr (has_tile_data) {
            if (rod.number >= tile_data_.size()) tile_data_.resize(rod.number + 1); // of a pass that stands alone
            tile_data_[rod.number] = load_.template bind<W>(rod);
        }
    }
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        const auto add = [&](const auto&... data) {
            if constexpr (Map::along) load_.template add<W, Map>(rod, data..., load, step);
            else load_.add(rod, data..., load, step);
        };
        if constexpr (has_tile_data) add(tile_data_[rod.number]);
        else add();
    }

private:
    static constexpr bool has_tile_data = requires { typename L::template TileData<W>; };
    struct Nothing {};
    L load_;
    std::vector<decltype([] {
        if constexpr (has_tile_data) return typename L::template TileData<W>{};
        else return Nothing{};
    }())>
        tile_data_;
};

/// `group`: of an along mapping any of its family; a load that keeps tables of its group makes families of one.
template <int W, class Map = Across<W>> std::unique_ptr<TilePass<W>> make_pass(const Load& load, const RodGroup& group) {
    return std::visit(
        [&]<class L>(const L& l) -> std::unique_ptr<TilePass<W>> {
            if constexpr (Map::along && needs_whole_rods<L>) return nullptr; // the plan keeps its rods across
            else return std::make_unique<LoadPass<L, W, Map>>(l, group);
        },
        load);
}

} // namespace skein
