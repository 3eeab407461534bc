// Contacts near vertices: where they are and the share of each pair; springs that contacts go on from.
#include "contact/work_area.hpp"

#include <algorithm>
#include <bit>

namespace skein {

using detail::edge;

template <int W>
SKEIN_INLINE void Contacts::NearVertex<W>::put(int l, Pair pair, double s, double t, unsigned vertices, bool turned) {
    const int first = turned, second = 1 - first;
    slot[first][l] = pair.a, slot[second][l] = pair.b;
    place_[first][l] = s, place_[second][l] = t;
    at_start[first] |= (vertices & 1) << l, at_end[first] |= (vertices >> 1 & 1) << l;
    at_start[second] |= (vertices >> 2 & 1) << l, at_end[second] |= (vertices >> 3 & 1) << l;
}
template <int W> SKEIN_INLINE void Contacts::NearVertex<W>::load() {
    for (const int i : {0, 1}) std::memcpy(&share[i], place_[i], sizeof share[i]);
}

/// Where pairs are in contact whose elements have neighbours near there, and their share. The first of each is near a vertex, the
/// second may be only `both` are.
template <int N, bool both>
Contacts::Crossing<N> Contacts::crossing_at_vertices(const Exposure& bodies, const NearVertex<N>& pairs) const {
    using Q = Pack<N>;
    const ExposedNode* const node = bodies.node.data();
    const double reach = bodies.scene().vertex_reach();
    const auto load = [&](auto&& at) { return load_transposed<N>([&](int l) { return &at(l)->position.x; }); };
    struct Element {
        Vec3<Q> start, edge, end;
        Q radius;
        ShareRange<Q> wide, range;
    } element[2];
    for (const int i : {0, 1}) {
        Element& e = element[i];
        const std::uint32_t* const slot = pairs.slot[i];
        const auto at_start = load([&](int l) { return node + slot[l]; });
        e.start = at_start.vector, e.radius = at_start.behind;
        e.end = load([&](int l) { return node + slot[l] + 1; }).vector;
        e.edge = e.end - e.start;
        if (i == 0 || both) e.wide = range_with_vertices<N>(pairs.at_start[i], pairs.at_end[i], 2 * reach);
    }
    Q weight(1.0);
    const Q none(0.0), one(1.0), radii = element[0].radius + element[1].radius;
    for (int i = 0; i < 1 + both; ++i) {
        Element &e = element[i], &o = element[1 - i];
        const auto at_end = e.wide.high > one;
        const Vec3<Q> neighbour =
                          load([&](int l) { return neighbour_node(bodies, pairs.slot[i][l], pairs.at_end[i] >> l & 1); }).vector,
                      vertex = select(at_end, e.end, e.start);
        const VertexShare<Q> share = vertex_share(reach, select(at_end, one - pairs.share[i], pairs.share[i]), vertex,
                                                  select(at_end, -e.edge, e.edge), neighbour - vertex, o.start, o.edge, o.wide);
        const Q shared = sharing(pairs.sine_squared, share.bend * radii), beyond = shared * share.beyond;
        weight *= fma(shared, share.weight - one, one);
        e.range = {select(at_end, none, -beyond), select(at_end, one + beyond, one)};
    }
    return {
        closest_points(element[0].start, element[0].edge, element[1].start, element[1].edge, element[0].range, element[1].range),
        weight};
}

/// The same of a pair by itself, wherever it is.
Contacts::Crossing<1> Contacts::crossing(const Exposure& bodies, std::uint32_t pair) const {
    const double reach = bodies.scene().vertex_reach(), seen = seen_beyond(reach);
    const auto [a, b] = list_.pair[pair];
    const unsigned vertices = list_.vertices[pair];
    const auto anywhere =
        closest_points(broadcast<1>(bodies.node[a].position), broadcast<1>(edge(bodies, a)), broadcast<1>(bodies.node[b].position),
                       broadcast<1>(edge(bodies, b)), range_with_vertices<1>(vertices & 1, vertices >> 1 & 1, seen),
                       range_with_vertices<1>(vertices >> 2 & 1, vertices >> 3 & 1, seen));
    const int on_1 = vertex_side(anywhere.s[0], vertices, reach), on_2 = vertex_side(anywhere.t[0], vertices >> 2, reach);
    if ((on_1 | on_2) == 0) return {anywhere, 1.0};
    NearVertex<1> one;
    one.sine_squared = anywhere.sine_squared;
    const bool turned = on_1 == 0;
    const auto bits = [](int side) { return side == 0 ? 0u : side < 0 ? 1u : 2u; };
    one.put(0, {a, b}, anywhere.s[0], anywhere.t[0], bits(on_1) | bits(on_2) << 2, turned);
    one.load();
    Crossing<1> at =
        on_1 != 0 && on_2 != 0 ? crossing_at_vertices<1, true>(bodies, one) : crossing_at_vertices<1, false>(bodies, one);
    if (turned) std::swap(at.at.s, at.at.t), at.at.apart = -at.at.apart;
    return at;
}

/// Puts contacts near vertices where they are, with the share that their elements have.
template <bool both> bool Contacts::weigh_those(const Exposure& bodies, WorkArea& area) const {
    using A = WorkArea;
    constexpr int W = A::W;
    using P = Pack<W>;
    const A::NearColumns near = (both ? area.near_two : area.near_one).columns();
    const std::uint32_t count = both ? area.twos : area.ones;
    double *const s = area[A::s], *const t = area[A::t];
    bool gone = false;
    for (std::uint32_t i = 0; i < count; i += W) {
        const int valid = static_cast<int>(std::min<std::uint32_t>(W, count - i));
        NearVertex<W> pairs;
        alignas(64) double sine_squared[W], place[2][W], apart[3][W], squared[W], weight[W];
        unsigned turned = 0;
        for (int l = 0; l < W; ++l) {
            const std::uint32_t at = i + static_cast<std::uint32_t>(l < valid ? l : 0), n = near.which[at];
            const unsigned vertices = near.vertices[at];
            const bool on_2_only = (vertices & 3) == 0;
            pairs.put(l, area.pair[n], s[n], t[n], vertices, on_2_only);
            turned |= static_cast<unsigned>(on_2_only) << l;
            sine_squared[l] = area[A::sine_squared][n];
        }
        pairs.load();
        pairs.sine_squared = detail::pack_at<W>(sine_squared);
        const Crossing<W> here = crossing_at_vertices<W, both>(bodies, pairs);
        const Vec3<P>& way = here.at.apart;
        detail::put(place[0], here.at.s), detail::put(place[1], here.at.t), detail::put(weight, here.weight);
        detail::put(apart[0], way.x), detail::put(apart[1], way.y), detail::put(apart[2], way.z);
        detail::put(squared, dot(way, way));
        for (int l = 0; l < valid; ++l) {
            const std::uint32_t n = near.which[i + static_cast<std::uint32_t>(l)];
            const int first = static_cast<int>(turned >> l & 1);
            const double radii = area[A::radius_1][n] + area[A::radius_2][n], sign = first ? -1 : 1;
            s[n] = place[first][l], t[n] = place[1 - first][l];
            area[A::x][n] = sign * apart[0][l], area[A::y][n] = sign * apart[1][l], area[A::z][n] = sign * apart[2][l];
            area[A::squared][n] = squared[l];
            area[A::weight][n] = squared[l] < radii * radii ? weight[l] : 0;
            gone |= area[A::weight][n] == 0;
        }
    }
    return gone;
}

/// The same for all, and pairs without a share are taken out.
void Contacts::weigh(const Work& work, WorkArea& area) const {
    using A = WorkArea;
    std::fill_n(area[A::weight], area.count, 1.0);
    const bool one_gone = weigh_those<false>(work.bodies, area), both_gone = weigh_those<true>(work.bodies, area),
               gone = one_gone | both_gone;
    if (!gone) return;
    constexpr int W = A::W;
    std::uint32_t kept = 0, side = 0, sides_kept = 0;
    for (std::uint32_t n = 0; n < area.count; n += W) {
        const unsigned valid = area.count - n >= W ? 0xffu : (1u << (area.count - n)) - 1,
                       weighs = bits_of(area.pack(A::weight, n) > Pack<W>(0.0));
        unsigned keep = weighs & valid;
        for (; side < area.sides && area.side[side] < n + W; ++side) { // near-parallel ones stay, which have more than that
            const unsigned bit = 1u << (area.side[side] - n);
            keep |= bit;
            area.side[sides_kept++] = kept + static_cast<std::uint32_t>(std::popcount(keep & (bit - 1)));
        }
        for (unsigned left = valid & ~keep; left != 0; left &= left - 1)
            if (const std::uint32_t pair = area.index[n + static_cast<std::uint32_t>(std::countr_zero(left))];
                status_[pair] & touching)
                area.ended.push_back(pair);
        area.keep(n, keep, kept);
        kept += static_cast<std::uint32_t>(std::popcount(keep));
    }
    area.count = kept;
    area.sides = sides_kept;
}

/// Of a pair that did not touch: the spring of the pair at the neighbour that it shares its contact with, if that touched; else the
/// pair's own.
Contacts::Followed Contacts::spring_at_vertex(const Exposure& bodies, std::uint32_t pair, int da, int db, std::uint32_t own) const {
    const auto take = [&](PairList::Neighbour n, std::uint32_t else_) {
        const std::uint32_t at = n.is_candidate ? n.pair : pair;
        return n.is_candidate & ((status_[at] & touching) != 0) ? at : else_;
    };
    std::uint32_t from = take(list_.beyond(pair, db == 0 ? 0 : da, db), own);
    from = take(list_.beside(pair, db), from);
    from = take(list_.beyond(pair, da, 0), from);
    return has_rings_ ? spring_at_seam(bodies, pair, da, db, {from}) : Followed{from};
}

/// The element before or behind (step -1, 1) that of a slot, where a ring closes between them.
std::optional<std::uint32_t> Contacts::beyond_seam(const Exposure& bodies, std::uint32_t slot, int step) const {
    const std::int32_t ring = scene_.gaps[static_cast<std::size_t>(bodies.at(slot).group)].ring;
    if (ring == 0 || step == 0 || bodies.element(slot) != (step < 0 ? 0 : ring - 1)) return {};
    return bodies.find(bodies.in_scene(slot) - step * (ring - 1));
}

/// The same where a ring closes at the vertex: neighbours are then no neighbours by number. Elements of one ring may stand in the
/// other order beyond, where what is 1 in the law is 2 here. `otherwise`: where none closes.
Contacts::Followed Contacts::spring_at_seam(const Exposure& bodies, std::uint32_t pair, int da, int db, Followed otherwise) const {
    const auto [a, b] = list_.pair[pair];
    const auto next_a = beyond_seam(bodies, a, da), next_b = beyond_seam(bodies, b, db);
    if (!next_a && !next_b) return otherwise;
    Followed from = otherwise;
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
FrictionSpring<double> Contacts::followed_spring(const Exposure& bodies, std::uint32_t pair, double s, double t) const {
    constexpr FrictionSpring<double> none{{0, 0, 0}, 0};
    const unsigned vertices = list_.vertices[pair];
    const double reach = bodies.scene().vertex_reach();
    const int da = vertex_side(s, vertices, reach), db = vertex_side(t, vertices >> 2, reach);
    if ((da | db) == 0 || kinds_.friction != ContactFriction::memory) return none;
    const auto nothing = static_cast<std::uint32_t>(list_.count());
    const Followed followed = spring_at_vertex(bodies, pair, da, db, nothing);
    if (followed.pair == nothing) return none;
    FrictionSpring<double> spring = memory_[followed.pair].spring;
    if (followed.turned) spring.x = -spring.x;
    return spring;
}

/// Before any memory or status of the block's pairs changes.
void Contacts::follow_springs(const Work& work, const WorkArea& area) {
    if (!area.begins || kinds_.friction != ContactFriction::memory) return;
    for (std::uint32_t n = 0; n < area.count; ++n)
        if (const std::uint32_t pair = area.index[n]; !(status_[pair] & touching))
            memory_[pair].spring = followed_spring(work.bodies, pair, area[WorkArea::s][n], area[WorkArea::t][n]);
}

} // namespace skein
