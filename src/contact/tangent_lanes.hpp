// Slopes of contact forces by the motion of one body alone, for the rods of a tile.                      theory.md
// (123)
#pragma once

#include "core/transposed.hpp"
#include "neighbourhood/slot_tangent.hpp"
#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"
#include "skein/tiles/tile.hpp"

#include <utility>
#include <vector>

namespace skein {

/// SlotTangent of an element of W rods.
template <int W> struct TangentLanes {
    using P = Pack<W>;
    P first[6]{}, across[6]{}, second[6]{}, turn[6]{};
    Vec3<P> at_first{}, at_second{}; ///< b_1, b_2

    /// Adds contacts: n, p, q, s and r as in slot_tangent.hpp.
    void add(const Vec3<P>& n, const P& p, const P& q, double s, const P& r) {
        const P over = p - q, arm = q * r, turning = arm * r;
        const P nn[6] = {n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z};
        constexpr double one[6] = {1, 0, 0, 1, 0, 1};
        const P w(1 - s), ww((1 - s) * (1 - s)), ws((1 - s) * s), ss(s * s);
        for (int i = 0; i < 6; ++i) {
            const P c = fma(over, nn[i], q * P(one[i]));
            first[i] = fma(ww, c, first[i]);
            across[i] = fma(ws, c, across[i]);
            second[i] = fma(ss, c, second[i]);
            turn[i] = fma(turning, P(one[i]) - nn[i], turn[i]);
        }
        at_first = fma(w * arm, n, at_first);
        at_second = fma(P(s) * arm, n, at_second);
    }
    /// Adds the sums of lanes; at(l): those of lane l.
    template <class At> void add_lanes(At&& at) {
        const auto take = [&](auto line, P(&to)[6]) {
            const auto low = load_transposed<W>([&](int l) { return line(at(l)); }),
                       high = load_transposed<W>([&](int l) { return line(at(l)) + 4; });
            to[0] += low.vector.x;
            to[1] += low.vector.y;
            to[2] += low.vector.z;
            to[3] += low.fourth;
            to[4] += high.vector.x;
            to[5] += high.vector.y;
            return std::pair(high.vector.z, high.fourth);
        };
        const auto a = take([](const SlotTangent&t) { return t.first; }, first),
                   b = take([](const SlotTangent&t) { return t.across; }, across),
                   c = take([](const SlotTangent&t) { return t.second; }, second),
                   d = take([](const SlotTangent&t) { return t.turn; }, turn);
        at_first += Vec3<P>{a.first, a.second, b.first};
        at_second += Vec3<P>{c.first, c.second, d.first};
    }
};

/// Contacts of rods or bodies with walls, by tile: slopes by element, or of a body by displacement and turn, all lab.
template <int W> class WallTangents {
public:
    using P = Pack<W>;
    struct Tile {
        AlignedVector<TangentLanes<W>> element; ///< of rods
        P body[6][6]{};                         ///< of bodies
        bool touches = false;

        void clear() {
            if (!touches) return;
            for (TangentLanes<W>& e : element) e = {};
            for (auto& line : body)
                for (P& entry : line) entry = P(0.0);
            touches = false;
        }
    };
    double zone = 0; ///< gap of points that have slopes before they touch, m

    void add_tile(const RodTile<W>& rod) {
        if (tiles_.size() <= rod.number) tiles_.resize(rod.number + 1);
        tiles_[rod.number].element.resize(rod.group->strained() ? to_index(rod.n) : 0);
    }
    Tile& operator[](std::size_t tile) { return tiles_[tile]; }

private:
    std::vector<Tile> tiles_;
};

} // namespace skein
