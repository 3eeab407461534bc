// Near-parallel pairs: they push at the two ends of their overlap, and at the nearest points with what is left of the
// normal force and all friction. Turning them against each other changes the shares, and with these the energy, which
// is a couple; so does sliding, where an overlap that ends at a vertex counts by its length. theory.md (56b), (56e)
#include "contact/overlap.hpp"
#include "contact/work_area.hpp"

namespace skein {

using detail::across, detail::between, detail::edge;

/// Of pairs by themselves; `vertices`: of each, see vertices_of_pair. The other numbers are those of the nearest
/// points; where elements are not near-parallel there is nothing at the ends.
template <int N> Contacts::Ends<N> Contacts::at_ends(const Exposure& bodies, double h, const Pair* pair,
                                                     const std::uint8_t* vertices, Pack<N> sine_squared, Pack<N> weight,
                                                     Pack<N> vertex_energy, Pack<N> distance) const {
    using Q = Pack<N>;
    struct Element {
        Vec3<Q> node[2], edge, velocity[2], spin;
        Q radius, squared;
        VertexMasks<N> vertices;
    } of[2];
    for (const int body : {0, 1}) {
        Element& e = of[body];
        const auto slot = [&](int l) { return body ? pair[l].b : pair[l].a; };
        const auto start = load_transposed<N>([&](int l) { return &bodies.node[slot(l)].position.x; });
        e.node[0] = start.vector;
        e.radius = start.behind;
        e.node[1] = load_transposed<N>([&](int l) { return &bodies.node[slot(l) + 1].position.x; }).vector;
        e.edge = e.node[1] - e.node[0];
        e.squared = max(dot(e.edge, e.edge), Q(1e-300));
        for (const int i : {0, 1}) {
            const auto next = static_cast<std::uint32_t>(i);
            e.velocity[i] = load_transposed<N>([&](int l) { return &bodies.motion[slot(l) + next].velocity.x; }).vector;
            unsigned bits = 0;
            for (int l = 0; l < N; ++l) bits |= (vertices[l] >> (2 * body + i) & 1u) << l;
            e.vertices.at[i] = where_set<N>(bits, 1.0) > Q(0.0);
        }
        e.spin = load_transposed<N>([&](int l) { return &bodies.motion[slot(l)].spin.x; }).vector;
    }
    const Element &e1 = of[0], &e2 = of[1];
    const Q zero(0.0), half(0.5), one(1.0), both = e1.radius + e2.radius, along = dot(e1.edge, e2.edge);
    const auto same_way = along > zero;
    const ContactNumbers<Q> law = numbers<N>(bodies, pair);
    const auto energy_at = [&](Q at_distance) {
        return normal_energy(kinds_.normal, law.stiffness, both - at_distance);
    };
    // 1 where parallel; without a kink at the edge, where the couple would jump.
    const auto near_parallel = (sine_squared < Q(blend * blend)) & (min(e1.squared, e2.squared) > Q(1e-300));
    const Q near = select(near_parallel, one - sine_squared / Q(blend * blend), zero), share = near * near;

    struct End {
        Q s, t, distance;
        Vec3<Q> normal;
    } end[2];
    for (const int k : {0, 1}) { // the end of one and its foot on the other, whichever are nearer
        const Vec3<Q>&at_1 = e1.node[k], at_2 = select(same_way, e2.node[k], e2.node[1 - k]);
        const Q foot_2 = clamp01(dot(at_1 - e2.node[0], e2.edge) / e2.squared),
                foot_1 = clamp01(dot(at_2 - e1.node[0], e1.edge) / e1.squared);
        const Vec3<Q> of_1 = fma(foot_2, e2.edge, e2.node[0]) - at_1, of_2 = at_2 - fma(foot_1, e1.edge, e1.node[0]);
        const auto nearer = dot(of_1, of_1) <= dot(of_2, of_2);
        const Q here(k), there(1 - k);
        const Vec3<Q> apart = select(nearer, of_1, of_2);
        end[k] = {select(nearer, here, foot_1), select(nearer, foot_2, select(same_way, here, there)), norm(apart), {}};
        const auto met = end[k].distance < Q(1e-150);
        end[k].normal = (one / max(end[k].distance, Q(1e-150))) * apart;
        if (any(met)) end[k].normal = select(met, across<N>(e1.edge, e2.edge), end[k].normal);
    }
    const Q energy_of_ends = half * (energy_at(end[0].distance) + energy_at(end[1].distance));
    const Overlap<Q> overlap[2] = {
        overlap_on(e1.node[0], e1.edge, e2.node[0], e2.edge, same_way, e1.vertices, e2.vertices),
        overlap_on(e2.node[0], e2.edge, e1.node[0], e1.edge, same_way, e2.vertices, e1.vertices)};
    const Q beside = half * (overlap[0].share + overlap[1].share);
    Ends<N> out{};
    out.normal_weight = (one - share) * weight;
    out.weight_of_all = fma(share, beside, out.normal_weight);
    ElementLoad<Q> on[2]{};
    for (const int body : {0, 1})
        for (const int i : {0, 1}) {
            const Element &e = of[body], &o = of[1 - body];
            const Q foot = overlap[body].foot[i],
                    per_length = half * share * energy_of_ends * overlap[body].change[i] / e.squared;
            const Vec3<Q> end_of_other = select(same_way, o.node[i], o.node[1 - i]), pull = per_length * e.edge,
                          turn = per_length * (end_of_other - fma(foot, e.edge, e.node[0]));
            on[body].first += (one - foot) * pull + turn;
            on[body].second += foot * pull - turn;
            const Vec3<Q> at_first =
                select(same_way, i == 0 ? pull : Vec3<Q>{zero, zero, zero}, i == 0 ? Vec3<Q>{zero, zero, zero} : pull);
            on[1 - body].first -= at_first;
            on[1 - body].second -= pull - at_first;
        }
    const Q of_end = half * share * beside;
    for (const End& e : end) {
        const ContactState<Q> state{e.normal,
                                    e.distance,
                                    e1.radius,
                                    e2.radius,
                                    between(e1.velocity[0], e1.velocity[1], e.s),
                                    e1.spin,
                                    between(e2.velocity[0], e2.velocity[1], e.t),
                                    e2.spin};
        ContactMemory<Q> none{};
        const auto f = contact_force<N>({kinds_.normal, ContactFriction::none}, law, state, h, none, {of_end, of_end});
        out.elsewhere += f.normal;
        out.elastic_energy += f.elastic_energy;
        out.viscous_work += f.viscous_work + f.viscous_work;
        out.stiffness = max(out.stiffness, f.stiffness);
        on[0].first += (one - e.s) * f.on_1;
        on[0].second += e.s * f.on_1;
        on[0].couple += f.arm_1 * f.moment;
        on[1].first -= (one - e.t) * f.on_1;
        on[1].second -= e.t * f.on_1;
        on[1].couple += f.arm_2 * f.moment;
    }
    // How the energy changes with the share, times how the share changes as elements turn.
    const Q per_share = beside * energy_of_ends - fma(weight, energy_at(distance), vertex_energy),
            per_cosine = Q(4 / (blend * blend)) * near * along / max(e1.squared * e2.squared, Q(1e-300));
    const Vec3<Q> turn_1 = (per_share * per_cosine) * (e2.edge - (along / e1.squared) * e1.edge),
                  turn_2 = (per_share * per_cosine) * (e1.edge - (along / e2.squared) * e2.edge);
    on[0].first += turn_1;
    on[0].second -= turn_1;
    on[1].first += turn_2;
    on[1].second -= turn_2;
    out.on_1 = on[0];
    out.on_2 = on[1];
    return out;
}

void Contacts::push_sides(const Work& work, WorkArea& area, Sums& sums) {
    using A = WorkArea;
    constexpr int W = A::W;
    using P = Pack<W>;
    for (std::uint32_t i = 0; i < area.sides; i += W) {
        const std::uint32_t valid = std::min<std::uint32_t>(W, area.sides - i);
        std::uint32_t at[W];
        Pair pair[W];
        std::uint8_t vertices[W];
        P sine_squared, weight, vertex_energy, distance;
        unsigned mine = 0;
        for (std::uint32_t l = 0; l < W; ++l) {
            at[l] = area.side[i + (l < valid ? l : 0)];
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
            // What is between the vectors is nobody's. (With a constant 0 there GCC 12 was seen to store the vector's z
            // in its place.)
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
        const Vec3d apart = bodies.node[a].position - bodies.node[b].position; // of ends, farther than the sum of all
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
