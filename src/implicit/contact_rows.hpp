// Slopes of contacts in the rows of the rods and bodies of a tile.                                        theory.md
// (123)
#pragma once

#include "contact/tangent_lanes.hpp"
#include "implicit/elastic_rows.hpp"
#include "neighbourhood/exposure.hpp"
#include "rod/body_shape.hpp"

#include <array>

namespace skein {

namespace detail {

template <class P> SKEIN_INLINE Three<P> symmetric(const P (&m)[6]) {
    return {{{m[0], m[1], m[2]}, {m[1], m[3], m[4]}, {m[2], m[4], m[5]}}};
}
template <class P> SKEIN_INLINE Three<P> transposed(const Three<P>& a) {
    Three<P> r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) r.a[i][j] = a.a[j][i];
    return r;
}
/// Adds `times` times a block of three at (row, column).
template <int W>
SKEIN_INLINE void add_three(const Three<Pack<W>>& block, RowBlock<W>& to, int row, int column, double times = 1) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            to[row + i][column + j] = fma(Pack<W>(times), block.a[i][j], to[row + i][column + j]);
}

} // namespace detail

/// Sums of contacts on the rods of a tile, as their interaction leaves them.
template <int W> class TangentsOfLanes {
public:
    /// `loads`: null where rods do not feel each other.
    TangentsOfLanes(const Exposure* exposure, const SlotLoads* loads, const RodTile<W>& rod) {
        static constexpr SlotTangent none{};
        for (int l = 0; l < W; ++l) {
            taken_[l] = &none;
            if (!loads) continue;
            const std::size_t number =
                exposure->number_of_own(rod.group->id(), ExposedLanes<W>::place_in_group(rod, l));
            const bool touched = loads->touched[number] != 0;
            if (touched) taken_[l] = &loads->tangent[exposure->window[number].first_slot];
            step_[l] = touched;
            any_ |= touched;
        }
    }
    bool any() const { return any_; }
    void add(std::size_t k, TangentLanes<W>& to) const {
        to.add_lanes([&](int l) -> const SlotTangent& { return taken_[l][step_[l] * k]; });
    }

private:
    std::array<const SlotTangent*, to_index(W)> taken_{};
    std::array<std::size_t, to_index(W)> step_{};
    bool any_ = false;
};

/// Slopes of an element as blocks: displacements in the lab, turns in the element's frame.
template <int W> struct ElementTangent {
    using P = Pack<W>;
    Three<P> first{}, across{}, second{}, turn{}; ///< nodes, and the turn by itself
    Three<P> of_first{}, of_second{};             ///< nodes by the turn

    ElementTangent() = default;
    ElementTangent(const TangentLanes<W>& sum, const Quaternion<P>& director)
        : first(detail::symmetric(sum.first)), across(detail::symmetric(sum.across)),
          second(detail::symmetric(sum.second)) {
        const Three<P> q = detail::three<W>(director);
        turn = detail::product_with_transpose(detail::product(q, detail::symmetric(sum.turn)), q);
        of_first = detail::product_with_transpose(detail::skew(-sum.at_first), q);
        of_second = detail::product_with_transpose(detail::skew(-sum.at_second), q);
    }

    /// Row of its first node, and its own.
    void add_to_own(BlockRow<W>& row) const {
        detail::add_three<W>(first, row.diagonal, 0, 0);
        detail::add_three<W>(of_first, row.diagonal, 0, 3);
        detail::add_three<W>(detail::transposed(of_first), row.diagonal, 3, 0);
        detail::add_three<W>(turn, row.diagonal, 3, 3);
        detail::add_three<W>(across, row.after, 0, 0);
        detail::add_three<W>(detail::transposed(of_second), row.after, 3, 0);
    }
    /// Row of its second node.
    void add_to_next(BlockRow<W>& row) const {
        detail::add_three<W>(second, row.diagonal, 0, 0);
        detail::add_three<W>(across, row.before, 0, 0);
        detail::add_three<W>(of_second, row.before, 0, 3);
    }
};

/// Adds slopes of a body's surface: an element between the places a and b of it moves with x + t x a and x + t x b.
template <int W> void add_surface_tangents(const TangentsOfLanes<W>& tangents, const BodyShape& body,
                                           const Quaternion<Pack<W>>& director, RowBlock<W>& lab) {
    using P = Pack<W>;
    std::size_t k = 0;
    for (const BodyShape::Part& part : body.part) {
        TangentLanes<W> sum;
        tangents.add(k, sum);
        k += 2;
        const auto by_turn = [&](const Vec3d& place) { // dx = -[a] t
            return detail::skew(-transpose_times(director, broadcast<W>(place)));
        };
        const Three<P> a = by_turn(part.from), b = by_turn(part.box ? part.from : part.to),
                       first = detail::symmetric(sum.first), across = detail::symmetric(sum.across),
                       second = detail::symmetric(sum.second), of_a = detail::skew(-sum.at_first),
                       of_b = detail::skew(-sum.at_second);
        const auto add_pair = [&](const Three<P>& c, const Three<P>& left, const Three<P>& right) {
            const Three<P> by_right = detail::product(c, right), by_left = detail::product(c, left);
            detail::add_three<W>(c, lab, 0, 0);
            detail::add_three<W>(by_right, lab, 0, 3);
            detail::add_three<W>(detail::transposed(by_left), lab, 3, 0);
            detail::add_three<W>(detail::product(detail::transposed(left), by_right), lab, 3, 3);
        };
        add_pair(first, a, a);
        add_pair(across, a, b);
        add_pair(across, b, a);
        add_pair(second, b, b);
        const auto add_couple = [&](const Three<P>& c, const Three<P>& left) {
            const Three<P> both = detail::product(detail::transposed(left), c);
            detail::add_three<W>(c, lab, 0, 3);
            detail::add_three<W>(detail::transposed(c), lab, 3, 0);
            detail::add_three<W>(both, lab, 3, 3);
            detail::add_three<W>(detail::transposed(both), lab, 3, 3);
        };
        add_couple(of_a, a);
        add_couple(of_b, b);
        detail::add_three<W>(detail::symmetric(sum.turn), lab, 3, 3);
    }
}

/// Adds slopes in the lab to a body's row, whose turns are in its frame.
template <int W>
void add_lab_tangent(const RowBlock<W>& lab, const Quaternion<Pack<W>>& director, RowBlock<W>& diagonal) {
    using P = Pack<W>;
    const Three<P> q = detail::three<W>(director);
    Three<P> part[2][2];
    for (int r = 0; r < 2; ++r)
        for (int c = 0; c < 2; ++c)
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) part[r][c].a[i][j] = lab[3 * r + i][3 * c + j];
    detail::add_three<W>(part[0][0], diagonal, 0, 0);
    detail::add_three<W>(detail::product_with_transpose(part[0][1], q), diagonal, 0, 3);
    detail::add_three<W>(detail::product(q, part[1][0]), diagonal, 3, 0);
    detail::add_three<W>(detail::product_with_transpose(detail::product(q, part[1][1]), q), diagonal, 3, 3);
}

} // namespace skein
