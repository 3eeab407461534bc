// The candidates of a block that touch, left-packed for the stages that follow.                  theory.md section 18
//
//   eight candidates     a b c d e f g h
//   closest points       squared distance d^2 of both axes, theory.md (52)
//   prune                a b . d e f . h    d < r1 + r2 + margin by the paces of both, kept in the pruned list
//   touch                . b . d . . . h    d < r1 + r2, in beds and a zone, stored in the columns of the work area
//   ended                . . . . e . . .    touched in the step before and no longer
//   deep                 . . . d . . . .    d < (r1 + r2)/2, watched by side_changes.cpp
//   near-parallel        . b . . . . . .    sine of the angle below `blend`
//   vertex rule          . . . d . . . h    d^2 + x^2 sin^2 < (r1 + r2)^2, x from the nearest point to the vertex
#include "contact/capsule_tiles.hpp"
#include "contact/work_area.hpp"
#include "core/closest_points.hpp"
#include "skein/core/index.hpp"

#include <bit>
#include <cassert>
#include <cstring>

namespace skein {

/// One pass over the candidates of a block: over all of the list when pruning, over the pruned list otherwise. The
/// arrays are pointers of their own, as stores could change members for all that the compiler knows.
template <bool prune> class Contacts::TouchingScan {
public:
    TouchingScan(const Contacts& contacts, const PrunedList::Part& pruned, std::uint32_t begin,
                 std::uint32_t candidates, WorkArea& area)
        : begin_(begin), candidates_(candidates), pair_(prune ? &contacts.list_.pair[begin] : pruned.pair),
          vertices_(prune ? &contacts.list_.vertices[begin] : pruned.vertices), status_(contacts.status_.data()),
          has_box_(contacts.has_box_.empty() ? nullptr : &contacts.has_box_[begin]),
          memory_(contacts.remembers_ ? contacts.memory_.data() : nullptr),
          paces_(prune ? &contacts.list_.paces[begin] : nullptr), half_margin_(0.5 * contacts.margin_),
          zone_(contacts.scene_.meeting_zone), pruned_(pruned), area_(area), index_(area.index.data()),
          near_parallel_(area.near_parallel.data()), touching_pair_(area.pair.data()),
          near_one_(area.near_one.columns()), near_two_(area.near_two.columns()) {
        for (int i = 0; i < A::numbers; ++i) number_[i] = area.number[i].data();
    }

    SKEIN_INLINE void add(std::size_t k, const CapsuleTile& capsules, const ExposedMotion* motion) {
        assert(k < candidates_ && touching_ + W <= area_.pair.size());
        Tile tile;
        find_closest(tile, k, capsules);
        if constexpr (prune) keep_within_margin(k, tile);
        if (tile.touch != 0) append(area_.deep, k, bits_of(tile.squared < P(0.25) * tile.within_reach) & tile.touch);
        append(area_.ended, k, tile.before & ~tile.touch);
        if (tile.touch == 0) return;
        begins_ |= tile.touch & ~tile.before;
        store_nearest_points(tile, capsules);
        const P squared_1 = dot(capsules.d1, capsules.d1), squared_2 = dot(capsules.d2, capsules.d2);
        store_near_parallel(tile, squared_1, squared_2);
        store_near_vertices(k, tile, squared_1, squared_2);
        store_pairs(k, tile);
        prefetch(k, motion);
        touching_ += static_cast<std::uint32_t>(std::popcount(tile.touch));
    }

    /// Hands the counts to the work area and to the pruned list.
    void finish() {
        if (prune) {
            pruned_.count = within_;
            PrunedList::pad(pruned_);
        }
        area_.count = touching_;
        area_.near_parallel_count = near_parallels_;
        area_.near_one.count = ones_;
        area_.near_two.count = twos_;
        area_.begins = begins_ != 0;
    }

private:
    using A = WorkArea;
    static constexpr int W = CapsuleTile::width;
    using P = Pack<W>;
    static_assert(A::W == W);

    /// Closest points of eight candidates, and candidates as bits.
    struct Tile {
        ClosestPoints<P> closest;
        P reach, within_reach, squared; ///< sum of radii and zone, m, its square and the squared distance, m^2
        unsigned valid, before, touch;  ///< in the list, touching in the step before, touching now
    };

    /// Number of candidate k of the scan in the list.
    SKEIN_INLINE std::uint32_t candidate(std::size_t k) const {
        if constexpr (prune) return begin_ + static_cast<std::uint32_t>(k);
        else return pruned_.candidate[k];
    }

    SKEIN_INLINE void find_closest(Tile& tile, std::size_t k, const CapsuleTile& capsules) const {
        tile.closest = closest_points(capsules.p, capsules.d1, capsules.q, capsules.d2);
        tile.squared = dot(tile.closest.apart, tile.closest.apart);
        tile.reach = capsules.radius_1 + capsules.radius_2 + zone_;
        tile.within_reach = tile.reach * tile.reach;
        tile.valid = valid_of(k);
        tile.before = before(k, tile.valid);
        tile.touch = bits_of(tile.squared < tile.within_reach) & tile.valid;
    }

    /// Candidates up to the end of the list; push_boxes() evaluates those with boxes.
    SKEIN_INLINE unsigned valid_of(std::size_t k) const {
        const std::uint32_t left = candidates_ - static_cast<std::uint32_t>(k);
        const unsigned listed = left >= W ? 0xffu : (1u << left) - 1;
        return prune && has_box_ ? listed & ~bits_of_bytes(has_box_ + k) : listed;
    }

    SKEIN_INLINE unsigned before(std::size_t k, unsigned valid) const {
        if constexpr (prune) return bits_of_bytes(status_ + begin_ + k) & valid;
        unsigned bits = 0;
        for (std::size_t l = 0; l < W; ++l) bits |= static_cast<unsigned>(status_[candidate(k + l)] & touching) << l;
        return bits & valid;
    }

    SKEIN_INLINE void keep_within_margin(std::size_t k, const Tile& tile) {
        P paces;
        std::memcpy(&paces, paces_ + k, sizeof paces);
        const P wide = tile.reach + half_margin_ * paces;
        const unsigned some = bits_of(tile.squared < wide * wide) & tile.valid;
        store_places(pruned_.candidate + within_, some, candidate(k));
        compress_store(pruned_.pair + within_, some, pair_ + k);
        compress_store(pruned_.vertices + within_, some, vertices_ + k);
        within_ += static_cast<std::uint32_t>(std::popcount(some));
    }

    SKEIN_INLINE void append(std::vector<std::uint32_t>& numbers, std::size_t k, unsigned bits) const {
        for (; bits != 0; bits &= bits - 1) numbers.push_back(candidate(k + to_index(std::countr_zero(bits))));
    }

    SKEIN_INLINE void store(typename A::Number which, const Tile& tile, const P& value) const {
        compress_store(number_[which] + touching_, tile.touch, value);
    }
    SKEIN_INLINE void store_nearest_points(const Tile& tile, const CapsuleTile& capsules) const {
        store(A::s, tile, tile.closest.s);
        store(A::t, tile, tile.closest.t);
        store(A::squared, tile, tile.squared);
        store(A::x, tile, tile.closest.apart.x);
        store(A::y, tile, tile.closest.apart.y);
        store(A::z, tile, tile.closest.apart.z);
        store(A::sine_squared, tile, tile.closest.sine_squared);
        store(A::radius_1, tile, capsules.radius_1);
        store(A::radius_2, tile, capsules.radius_2);
    }

    SKEIN_INLINE void store_near_parallel(const Tile& tile, const P& squared_1, const P& squared_2) {
        const auto both_long = min(squared_1, squared_2) > P(0.0);
        const unsigned parallel = bits_of((tile.closest.sine_squared < P(blend * blend)) & both_long) & tile.touch;
        store_places(near_parallel_ + near_parallels_, bits_among(parallel, tile.touch), touching_);
        near_parallels_ += static_cast<std::uint32_t>(std::popcount(parallel));
    }

    /// Vertices that may touch: along an edge the squared distance rises by at least x^2 sin^2 from its least.
    SKEIN_INLINE void store_near_vertices(std::size_t k, const Tile& tile, const P& squared_1, const P& squared_2) {
        const auto& [s, t, apart, sine_squared, first, last] = tile.closest;
        const P left_over = tile.within_reach - tile.squared, rest_1 = P(1.0) - s, rest_2 = P(1.0) - t,
                rise_1 = sine_squared * squared_1, rise_2 = sine_squared * squared_2;
        const auto vertex = [&](int which) { return bits_of_bytes(vertices_ + k, which); };
        const unsigned near[4] = {bits_of(s * s * rise_1 < left_over) & vertex(0),
                                  bits_of(rest_1 * rest_1 * rise_1 < left_over) & vertex(1),
                                  bits_of(t * t * rise_2 < left_over) & vertex(2),
                                  bits_of(rest_2 * rest_2 * rise_2 < left_over) & vertex(3)},
                       near_1 = near[0] | near[1], near_2 = near[2] | near[3];
        const std::uint64_t bytes = bytes_of_bits(near[0]) | bytes_of_bits(near[1]) << 1 | bytes_of_bits(near[2]) << 2 |
                                    bytes_of_bits(near[3]) << 3;
        store_near(tile, (near_1 ^ near_2) & tile.touch, bytes, near_one_, ones_);
        store_near(tile, near_1 & near_2 & tile.touch, bytes, near_two_, twos_);
    }
    SKEIN_INLINE void store_near(const Tile& tile, unsigned bits, const std::uint64_t& vertices,
                                 const typename A::NearColumns& to, std::uint32_t& count) const {
        store_places(to.which + count, bits_among(bits, tile.touch), touching_);
        compress_store(to.vertices + count, bits, reinterpret_cast<const std::uint8_t*>(&vertices));
        count += static_cast<std::uint32_t>(std::popcount(bits));
    }

    SKEIN_INLINE void store_pairs(std::size_t k, const Tile& tile) const {
        if constexpr (prune) store_places(index_ + touching_, tile.touch, candidate(k));
        else compress_store(index_ + touching_, tile.touch, pruned_.candidate + k);
        compress_store(touching_pair_ + touching_, tile.touch, pair_ + k);
    }

    SKEIN_INLINE void prefetch(std::size_t k, const ExposedMotion* motion) const {
        for (std::size_t l = 0; l < W; ++l) {
            __builtin_prefetch(&motion[pair_[k + l].b]);
            __builtin_prefetch(&motion[pair_[k + l].b + 1]);
            if (memory_) __builtin_prefetch(&memory_[candidate(k + l)], 1);
        }
    }

    const std::uint32_t begin_, candidates_;
    const Pair* const pair_;
    const std::uint8_t *const vertices_, *const status_, *const has_box_;
    const ContactMemory<double>* const memory_;
    const double* const paces_;
    const P half_margin_, zone_; ///< m
    const PrunedList::Part pruned_;
    WorkArea& area_;
    double* number_[A::numbers];
    std::uint32_t *const index_, *const near_parallel_;
    Pair* const touching_pair_;
    const typename A::NearColumns near_one_, near_two_;
    std::uint32_t touching_ = 0, near_parallels_ = 0, ones_ = 0, twos_ = 0, within_ = 0;
    unsigned begins_ = 0;
};

template <bool prune> void Contacts::find_touching(const Work& work, WorkArea& area) {
    const std::uint32_t begin = list_.first[work.block.first_slot], end = list_.first[work.block.last_slot];
    const PrunedList::Part pruned = pruned_.of(work.number, begin);
    const std::uint32_t count = prune ? end - begin : pruned.count;
    area.clear(count);
    const Pair* const pair = prune ? &list_.pair[begin] : pruned.pair;
    const ExposedNode* const node = work.bodies.node.data();
    const ExposedMotion* const motion = work.bodies.motion.data();
    TouchingScan<prune> scan(*this, pruned, begin, count, area);
    for_capsule_tiles(
        count, [&](std::size_t k) { return std::pair(node + pair[k].a, node + pair[k].b); },
        [&](std::size_t k) {
            const std::uint32_t later = pair[k + PairList::padding - CapsuleTile::width].b;
            __builtin_prefetch(node + later);
            __builtin_prefetch(node + later + 1);
        },
        [&](std::size_t k, const CapsuleTile& tile) __attribute__((always_inline)) { scan.add(k, tile, motion); });
    scan.finish();
}

template void Contacts::find_touching<true>(const Work& work, WorkArea& area);
template void Contacts::find_touching<false>(const Work& work, WorkArea& area);

} // namespace skein
