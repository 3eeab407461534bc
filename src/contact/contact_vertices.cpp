// Contacts near vertices: terms that vertices take from pairs, and springs that new contacts inherit.
#include "contact/work_area.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <utility>

namespace skein {

template <int W> SKEIN_INLINE void Contacts::NearVertex<W>::put(int l, Pair pair, unsigned vertices, bool turned) {
    const int first = turned, second = 1 - first;
    slot[first][l] = pair.a;
    slot[second][l] = pair.b;
    at_start[first] |= (vertices & 1) << l;
    at_end[first] |= (vertices >> 1 & 1) << l;
    at_start[second] |= (vertices >> 2 & 1) << l;
    at_end[second] |= (vertices >> 3 & 1) << l;
}

/// Energies and forces of vertices that touching pairs share; vertices_1, vertices_2: of each element that may touch.
template <int N, int vertices_1, int vertices_2>
VertexTerms<Pack<N>> Contacts::at_vertices(const Exposure& bodies, const NearVertex<N>& pairs) const {
    using Q = Pack<N>;
    constexpr int vertices[2] = {vertices_1, vertices_2};
    const ExposedNode* const node = bodies.node.data();
    const auto load = [&](auto&& at) { return load_transposed<N>([&](int l) { return &at(l)->position.x; }); };
    ElementAtVertices<N> element[2];
    Q radii(0.0);
    Pair pair[N];
    for (const int i : {0, 1}) {
        ElementAtVertices<N>& e = element[i];
        const std::uint32_t* const slot = pairs.slot[i];
        const auto at_start = load([&](int l) { return node + slot[l]; });
        e.node[1] = at_start.vector;
        radii += at_start.fourth;
        e.node[2] = load([&](int l) { return node + slot[l] + 1; }).vector;
        e.share = pairs.share[i];
        const auto node_of_neighbour = [&](int l, bool end) { return node + neighbour(bodies, slot[l], end) + end; };
        if (vertices[i] == 1) {
            const unsigned at_end = pairs.at_end[i];
            e.node[0] = load([&](int l) { return node_of_neighbour(l, at_end >> l & 1); }).vector;
            e.at_end = where_set<N>(at_end, 1.0) > Q(0.0);
        }
        if (vertices[i] < 2) continue;
        const unsigned joined[2] = {pairs.at_start[i], pairs.at_end[i]};
        for (const int j : {0, 1}) {
            e.node[3 * j] = load([&](int l) {
                                return joined[j] >> l & 1 ? node_of_neighbour(l, j) : node + slot[l] + (1 - j);
                            }).vector;
            e.joined[j] = where_set<N>(joined[j], 1.0);
        }
    }
    for (int l = 0; l < N; ++l) pair[l] = {pairs.slot[0][l], pairs.slot[1][l]};
    return vertex_terms<N, vertices_1, vertices_2>(kinds_.normal, numbers<N>(bodies, pair).stiffness, radii,
                                                   pairs.apart, pairs.sine_squared, element);
}

/// Terms of vertices of up to W pairs near them, at these places in their columns. Forces wait in the work area.
template <int vertices_1, int vertices_2, int W>
void Contacts::take_vertices(const Work& work, WorkArea& area, Sums& sums, const std::uint32_t* places, int valid) {
    using A = WorkArea;
    using P = Pack<W>;
    constexpr int vertices[2] = {vertices_1, vertices_2};
    A::Near& near = vertices_2 > 0 ? area.near_two : area.near_one;
    NearVertex<W> pairs;
    alignas(64) double sine_squared[W], place[2][W], apart[3][W], squared[W];
    unsigned mine = 0;
    for (int l = 0; l < W; ++l) {
        const std::uint32_t at = places[l < valid ? l : 0], n = near.which[at];
        const unsigned bits = near.vertices[at];
        const bool turned = near.turned(at);
        pairs.put(l, area.pair[n], bits, turned);
        place[turned][l] = area[A::s][n];
        place[!turned][l] = area[A::t][n];
        sine_squared[l] = area[A::sine_squared][n];
        const double sign = turned ? -1 : 1;
        apart[0][l] = sign * area[A::x][n];
        apart[1][l] = sign * area[A::y][n];
        apart[2][l] = sign * area[A::z][n];
        mine |= static_cast<unsigned>(l < valid && work.bodies.owns_slot(area.pair[n].a)) << l;
    }
    pairs.share[0] = detail::pack_at<W>(place[0]);
    pairs.share[1] = detail::pack_at<W>(place[1]);
    pairs.sine_squared = detail::pack_at<W>(sine_squared);
    pairs.apart = {detail::pack_at<W>(apart[0]), detail::pack_at<W>(apart[1]), detail::pack_at<W>(apart[2])};
    const VertexTerms<P> terms = at_vertices<W, vertices_1, vertices_2>(work.bodies, pairs);
    detail::put(squared, dot(terms.apart, terms.apart));
    sums.add_energy(terms.scale * terms.energy, mine);
    ForceRow unused;
    for (const int e : {0, 1})
        for (const int k : {0, 1, 2, 3}) {
            const bool inner = k == 1 || k == 2;
            if (!inner && (terms.turns == 0 || vertices[e] == 0 || (vertices[e] == 1 && k == 3))) continue;
            store_transposed<W>(terms.force[e][k], P(0.0), [&](int l) {
                return l < valid ? &near.force[places[l]].row[e][k].number[0] : &unused.number[0];
            });
        }
    for (int l = 0; l < valid; ++l) {
        const std::uint32_t at = places[l], n = near.which[at];
        const bool turned = near.turned(at);
        const double sign = turned ? -1 : 1, x = terms.apart.x[l], y = terms.apart.y[l], z = terms.apart.z[l];
        area[A::s][n] = terms.share[turned][l];
        area[A::t][n] = terms.share[!turned][l];
        area[A::x][n] = sign * x;
        area[A::y][n] = sign * y;
        area[A::z][n] = sign * z;
        area[A::squared][n] = squared[l];
        area[A::weight][n] = area[A::weight_of_all][n] = terms.weight[l];
        area[A::elsewhere][n] = terms.normal[l];
        area[A::vertex_energy][n] = terms.energy[l];
        near.force[at].turns = terms.turns >> l & 1;
    }
}

/// Pairs of a block with the same number of vertices that may touch, in packs. Half the lanes serve the rest where they
/// are enough.
template <int vertices_1, int vertices_2>
void Contacts::take_packs(const Work& work, WorkArea& area, Sums& sums, std::span<const std::uint32_t> places) {
    constexpr int W = WorkArea::W;
    for (std::size_t i = 0; i < places.size(); i += W) {
        const int left = static_cast<int>(std::min<std::size_t>(W, places.size() - i));
        if (left > W / 2) take_vertices<vertices_1, vertices_2, W>(work, area, sums, &places[i], left);
        else take_vertices<vertices_1, vertices_2, W / 2>(work, area, sums, &places[i], left);
    }
}

/// Exerts the forces of vertices of pairs near them, in the order of pairs.
void Contacts::exert_at_vertices(const Work& work, const WorkArea& area, bool both) {
    const WorkArea::Near& near = both ? area.near_two : area.near_one;
    for (std::uint32_t i = 0; i < near.count; ++i) {
        const unsigned bits = near.vertices[i];
        const bool turned = near.turned(i);
        const Pair pair = area.pair[near.which[i]];
        const auto& [row, turns] = near.force[i];
        for (const int e : {0, 1}) {
            const bool second = e != turned;
            const std::uint32_t slot = second ? pair.b : pair.a;
            exert(work, slot, row[e][1], row[e][2]);
            if (!turns) continue;
            const unsigned ends = bits >> (second ? 2 : 0) & 3;
            if (ends & at_start) exert_at(work, neighbour(work.bodies, slot, false), row[e][0], false);
            if (ends & at_end) exert_at(work, neighbour(work.bodies, slot, true), row[e][near.alone(i) ? 0 : 3], true);
        }
    }
}

/// Forces of shared vertices; a pair that is near none has all of its contact.
void Contacts::push_vertices(const Work& work, WorkArea& area, Sums& sums) {
    using A = WorkArea;
    for (const A::Number whole : {A::weight, A::weight_of_all}) std::fill_n(area[whole], area.count, 1.0);
    for (const A::Number none : {A::elsewhere, A::vertex_energy}) std::fill_n(area[none], area.count, 0.0);
    for (WorkArea::Near* near : {&area.near_one, &area.near_two}) near->sort();
    take_packs<1, 0>(work, area, sums, area.near_one.alone());
    take_packs<2, 0>(work, area, sums, area.near_one.others());
    exert_at_vertices(work, area, false);
    take_packs<1, 1>(work, area, sums, area.near_two.alone());
    take_packs<2, 2>(work, area, sums, area.near_two.others());
    exert_at_vertices(work, area, true);
}

/// Energies and forces of shared vertices, of one pair.
VertexTerms<Pack<1>> Contacts::at_vertices(const Exposure& bodies, std::uint32_t pair,
                                           const ClosestPoints<Pack<1>>& at) const {
    NearVertex<1> one;
    const unsigned vertices = list_.vertices[pair];
    const bool turned = (vertices & 3) == 0;
    one.put(0, list_.pair[pair], vertices, turned);
    one.share[turned] = at.s;
    one.share[!turned] = at.t;
    one.sine_squared = at.sine_squared;
    one.apart = turned ? -at.apart : at.apart;
    if ((vertices & 3) != 0 && (vertices >> 2) != 0) return at_vertices<1, 2, 2>(bodies, one);
    VertexTerms<Pack<1>> terms = at_vertices<1, 2, 0>(bodies, one);
    if (turned) {
        std::swap(terms.force[0], terms.force[1]);
        std::swap(terms.share[0], terms.share[1]);
        terms.apart = -terms.apart;
    }
    return terms;
}

/// Pair whose spring a new contact inherits: the pair of the neighbour that shares the contact, if that touched, else
/// its own.
Contacts::Inherited Contacts::spring_at_vertex(const Exposure& bodies, std::uint32_t pair, int da, int db,
                                               std::uint32_t own) const {
    const auto take = [&](PairList::Neighbour n, std::uint32_t else_) {
        const std::uint32_t at = n.is_candidate ? n.pair : pair;
        return n.is_candidate & ((status_[at] & touching) != 0) ? at : else_;
    };
    std::uint32_t from = take(list_.along_first(pair, db == 0 ? 0 : da, db), own);
    from = take(list_.along_second(pair, db), from);
    from = take(list_.along_first(pair, da, 0), from);
    return has_rings_ ? spring_at_seam(bodies, pair, da, db, {from}) : Inherited{from};
}

/// The element before or behind (step -1, 1) that of a slot, where a ring closes between them.
std::optional<std::uint32_t> Contacts::beyond_seam(const Exposure& bodies, std::uint32_t slot, int step) const {
    const std::int32_t ring = nth(scene_.rules.of_group, bodies.at(slot).group).ring;
    if (ring == 0 || step == 0 || bodies.element(slot) != (step < 0 ? 0 : ring - 1)) return {};
    return bodies.find(bodies.in_scene(slot) - step * (ring - 1));
}

/// Pair at the seam of a ring, where neighbours have no consecutive numbers. Elements of one ring may stand in the
/// other order beyond; then body 1 of the law is body 2 here. `otherwise`: the pair where no ring closes.
Contacts::Inherited Contacts::spring_at_seam(const Exposure& bodies, std::uint32_t pair, int da, int db,
                                             Inherited otherwise) const {
    const auto [a, b] = list_.pair[pair];
    const auto next_a = beyond_seam(bodies, a, da), next_b = beyond_seam(bodies, b, db);
    if (!next_a && !next_b) return otherwise;
    Inherited from = otherwise;
    const auto take = [&](int step_a, int step_b) {
        const std::uint32_t on_a = step_a != 0 && next_a ? *next_a : a + static_cast<std::uint32_t>(step_a),
                            on_b = step_b != 0 && next_b ? *next_b : b + static_cast<std::uint32_t>(step_b);
        const std::uint32_t at = list_.find({std::min(on_a, on_b), std::max(on_a, on_b)});
        if (at < list_.count() && (status_[at] & touching) != 0) from = {at, on_a > on_b};
    };
    if (da != 0 && db != 0) take(da, db);
    if (db != 0) take(0, db);
    if (da != 0) take(da, 0);
    return from;
}

/// The spring that a contact goes on from as it begins: where it begins near a vertex, that of the pair it follows.
FrictionSpring<double> Contacts::inherited_spring(const Exposure& bodies, std::uint32_t pair, double s,
                                                  double t) const {
    constexpr FrictionSpring<double> none{{0, 0, 0}, 0};
    const unsigned vertices = list_.vertices[pair];
    const double reach = bodies.scene().vertex_reach();
    const int da = vertex_side(s, vertices, reach), db = vertex_side(t, vertices >> 2, reach);
    if ((da | db) == 0 || !has_spring(kinds_.friction)) return none;
    const auto nothing = static_cast<std::uint32_t>(list_.count());
    const Inherited inherited = spring_at_vertex(bodies, pair, da, db, nothing);
    if (inherited.pair == nothing) return none;
    FrictionSpring<double> spring = memory_[inherited.pair].spring;
    if (inherited.turned) spring.x = -spring.x;
    return spring;
}

/// True where a pair touches, and is not only near enough to meet in the step.
bool Contacts::overlaps(const WorkArea& area, std::uint32_t n) const {
    const double reach = area[WorkArea::radius_1][n] + area[WorkArea::radius_2][n];
    return scene_.meeting_zone == 0 || area[WorkArea::squared][n] < reach * reach;
}

/// Inherits springs before any memory or status of the block's pairs changes.
void Contacts::inherit_springs(const Work& work, const WorkArea& area) {
    if (!area.begins || !has_spring(kinds_.friction)) return;
    for (std::uint32_t n = 0; n < area.count; ++n)
        if (const std::uint32_t pair = area.index[n]; !(status_[pair] & touching) && overlaps(area, n))
            memory_[pair].spring = inherited_spring(work.bodies, pair, area[WorkArea::s][n], area[WorkArea::t][n]);
}

} // namespace skein
