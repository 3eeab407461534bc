// Near-parallel pairs push at both ends of their overlap, and at the nearest points with the rest of the normal force
// and all friction.                                                                      theory.md (56b), (56e)
//
//   e1  o=====|=======o              a = (1 - S/b^2)^2, S the squared sine of the angle, b = `blend`; 0 beyond b
//         end 1|      | end 2        E_0 = w phi(d) + E_v, nearest points with the weight and energy of vertices (56c)
//   e2         o======|=====o        E_k = phi(d_k), an end of one element and its foot on the other, the nearer such
//
//   E = (1 - a) E_0 + a L (E_1 + E_2)/2,   L = (lambda_1 + lambda_2)/2 by overlap.hpp
//
// Forces are minus the gradient of E, so the energy is kept when elements turn or slide along each other:
//   ends      springs of E_1 and E_2 with the weight a L/2, and their dashpots
//   overlap   -a (E_1 + E_2)/2 dL/df df/dx,  f = (x - x_0).e/e^2 the foot of the other's end x on this line
//   turning   -(L (E_1 + E_2)/2 - E_0) da/de_i,
//             da/de_1 = 4 sqrt(a)/b^2 (e1.e2)/(e1^2 e2^2) (e2 - (e1.e2)/e1^2 e1)
#include "contact/contact_tangent.hpp"
#include "contact/overlap.hpp"
#include "contact/work_area.hpp"

namespace skein {

using detail::across, detail::between, detail::edge;

namespace {

/// First or second elements of N pairs.
template <int N> struct PairElements {
    Vec3<Pack<N>> node[2], edge, velocity[2], spin;
    Pack<N> radius, squared; ///< m, m^2: the edge's length, squared
    VertexMasks<N> vertices;
};

/// Elements of pairs whose slots are slot(lane); `vertices`: bits of vertices_of_pair() by pair, from `first_bit` on.
template <int N, class SlotOf> SKEIN_INLINE PairElements<N>
elements_at(const Exposure& bodies, const std::uint8_t* vertices, int first_bit, SlotOf&& slot) {
    PairElements<N> e;
    const auto start = load_transposed<N>([&](int l) { return &bodies.node[slot(l)].position.x; });
    e.node[0] = start.vector;
    e.radius = start.fourth;
    e.node[1] = load_transposed<N>([&](int l) { return &bodies.node[slot(l) + 1].position.x; }).vector;
    e.edge = e.node[1] - e.node[0];
    e.squared = max(dot(e.edge, e.edge), Pack<N>(1e-300));
    for (const int i : {0, 1}) {
        const auto next = static_cast<std::uint32_t>(i);
        e.velocity[i] = load_transposed<N>([&](int l) { return &bodies.motion[slot(l) + next].velocity.x; }).vector;
        unsigned bits = 0;
        for (int l = 0; l < N; ++l) bits |= (vertices[l] >> (first_bit + i) & 1u) << l;
        e.vertices.at[i] = where_set<N>(bits, 1.0) > Pack<N>(0.0);
    }
    e.spin = load_transposed<N>([&](int l) { return &bodies.motion[slot(l)].spin.x; }).vector;
    return e;
}

/// An end of the overlap: places on both elements, their distance, m, and the unit vector from the first.
template <int N> struct OverlapEnd {
    Pack<N> s, t, distance;
    Vec3<Pack<N>> normal;
};

/// End k of the first element with its foot on the second, or the second's end there with its foot on the first.
template <int N>
OverlapEnd<N> end_of_overlap(const PairElements<N>& e1, const PairElements<N>& e2, const Mask<N>& same_way, int k) {
    using Q = Pack<N>;
    const Vec3<Q>&at_1 = e1.node[k], at_2 = select(same_way, e2.node[k], e2.node[1 - k]);
    const Q foot_2 = clamp01(dot(at_1 - e2.node[0], e2.edge) / e2.squared),
            foot_1 = clamp01(dot(at_2 - e1.node[0], e1.edge) / e1.squared);
    const Vec3<Q> from_1 = fma(foot_2, e2.edge, e2.node[0]) - at_1, from_2 = at_2 - fma(foot_1, e1.edge, e1.node[0]);
    const auto nearer = dot(from_1, from_1) <= dot(from_2, from_2);
    const Q here(k), there(1 - k);
    const Vec3<Q> apart = select(nearer, from_1, from_2);
    OverlapEnd<N> end{
        select(nearer, here, foot_1), select(nearer, foot_2, select(same_way, here, there)), norm(apart), {}};
    const auto met = end.distance < Q(1e-150);
    end.normal = (Q(1.0) / max(end.distance, Q(1e-150))) * apart;
    if (any(met)) end.normal = select(met, across<N>(e1.edge, e2.edge), end.normal);
    return end;
}

/// Adds the force of the contact at one end of the overlap, without friction.
template <int N>
void add_force(const ContactForce<Pack<N>>& f, const OverlapEnd<N>& end, ElementLoad<Pack<N>> (&on)[2]) {
    const Pack<N> one(1.0);
    on[0].first += (one - end.s) * f.on_1;
    on[0].second += end.s * f.on_1;
    on[0].couple += f.arm_1 * f.moment;
    on[1].first -= (one - end.t) * f.on_1;
    on[1].second -= end.t * f.on_1;
    on[1].couple += f.arm_2 * f.moment;
}

/// Adds the forces of an overlap that changes. `energy`: a (E_1 + E_2)/4, the derivative of E by either lambda, J.
template <int N> SKEIN_INLINE void add_change_of_overlap(const PairElements<N> (&of)[2],
                                                         const Overlap<Pack<N>> (&overlap)[2], const Mask<N>& same_way,
                                                         Pack<N> energy, ElementLoad<Pack<N>> (&on)[2]) {
    using Q = Pack<N>;
    const Q zero(0.0), one(1.0);
    const Vec3<Q> none{zero, zero, zero};
    for (const int body : {0, 1})
        for (const int i : {0, 1}) {
            const PairElements<N>&e = of[body], &o = of[1 - body];
            const Q foot = overlap[body].foot[i], per_length = energy * overlap[body].change[i] / e.squared;
            const Vec3<Q> end_of_other = select(same_way, o.node[i], o.node[1 - i]), pull = per_length * e.edge,
                          turn = per_length * (end_of_other - fma(foot, e.edge, e.node[0]));
            on[body].first += (one - foot) * pull + turn;
            on[body].second += foot * pull - turn;
            const Vec3<Q> at_first = select(same_way, i == 0 ? pull : none, i == 0 ? none : pull);
            on[1 - body].first -= at_first;
            on[1 - body].second -= pull - at_first;
        }
}

/// Adds the couples of a share a that changes as elements turn. `slope`: dE/da times da/d(e1.e2) at fixed lengths.
template <int N>
void add_turning(const PairElements<N> (&of)[2], Pack<N> along, Pack<N> slope, ElementLoad<Pack<N>> (&on)[2]) {
    for (const int body : {0, 1}) {
        const PairElements<N>&e = of[body], &o = of[1 - body];
        const Vec3<Pack<N>> turn = slope * (o.edge - (along / e.squared) * e.edge);
        on[body].first += turn;
        on[body].second -= turn;
    }
}

} // namespace

/// Forces at the ends of the overlap of N pairs. `vertices`: bits of vertices_of_pair(); `weight`, `vertex_energy` and
/// `distance`: of the nearest points. Elements that are not near-parallel have nothing at the ends.
template <int N> Contacts::Ends<N> Contacts::at_ends(const Exposure& bodies, double h, const Pair* pair,
                                                     const std::uint8_t* vertices, Pack<N> sine_squared, Pack<N> weight,
                                                     Pack<N> vertex_energy, Pack<N> distance) const {
    using Q = Pack<N>;
    const PairElements<N> of[2] = {elements_at<N>(bodies, vertices, 0, [&](int l) { return pair[l].a; }),
                                   elements_at<N>(bodies, vertices, 2, [&](int l) { return pair[l].b; })},
                          &e1 = of[0], &e2 = of[1];
    const Q zero(0.0), half(0.5), one(1.0), radii = e1.radius + e2.radius, along = dot(e1.edge, e2.edge);
    const auto same_way = along > zero;
    const ContactNumbers<Q> law = numbers<N>(bodies, pair);
    const auto energy_at = [&](Q at) { return normal_energy(kinds_.normal, law.stiffness, radii - at); };
    const auto parallel = (sine_squared < Q(blend * blend)) & (min(e1.squared, e2.squared) > Q(1e-300));
    // Squared, so that the couple does not jump where the share vanishes.
    const Q near = select(parallel, one - sine_squared / Q(blend * blend), zero), share = near * near;
    const OverlapEnd<N> end[2] = {end_of_overlap(e1, e2, same_way, 0), end_of_overlap(e1, e2, same_way, 1)};
    const Overlap<Q> overlap[2] = {
        overlap_on(e1.node[0], e1.edge, e2.node[0], e2.edge, same_way, e1.vertices, e2.vertices),
        overlap_on(e2.node[0], e2.edge, e1.node[0], e1.edge, same_way, e2.vertices, e1.vertices)};
    const Q energy = half * (energy_at(end[0].distance) + energy_at(end[1].distance)),
            lambda = half * (overlap[0].share + overlap[1].share);

    Ends<N> out{};
    out.normal_weight = (one - share) * weight;
    out.weight_of_all = fma(share, lambda, out.normal_weight);
    ElementLoad<Q> on[2]{};
    add_change_of_overlap(of, overlap, same_way, half * share * energy, on);
    const Q end_weight = half * share * lambda;
    for (const int k : {0, 1}) {
        const OverlapEnd<N>& e = end[k];
        const ContactState<Q> state{e.normal,
                                    e.distance,
                                    e1.radius,
                                    e2.radius,
                                    between(e1.velocity[0], e1.velocity[1], e.s),
                                    e1.spin,
                                    between(e2.velocity[0], e2.velocity[1], e.t),
                                    e2.spin};
        ContactMemory<Q> none{};
        const ContactKinds pushes{kinds_.normal, ContactFriction::none};
        const auto f = contact_force<N>(pushes, law, state, h, none, {end_weight, end_weight});
        if (scene_.has_tangents) {
            const auto slopes =
                contact_slopes<N>(pushes, law, state, h, f, {end_weight, end_weight}, zero, scene_.meeting_zone);
            out.tangent[k] = {e.normal, slopes.normal, turning_slope(f.normal, state), e.s, e.t, f.arm_1, f.arm_2};
        }
        out.elsewhere += f.normal;
        out.elastic_energy += f.elastic_energy;
        out.viscous_work += f.viscous_work + f.viscous_work;
        out.stiffness = max(out.stiffness, f.stiffness);
        add_force(f, e, on);
    }
    const Q per_share = lambda * energy - fma(weight, energy_at(distance), vertex_energy),
            per_cosine = Q(4 / (blend * blend)) * near * along / max(e1.squared * e2.squared, Q(1e-300));
    add_turning(of, along, per_share * per_cosine, on);
    out.on_1 = on[0];
    out.on_2 = on[1];
    return out;
}

void Contacts::push_near_parallel(const Work& work, WorkArea& area, Sums& sums) {
    using A = WorkArea;
    constexpr int W = A::W;
    using P = Pack<W>;
    for (std::uint32_t i = 0; i < area.near_parallel_count; i += W) {
        const std::uint32_t valid = std::min<std::uint32_t>(W, area.near_parallel_count - i);
        std::uint32_t at[W];
        Pair pair[W];
        std::uint8_t vertices[W];
        P sine_squared, weight, vertex_energy, distance;
        unsigned mine = 0;
        for (std::uint32_t l = 0; l < W; ++l) {
            at[l] = area.near_parallel[i + (l < valid ? l : 0)];
            pair[l] = area.pair[at[l]];
            vertices[l] = list_.vertices[area.index[at[l]]];
            const int to = static_cast<int>(l);
            sine_squared.set(to, area[A::sine_squared][at[l]]);
            weight.set(to, area[A::weight][at[l]]);
            vertex_energy.set(to, area[A::vertex_energy][at[l]]);
            distance.set(to, area[A::squared][at[l]]);
            mine |= static_cast<unsigned>(l < valid && work.bodies.owns_slot(pair[l].a)) << l;
        }
        const Ends<W> ends =
            at_ends<W>(work.bodies, work.h, pair, vertices, sine_squared, weight, vertex_energy, sqrt(distance));
        sums.add(ends.stiffness, ends.elastic_energy, P(0.0), ends.viscous_work, mine);
        LoadRow first[2][W], second[2][W]{};
        for (const int body : {0, 1}) {
            const ElementLoad<P>& on = body ? ends.on_2 : ends.on_1;
            // Numbers between the vectors are unused. (With a constant 0 there GCC 12 stored the vector's z in its
            // place.)
            store_transposed<W>(on.first, on.first.x, [&](int l) { return &first[body][l].number[0]; });
            store_transposed<W>(on.couple, on.couple.x, [&](int l) { return &first[body][l].number[4]; });
            store_transposed<W>(on.second, on.second.x, [&](int l) { return &second[body][l].number[0]; });
        }
        for (std::uint32_t l = 0; l < valid; ++l) {
            const int from = static_cast<int>(l);
            area[A::weight][at[l]] = ends.normal_weight[from];
            area[A::weight_of_all][at[l]] = ends.weight_of_all[from];
            area[A::elsewhere][at[l]] += ends.elsewhere[from];
            exert(work, pair[l].a, first[0][l], second[0][l]);
            exert(work, pair[l].b, first[1][l], second[1][l]);
        }
        if (!work.tangent) continue;
        for (const auto& end : ends.tangent) {
            const P slope = P(own_share_of_tangents) * end.slope, turning = P(own_share_of_tangents) * end.turning;
            for (std::uint32_t l = 0; l < valid; ++l) {
                const int from = static_cast<int>(l);
                const auto [x, y, z] = lane(end.normal, from);
                stiffen(work, pair[l].a, {{x, y, z, slope[from], turning[from], end.s[from], end.arm_1[from], 0}});
                stiffen(work, pair[l].b, {{x, y, z, slope[from], turning[from], end.t[from], -end.arm_2[from], 0}});
            }
        }
    }
}

struct Contacts::Points {
    ClosestPoints<Pack<1>> at;
    Pack<1> distance;
    VertexTerms<Pack<1>> vertices;
    Ends<1> ends;
};

Contacts::Points Contacts::points(const Exposure& bodies, std::uint32_t pair) const {
    const auto [a, b] = list_.pair[pair];
    Points p;
    p.at = closest_points(broadcast<1>(bodies.node[a].position), broadcast<1>(edge(bodies, a)),
                          broadcast<1>(bodies.node[b].position), broadcast<1>(edge(bodies, b)));
    p.distance = norm(p.at.apart);
    if (list_.vertices[pair] != 0 && p.distance[0] < bodies.node[a].radius + bodies.node[b].radius) {
        p.vertices = at_vertices(bodies, pair, p.at);
        p.at.s = p.vertices.share[0];
        p.at.t = p.vertices.share[1];
        p.at.apart = p.vertices.apart;
        p.distance = norm(p.at.apart);
    }
    p.ends = at_ends<1>(bodies, 0, &list_.pair[pair], &list_.vertices[pair], p.at.sine_squared, p.vertices.weight,
                        p.vertices.energy, p.distance);
    return p;
}

std::vector<double> Contacts::normal_energies(const Exposure& bodies) const {
    std::vector<double> all;
    for (std::uint32_t i = 0; i < list_.count(); ++i) {
        const auto [a, b] = list_.pair[i];
        if (!bodies.owns_slot(a)) continue;
        if (!has_box_.empty() && has_box_[i]) {
            all.push_back(normal_energy_with_box(bodies, i));
            continue;
        }
        const Vec3d apart = bodies.node[a].position - bodies.node[b].position; // bound of the distance by ends
        const double radii = bodies.node[a].radius + bodies.node[b].radius;
        if (norm(apart) > radii + norm(edge(bodies, a)) + norm(edge(bodies, b))) continue;
        const Points p = points(bodies, i);
        if (p.distance[0] >= radii) continue;
        const Pack<1> nearest =
            normal_energy(kinds_.normal, numbers<1>(bodies, &list_.pair[i]).stiffness, Pack<1>(radii) - p.distance);
        all.push_back(
            (p.ends.normal_weight * nearest + p.ends.elastic_energy + p.vertices.scale * p.vertices.energy)[0]);
    }
    return all;
}

/// A pair in contact by itself, as it is; springs pull as their memory says.
Contacts::PairContact Contacts::evaluate_pair(const Exposure& bodies, std::uint32_t pair) const {
    using Q = Pack<1>;
    const auto [a, b] = list_.pair[pair];
    const ExposedNode *a0 = &bodies.node[a], *b0 = &bodies.node[b];
    const ExposedMotion *on_a = &bodies.motion[a], *on_b = &bodies.motion[b];
    const auto [here, distance, vertices, ends] = points(bodies, pair);
    const Q s = here.s, t = here.t;
    const Vec3<Q> normal = distance[0] > 1e-150
                               ? (Q(1.0) / distance) * here.apart
                               : across<1>(broadcast<1>(edge(bodies, a)), broadcast<1>(edge(bodies, b)));
    const ContactState<Q> state{normal,
                                distance,
                                a0->radius,
                                b0->radius,
                                between(broadcast<1>(on_a[0].velocity), broadcast<1>(on_a[1].velocity), s),
                                broadcast<1>(on_a->spin),
                                between(broadcast<1>(on_b[0].velocity), broadcast<1>(on_b[1].velocity), t),
                                broadcast<1>(on_b->spin)};
    const FrictionSpring<double>& spring = memory_[pair].spring;
    ContactMemory<Q> memory{{broadcast<1>(spring.x), spring.stiffness}, {}, 0.0};
    const auto force = contact_force<1>(kinds_, numbers<1>(bodies, &list_.pair[pair]), state, 0, memory,
                                        {ends.normal_weight, ends.weight_of_all}, ends.elsewhere + vertices.normal);
    Vec3<Q> on_1 = force.on_1 + ends.on_1.first + ends.on_1.second;
    for (const Vec3<Q>& at_node : vertices.force[0]) on_1 += at_node;
    return {lane(on_1, 0), s[0], t[0], distance[0], ends.weight_of_all[0]};
}

} // namespace skein
