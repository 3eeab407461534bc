// A load of the scene as a pass over the tiles of one group. Members that a load does not define cost nothing.
#pragma once

#include "skein/loads/load.hpp"
#include "skein/tiles/mapping.hpp"
#include "tiles/end_moments.hpp"

#include <memory>
#include <type_traits>
#include <vector>

namespace skein {

namespace detail {

// Optional members by name, whatever their signature.
template <class L> inline constexpr bool names_bind_group = requires { &L::bind_group; };
template <class L> inline constexpr bool names_prepare = requires { &L::prepare; };

template <class L> inline constexpr bool data_along_only = requires { requires L::data_along_only; };
/// Data that the pass keeps for a tile, where the load binds to it.
struct Nothing {};
template <class L, int W, bool binds> struct KeptOfTile { using Type = Nothing; };
template <class L, int W> struct KeptOfTile<L, W, true> { using Type = typename L::template TileData<W>; };

/// Base of a load without moments at ends of rods.
template <int W> struct NoEndMoments {};
template <class L, int W>
concept MakesMoments = requires(const L l, const RodTile<W>& t, const Step& s, EndMoments<W>& m) {
    l.template add_end_moments<W>(t, s, m);
}
|| requires(const L l, const RodTile<W>& t, const typename L::template TileData<W>& data, const Step& s,
            EndMoments<W>& m) {
    l.template add_end_moments<W>(t, data, s, m);
};
/// Base of a pass of L over rods across, which joined rods are.
template <class L, int W, class Map> using EndMomentsOf =
    std::conditional_t<MakesMoments<L, W> && !Map::along, MakesEndMoments<W>, NoEndMoments<W>>;

/// Base of a load with moments at ends of rods.
template <class Pass, class L, int W, class Base> class WithEndMoments : public Base {};
template <class Pass, class L, int W> class WithEndMoments<Pass, L, W, MakesEndMoments<W>> : public MakesEndMoments<W> {
public:
    void add_end_moments(const RodTile<W>& rod, const Step& step, EndMoments<W>& moments) const override {
        static_cast<const Pass*>(this)->of_ends(rod, step, moments);
    }
};

} // namespace detail

template <class L, int W, class Map = Across<W>> class LoadPass final
    : public TilePass<W>,
      public detail::WithEndMoments<LoadPass<L, W, Map>, L, W, detail::EndMomentsOf<L, W, Map>> {
public:
    LoadPass(L load, const RodGroup& group) : load_(std::move(load)) {
        static_assert(keeps_tables_of_group<L> || !detail::names_bind_group<L>, "bind_group(const RodGroup&)");
        if constexpr (keeps_tables_of_group<L>) load_.bind_group(group);
    }
    void prepare(std::span<const Step> steps) override {
        constexpr bool fits = requires { load_.prepare(steps); };
        static_assert(fits || !detail::names_prepare<L>, "prepare(std::span<const Step>)");
        if constexpr (fits) load_.prepare(steps);
    }
    void expect(std::size_t tiles) override {
        if constexpr (binds) tile_data_.resize(tiles);
    }
    void bind(const RodTile<W>& rod) override {
        if constexpr (binds) {
            // a pass without expect() stands alone
            if (rod.number >= tile_data_.size()) tile_data_.resize(rod.number + 1);
            tile_data_[rod.number] = load_.template bind<W>(rod);
        }
    }
    void renew(const RodTile<W>& rod) override {
        if constexpr (binds && requires { load_.has_tables_of_places(); }) {
            if (!load_.has_tables_of_places()) return;
            auto& data = tile_data_[rod.number];
            if constexpr (requires { load_.renew(rod, data); }) load_.renew(rod, data);
            else data = load_.template bind<W>(rod);
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

    /// Adds the end moments of muscles.
    void of_ends(const RodTile<W>& rod, const Step& step, EndMoments<W>& moments) const {
        if constexpr (binds) load_.template add_end_moments<W>(rod, tile_data_[rod.number], step, moments);
        else load_.template add_end_moments<W>(rod, step, moments);
    }

private:
    static constexpr bool has_tile_data = detail::has_tile_data<L>;
    static constexpr bool binds = has_tile_data && (Map::along || !detail::data_along_only<L>);
    L load_;
    std::vector<typename detail::KeptOfTile<L, W, binds>::Type> tile_data_;
};

/// Pass of a load; null for a load whose rods lie across, where Map is along. `group` may be any of its family in a
/// mapping along; a load with tables of its group makes families of one. Defined in loads/load_passes.hpp.
template <int W, class Map = Across<W>> std::unique_ptr<TilePass<W>> make_pass(const Load& load, const RodGroup& group);

} // namespace skein
