// A load of the scene as a pass over the tiles of one group. What a load does not define, it does not pay for.
#pragma once

#include "skein/loads/load.hpp"
#include "skein/rod/mapping.hpp"

#include <memory>
#include <vector>

namespace skein {

template <class L, int W, class Map = Across<W>> class LoadPass final : public TilePass<W> {
public:
    LoadPass(L load, const RodGroup& group) : load_(std::move(load)) {
        static_assert(
            keeps_tables_of_group<L> || !requires { &L::bind_group; }, "bind_group(const RodGroup&)");
        if constexpr (keeps_tables_of_group<L>) load_.bind_group(group);
    }
    std::string_view name() const override { return L::kind; }
    void prepare(std::span<const Step> steps) override {
        constexpr bool fits = requires { load_.prepare(steps); };
        static_assert(
            fits || !requires { &L::prepare; }, "prepare(std::span<const Step>)");
        if constexpr (fits) load_.prepare(steps);
    }
    void expect(std::size_t tiles) override {
        if constexpr (binds) tile_data_.resize(tiles);
    }
    void bind(const RodTile<W>& rod) override {
        if constexpr (binds) {
            if (rod.number >= tile_data_.size()) tile_data_.resize(rod.number + 1); // of a pass that stands alone
            tile_data_[rod.number] = load_.template bind<W>(rod);
        }
    }
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        const auto add = [&](const auto&... data) {
            if constexpr (Map::along) load_.template add<W, Map>(rod, data..., load, step);
            else load_.add(rod, data..., load, step);
        };
        if constexpr (binds) add(tile_data_[rod.number]);
        else if constexpr (has_tile_data) add(typename L::template TileData<W>{});
        else add();
    }

private:
    static constexpr bool has_tile_data = requires { typename L::template TileData<W>; };
    static constexpr bool binds = has_tile_data && (Map::along || !requires { requires L::data_along_only; });
    struct Nothing {};
    L load_;
    std::vector<decltype([] {
        if constexpr (binds) return typename L::template TileData<W>{};
        else return Nothing{};
    }())>
        tile_data_;
};

/// Null for a load whose rods lie across, where Map is along. `group`: of an along mapping any of its family; a load that keeps
/// tables of its group makes families of one. Defined in loads/load_passes.hpp.
template <int W, class Map = Across<W>> std::unique_ptr<TilePass<W>> make_pass(const Load& load, const RodGroup& group);

} // namespace skein
