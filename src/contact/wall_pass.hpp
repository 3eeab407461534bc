// Walls on the rods of one group.                                                                           theory.md (53)-(56)
// Points of a rod touch walls, as balls: which they are, and what a load on one does, says `Points` (wall_points.hpp).
// The wall is body 2 of the contact law: of infinite mass, its surface at distance d of the node, overlap g = r - d, n towards it;
// so the arm is r - g/2, to the middle of the overlap, as between rods. The point's surface moves at v + w x arm. A tile whose box
// is away from all walls costs no more than the box, a node no more than looking at the walls that the box is near. Springs are
// kept by tile, node and wall, touched only where nodes touch. Cost: 7 flop per element where nothing is near; per plane near 5,
// per tube 19, per ball 10; 250 per node and wall that touch.
#pragma once

#include "contact/contact_limits.hpp"
#include "contact/wall_contacts.hpp"
#include "contact/wall_points.hpp"

#include <array>
#include <bit>
#include <memory>

namespace skein {

/// A wall at one step.
struct WallNow {
    WallKind kind;
    WallSide side;
    Vec3d point, direction; ///< normal or axis
    double level;           ///< direction.point
    double radius;
    double width; ///< of rods, over their own: 0 where their axis touches
    Vec3d velocity;
    ContactKinds kinds;
    ContactNumbers<double> law;
    double backward, sideways; ///< coefficients of anisotropic friction over that forward
};

template <int W, class Points = RodNodes<W>> class WallPass final : public TilePass<W> {
public:
    WallPass(std::shared_ptr<const Walls> walls, const RodGroup& group, std::shared_ptr<WallContactTiles<W>> contacts)
        : walls_(std::move(walls)), contacts_(std::move(contacts)), points_(group) {
        for (const int w : contacts_->acting()) {
            law_.push_back(walls_->wall[static_cast<std::size_t>(w)].law.resolved(mass_at_wall(group)));
        }
    }

    void bind(const RodTile<W>& rod) override { contacts_->add_tile(rod); }

    /// Walls at all steps of the batch: driven ones where their states say now.
    void prepare(std::span<const Step> steps) override {
        now_.resize(std::max(now_.size(), static_cast<std::size_t>(steps.back().slot + 1) * acting()));
        for (const Step& step : steps)
            for (std::size_t i = 0; i < acting(); ++i) {
                const auto at = static_cast<std::size_t>(contacts_->acting()[i]);
                const Wall& wall = walls_->wall[at];
                const WallState state = walls_->at(at, step.time);
                const Vec3d point = wall.point + state.offset, direction = wall.kind == WallKind::tube ? wall.axis : wall.normal;
                now_[static_cast<std::size_t>(step.slot) * acting() + i] = {wall.kind,
                                                                            wall.side,
                                                                            point,
                                                                            direction,
                                                                            dot(direction, point),
                                                                            wall.radius,
                                                                            wall.touches == WallTouch::axis ? 0.0 : 1.0,
                                                                            state.velocity,
                                                                            {wall.law.normal, wall.law.friction},
                                                                            law_[i].at(step.time).numbers(),
                                                                            wall.law.over_forward(wall.law.kinetic_backward),
                                                                            wall.law.over_forward(wall.law.kinetic_sideways)};
            }
    }

    void append_memory(const RodTile<W>& rod, int lane, std::vector<double>& numbers) const override {
        contacts_->of_tile(rod.number).append_memory(lane, numbers);
    }
    std::size_t recall(const RodTile<W>& rod, int lane, std::span<const double> numbers) override {
        return contacts_->of_tile(rod.number).recall(lane, numbers);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        if (acting() == 0) return;
        const WallNow* wall = &now_[static_cast<std::size_t>(step.slot) * acting()];
        TileContacts& contacts = contacts_->of_tile(rod.number);
        const Box box = box_of(rod);
        find_near(wall, box, contacts);
        contacts.looked_at.clear();
        for (std::size_t w = 0; w < acting(); ++w) {
            if (!contacts.near[w] && !contacts.held[w]) continue;
            contacts.looked_at.push_back(w);
            if (contacts.held[w]) contacts.entry[w] = Entry{};
            contacts.held[w] = 0;
        }
        if (contacts.looked_at.empty()) return;

        Batch batch;
        for (int i = 0; i < points_.count(rod); ++i) {
            const Vec3<P> at = points_.position(rod, i);
            const P radius(points_.radius(rod, i));
            for (const std::size_t w : contacts.looked_at) {
                std::uint8_t& touched = contacts.touched[static_cast<std::size_t>(i) * acting() + w];
                unsigned now = 0;
                if (contacts.near[w]) {
                    const Surface s = surface(wall[w], at);
                    now = bits_of(P(wall[w].width) * radius > s.distance);
                    for (unsigned bits = now; bits != 0; bits &= bits - 1) {
                        const int l = std::countr_zero(bits);
                        if (batch.count == Batch::most || (batch.count > 0 && !alike(wall[batch.touch[0].wall], wall[w])))
                            push(rod, load, step.kick, wall, contacts, batch);
                        batch.touch[batch.count++] = {i, l, w, s.distance[l], lane(s.towards, l)};
                        __builtin_prefetch(&contacts.memory_at(i, w, l), 1);
                    }
                }
                for (unsigned gone = touched & ~now; gone != 0; gone &= gone - 1) contacts.let_go(i, w, std::countr_zero(gone));
                touched = static_cast<std::uint8_t>(now);
                contacts.held[w] = static_cast<std::uint8_t>(contacts.held[w] | (now != 0));
            }
        }
        if (batch.count > 0) push(rod, load, step.kick, wall, contacts, batch);
    }

private:
    using P = Pack<W>;
    using Entry = typename WallContactTiles<W>::Entry;
    using TileContacts = typename WallContactTiles<W>::TileContacts;

    /// Where the nodes of a tile are, and how far from a wall the thickest may be that touches it.
    struct Box {
        Vec3<P> low, high;
        P reach;
    };
    std::size_t acting() const { return contacts_->acting().size(); }

    /// A point of one lane that touches a wall.
    struct Touch {
        int point, lane;
        std::size_t wall;
        double distance;
        Vec3d towards; ///< the wall
    };
    /// Walls of one kind of law, points in order.
    struct Batch {
        static constexpr int most = 8;
        Touch touch[most];
        int count = 0;
    };
    static bool alike(const WallNow& x, const WallNow& y) {
        return x.kinds.normal == y.kinds.normal && x.kinds.friction == y.kinds.friction;
    }

    SKEIN_INLINE static void widen(Box& box, const Vec3<P>& x) {
        box.low = {min(box.low.x, x.x), min(box.low.y, x.y), min(box.low.z, x.z)};
        box.high = {max(box.high.x, x.x), max(box.high.y, x.y), max(box.high.z, x.z)};
    }
    Box box_of(const RodTile<W>& rod) const {
        const Vec3<P> first = points_.position(rod, 0);
        Box box{first, first, P(points_.largest_radius() * (1 + 1e-6))}; // a margin for round-off
        for (int i = 1; i < points_.count(rod); ++i) widen(box, points_.position(rod, i));
        return box;
    }
    /// Marks the walls that the box is near. Round-off is monotonic: no node of the box is nearer to a plane than its corner.
    void find_near(const WallNow* wall, const Box& box, TileContacts& contacts) const {
        const Vec3<P> half = P(0.5) * (box.high - box.low), middle = P(0.5) * (box.high + box.low);
        for (std::size_t w = 0; w < acting(); ++w) {
            const WallNow& one = wall[w];
            P room;
            if (one.kind == WallKind::plane) {
                const Vec3d& n = one.direction;
                const Vec3<P> corner{n.x > 0 ? box.low.x : box.high.x, n.y > 0 ? box.low.y : box.high.y,
                                     n.z > 0 ? box.low.z : box.high.z};
                room = dot(broadcast<W>(n), corner) - P(one.level) - box.reach;
            } else {
                const P from = norm(away(one, middle)), size = norm(half) + box.reach;
                room = one.side == WallSide::inside ? P(one.radius) - from - size : from - size - P(one.radius);
            }
            contacts.near[w] = any(room < P(0.0));
        }
    }

    /// From the axis of a tube or the centre of a ball.
    SKEIN_INLINE static Vec3<P> away(const WallNow& wall, const Vec3<P>& x) {
        const Vec3<P> y = x - broadcast<W>(wall.point), a = broadcast<W>(wall.direction);
        return wall.kind == WallKind::tube ? y - dot(y, a) * a : y;
    }
    struct Surface {
        P distance;      ///< of the node's axis
        Vec3<P> towards; ///< the wall
    };
    static Surface surface(const WallNow& wall, const Vec3<P>& x) {
        if (wall.kind == WallKind::plane)
            return {dot(broadcast<W>(wall.direction), x) - P(wall.level), -broadcast<W>(wall.direction)};
        const Vec3<P> y = away(wall, x);
        const P from = norm(y);
        const double sign = wall.side == WallSide::inside ? 1 : -1;
        return {P(sign) * (P(wall.radius) - from), (P(sign) / max(from, P(1e-300))) * y};
    }

    /// Forces of a batch, which is empty then; sums run from first to last.
    [[gnu::noinline]] void push(const RodTile<W>& rod, SlotLoad<W>* load, double h, const WallNow* wall, TileContacts& contacts,
                                Batch& batch) const {
        constexpr int N = Batch::most;
        using Q = Pack<N>;
        typename Points::template Touching<N> points;
        NumberLanes<N> distance, radius, law[7], stiffness, weight, backward, sideways;
        VectorLanes<N> towards, velocity, spring, viscous_part;
        for (int n = 0; n < N; ++n) { // spare lanes repeat the first
            const Touch& touch = batch.touch[n < batch.count ? n : 0];
            const WallNow& one = wall[touch.wall];
            points.put(n, points_, rod, touch.point, touch.lane);
            radius.at[n] = points.radius.at[n];
            points.radius.at[n] *= one.width;
            distance.at[n] = touch.distance;
            towards.put(n, touch.towards);
            velocity.put(n, one.velocity);
            const ContactMemory<double>& last = contacts.memory_at(touch.point, touch.wall, touch.lane);
            spring.put(n, last.spring.x), stiffness.at[n] = last.spring.stiffness;
            viscous_part.put(n, last.viscous_part), weight.at[n] = last.weight;
            const auto numbers = std::bit_cast<std::array<double, 7>>(one.law);
            for (std::size_t i = 0; i < numbers.size(); ++i) law[i].at[n] = numbers[i];
            backward.at[n] = one.backward, sideways.at[n] = one.sideways;
        }
        ContactState<Q> state{};
        points.describe(state);
        state.normal = towards.pack(), state.distance = distance.pack(), state.velocity_2 = velocity.pack();
        ContactMemory<Q> memory{{spring.pack(), stiffness.pack()}, viscous_part.pack(), weight.pack()};
        const ContactKinds kinds = wall[batch.touch[0].wall].kinds;
        const Lie<Q> lie{points.axis(), backward.pack(), sideways.pack()};
        const ContactForce<Q> out = contact_force<N>(
            kinds, {law[0].pack(), law[1].pack(), law[2].pack(), law[3].pack(), law[4].pack(), law[5].pack(), law[6].pack()}, state,
            h, memory, {}, Q(0.0), kinds.friction == ContactFriction::anisotropic ? &lie : nullptr);
        points.push(out.on_1, out.arm_1 * out.moment);
        spring.take(memory.spring.x), stiffness.take(memory.spring.stiffness);
        viscous_part.take(memory.viscous_part), weight.take(memory.weight);
        VectorLanes<N> force;
        NumberLanes<N> friction_work, viscous_work, normal, energy, overlap, slope;
        force.take(out.on_1), friction_work.take(out.friction_work), viscous_work.take(out.viscous_work);
        normal.take(out.normal), energy.take(out.elastic_energy), slope.take(out.stiffness);
        overlap.take(max(state.radius_1 - state.distance, Q(0.0)) / (radius.pack() + radius.pack()));
        for (int n = 0; n < batch.count; ++n) {
            const Touch& touch = batch.touch[n];
            const int l = touch.lane;
            points.add(n, rod, load, touch.point, l);
            contacts.memory_at(touch.point, touch.wall, l) = {{spring[n], stiffness.at[n]}, viscous_part[n], weight.at[n]};
            const auto add = [&](P& to, double more) { to.set(l, to[l] + more); };
            const auto raise = [&](P& to, double other) { to.set(l, std::max(to[l], other)); };
            typename WallContactTiles<W>::Work& work = contacts.work[touch.wall];
            add(work.friction, friction_work.at[n]), add(work.viscous, viscous_work.at[n]);
            Entry& e = contacts.entry[touch.wall];
            add_to_lane(e.force, l, -force[n]);
            add(e.normal, normal.at[n]), add(e.touching, 1), add(e.elastic_energy, energy.at[n]);
            raise(e.max_overlap, overlap.at[n]), raise(e.stiffness, slope.at[n]);
        }
        batch.count = 0;
    }

    std::shared_ptr<const Walls> walls_;
    std::shared_ptr<WallContactTiles<W>> contacts_;
    Points points_;
    std::vector<ContactLaw> law_; ///< by wall that acts
    std::vector<WallNow> now_;    ///< [slot of the step][wall]
};

} // namespace skein
