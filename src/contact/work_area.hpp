// Numbers that the stages of a block's contacts hand on to each other.
#pragma once

#include "contact/compress.hpp"
#include "contact/contacts.hpp"
#include "contact/response.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace skein {

namespace detail {

template <int W> SKEIN_INLINE Vec3<Pack<W>> between(const Vec3<Pack<W>>& a, const Vec3<Pack<W>>& b, Pack<W> share) {
    return fma(share, b - a, a);
}

/// Direction from one axis to the other where they intersect: across both, or across one of them where they are
/// parallel.
template <int N> Vec3<Pack<N>> across(const Vec3<Pack<N>>& d1, const Vec3<Pack<N>>& d2) {
    using Q = Pack<N>;
    const Vec3<Q> both = cross(d1, d2), one = cross(d1, select(abs(d1.x) < abs(d1.y), Vec3<Q>{Q(1.0), Q(0.0), Q(0.0)},
                                                               Vec3<Q>{Q(0.0), Q(1.0), Q(0.0)}));
    const Vec3<Q> some = select(dot(both, both) > Q(1e-24) * dot(d1, d1) * dot(d2, d2), both, one);
    return (Q(1.0) / max(norm(some), Q(1e-300))) * some;
}

inline Vec3d edge(const Exposure& c, std::uint32_t slot) { return c.node[slot + 1].position - c.node[slot].position; }

} // namespace detail

/// Pairs of a block in contact, left-packed, in order of pairs; then that order filled up to whole packs. Belongs to a
/// thread.
struct Contacts::WorkArea {
    static constexpr int W = 8;
    enum Number {
        s,
        t,
        x,
        y,
        z,
        squared,
        sine_squared,
        radius_1,
        radius_2,
        weight,
        weight_of_all,
        elsewhere,
        vertex_energy,
        numbers
    };
    UnsetArray<double> number[numbers];
    UnsetArray<std::uint32_t> index; ///< number of the pair in the list
    UnsetArray<Pair> pair;
    std::uint32_t count = 0;
    bool begins = false;                     ///< some did not touch in the step before
    UnsetArray<std::uint32_t> near_parallel; ///< pairs at a shallow angle, by place in these columns
    std::uint32_t near_parallel_count = 0;
    std::vector<std::uint32_t> ended;    ///< pairs that touch no more
    std::vector<std::uint32_t> deep;     ///< pairs whose axes are nearer than half the sum of radii
    std::vector<BoxContact> box_contact; ///< contacts of the block's pairs with a box
    /// Pairs near vertices: starts and ends of their elements, as bits of vertices_of_pair().
    struct NearColumns {
        std::uint32_t* which;
        std::uint8_t* vertices;
    };
    /// Forces on the nodes of ElementAtVertices, first of the element that is near a vertex.
    struct VertexForces {
        ForceRow row[2][4];
        bool turns; ///< nodes of neighbours have some
    };
    struct Near {
        UnsetArray<std::uint32_t> which;
        UnsetArray<std::uint8_t> vertices;
        UnsetArray<VertexForces> force;
        std::uint32_t count = 0;

        void need(std::size_t pairs) {
            which.need(pairs);
            vertices.need(pairs);
            force.need(pairs);
            order_.need(pairs);
        }
        NearColumns columns() { return {which.data(), vertices.data()}; }

        /// True where the second element alone is near a vertex.
        bool turned(std::uint32_t i) const { return (vertices[i] & 3) == 0; }
        /// True where no element may touch with both of its vertices.
        bool alone(std::uint32_t i) const { return (vertices[i] & vertices[i] >> 1 & 5) == 0; }
        /// Places in the columns, of those that are alone and of the others, each rising; after sort().
        std::span<const std::uint32_t> alone() const { return {order_.data(), alone_}; }
        std::span<const std::uint32_t> others() const { return {order_.data() + alone_, count - alone_}; }
        void sort() {
            alone_ = 0;
            for (const bool one : {true, false})
                for (std::uint32_t i = 0, at = alone_; i < count; ++i) {
                    order_[at] = i;
                    at += alone(i) == one;
                    if (one) alone_ = at;
                }
        }

    private:
        UnsetArray<std::uint32_t> order_;
        std::uint32_t alone_ = 0;
    };
    Near near_one; ///< vertices of one element
    Near near_two; ///< vertices of both

    /// Room for this many pairs, of which none is there.
    void clear(std::size_t pairs) {
        for (UnsetArray<double>& of : number) of.need(pairs + 2 * W);
        for (UnsetArray<std::uint32_t>* of : {&index, &near_parallel}) of->need(pairs + 2 * W);
        for (Near* of : {&near_one, &near_two}) of->need(pairs + 2 * W);
        pair.need(pairs + 2 * W);
        count = near_one.count = near_two.count = near_parallel_count = 0;
        begins = false;
        ended.clear();
        deep.clear();
    }
    double* operator[](Number n) { return number[n].data(); }
    const double* operator[](Number n) const { return number[n].data(); }
    Pack<W> pack(Number n, std::uint32_t from) const {
        Pack<W> p;
        std::memcpy(&p, number[n].data() + from, sizeof p);
        return p;
    }
    void move(std::uint32_t from, std::uint32_t to) {
        for (UnsetArray<double>& of : number) of[to] = of[from];
        index[to] = index[from];
        pair[to] = pair[from];
    }
    /// The last pack is filled up with its first.
    void fill_up() {
        for (std::uint32_t n = count; n % W != 0; ++n) move(n / W * W, n);
    }
};

/// A pair in contact: force on its first element and weight with all of its points, place of the nearest ones.
struct Contacts::PairContact {
    Vec3d force;
    double s, t, distance, weight;
};

/// Forces of near-parallel pairs at the ends of their overlap, and the weights left for the nearest points.
template <int N> struct Contacts::Ends {
    Pack<N> normal_weight, weight_of_all; ///< see ContactWeight
    Pack<N> elsewhere{0.0};               ///< normal force at both ends, N
    Pack<N> elastic_energy{0.0}, viscous_work{0.0}, stiffness{0.0};
    ElementLoad<Pack<N>> on_1, on_2;
    struct Tangent {
        Vec3<Pack<N>> normal;
        Pack<N> slope, turning, s, t, arm_1, arm_2;
    } tangent[2]; ///< slopes at either end, N/m: of the normal force, and by its direction
};

/// Figures of packs of contacts.
struct Contacts::Sums {
    static constexpr int W = WorkArea::W;
    using P = Pack<W>;
    const SumBins& bins; ///< bins of energies
    P max_overlap{0.0}, max_stiffness{0.0}, weight{0.0};
    BinnedSum<P> elastic_energy, friction_work, viscous_work;

    /// Adds the lanes whose bits are set.
    SKEIN_INLINE void add(const ContactForce<P>& f, P depth, P share, unsigned bits) {
        weight += counted(in_steps(share), bits);
        max_overlap = max(max_overlap, counted(depth, bits));
        add(f.stiffness, f.elastic_energy, f.friction_work, f.viscous_work, bits);
    }
    SKEIN_INLINE void add(P stiffness, P energy, P friction, P viscous, unsigned bits) {
        max_stiffness = max(max_stiffness, counted(stiffness, bits));
        elastic_energy.add(counted(energy, bits), bins);
        friction_work.add(counted(friction, bits), bins);
        viscous_work.add(counted(viscous, bits), bins);
    }
    SKEIN_INLINE static P counted(P value, unsigned bits) {
        return bits == 0xff ? value : select(where_set<W>(bits, 1.0) > P(0.0), value, P(0.0));
    }
    template <int N> SKEIN_INLINE void add_energy(Pack<N> energy, unsigned bits) {
        alignas(64) double lane[W] = {};
        for (int l = 0; l < N; ++l)
            if (bits >> l & 1) lane[l] = energy[l];
        P all;
        std::memcpy(&all, lane, sizeof all);
        elastic_energy.add(all, bins);
    }
    void give(BlockFigures& figures) const {
        const auto sum = [](P p) {
            double all = 0;
            for (int l = 0; l < W; ++l) all += p[l];
            return all;
        };
        const auto largest = [](P p) {
            double most = p[0];
            for (int l = 1; l < W; ++l) most = std::max(most, p[l]);
            return most;
        };
        figures.max_overlap = largest(max_overlap);
        figures.max_stiffness = largest(max_stiffness);
        figures.weight = sum(weight);
        for (int i = 0; i < SumBins::count; ++i) {
            figures.elastic_energy.part[i] += sum(elastic_energy.part[i]);
            figures.friction_work.part[i] += sum(friction_work.part[i]);
            figures.viscous_work.part[i] += sum(viscous_work.part[i]);
        }
    }
};

/// The neighbour of an element at a vertex.
SKEIN_INLINE std::uint32_t Contacts::neighbour(const Exposure& bodies, std::uint32_t slot, bool at_end) const {
    return edge_[slot + at_end] == 0 ? slot + (at_end ? 1u : ~0u) : bodies.neighbour(slot, at_end ? 1 : -1);
}

template <int N>
SKEIN_INLINE ContactNumbers<Pack<N>> Contacts::numbers(const Exposure& bodies, const Pair* pair) const {
    using Q = Pack<N>;
    auto all = numbers_[0].as<Q>();
    if (laws_.materials() == 1 && !own_numbers_) return all;
    for (int l = 0; l < N; ++l) {
        const Window &a = bodies.at(pair[l].a), &b = bodies.at(pair[l].b);
        const std::size_t law = laws_.materials() == 1 ? 0 : to_index(a.group) * laws_.materials() + to_index(b.group);
        if (own_numbers_) set_lane(all, l, own_numbers(numbers_[law], a, b));
        else set_lane(all, l, numbers_[law]);
    }
    return all;
}

} // namespace skein
