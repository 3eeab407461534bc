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

#include <memory>

namespace skein {

/// A wall at one step.
struct WallNow {
    WallKind kind;
    WallSide side;
    Vec3d point, direction; ///< normal or axis
    double level;           ///< direction.point
    double radius;
    Vec3d velocity;
    ContactKinds kinds;
    ContactNumbers<double> law;
};

template <int W, class Points = RodNodes<W>> class WallPass final : public TilePass<W> {
public:
    WallPass(std::shared_ptr<const Walls> walls, const RodGroup& group, std::shared_ptr<WallContactTiles<W>> contacts)
        : walls_(std::move(walls)), contacts_(std::move(contacts)), points_(group) {
        for (const int w : contacts_->acting()) {
            law_.push_back(walls_->wall[static_cast<std::size_t>(w)].law.resolved(mass_at_wall(group)));
            has_friction_ = has_friction_ || law_.back().friction != ContactFriction::none;
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
                                                                            state.velocity,
                                                                            {wall.law.normal, wall.law.friction},
                                                                            law_[i].at(step.time).numbers()};
            }
    }

    std::span<Pack<W>> memory(const RodTile<W>& rod) override {
        TileContacts& contacts = contacts_->of_tile(rod.number);
        return {&contacts.kept.data()->of_last.spring.x.x, sizeof(Kept) / sizeof(P) * contacts.kept.size()};
    }
    void recall(const RodTile<W>& rod) override { // what is put back has to be looked at
        TileContacts& contacts = contacts_->of_tile(rod.number);
        std::fill(contacts.touched.begin(), contacts.touched.end(), std::uint8_t{1});
        contacts.any_touched = true;
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        if (acting() == 0) return;
        const WallNow* wall = &now_[static_cast<std::size_t>(step.slot) * acting()];
        TileContacts& contacts = contacts_->of_tile(rod.number);
        const Box box = box_of(rod);
        if (contacts.busy) {
            std::fill(contacts.entry.begin(), contacts.entry.end(), Entry{});
            contacts.busy = false;
        }
        if (!find_near(wall, box, contacts) && !contacts.any_touched) return;

        contacts.any_touched = false;
        typename Points::Behind behind;
        for (int i = 0; i < points_.count(rod); ++i) {
            const Vec3<P> at = points_.position(rod, i);
            if (reaches(wall, contacts, at, box.reach)) {
                contacts.busy = true;
                contacts.any_touched = true;
                touch(rod, load, step.kick, wall, i, at, contacts, behind);
            } else {
                forget(contacts, i);
            }
        }
    }

private:
    using P = Pack<W>;
    using Entry = typename WallContactTiles<W>::Entry;
    using Kept = typename WallContactTiles<W>::Kept;
    using TileContacts = typename WallContactTiles<W>::TileContacts;
    static_assert(sizeof(Kept) % sizeof(P) == 0);

    /// Where the nodes of a tile are, and how far from a wall the thickest may be that touches it.
    struct Box {
        Vec3<P> low, high;
        P reach;
    };
    std::size_t acting() const { return contacts_->acting().size(); }

    /// The energy of its springs counts as friction work when a node leaves its walls.
    static void let_go(Kept& kept, Mask<W> where) {
        const P none(0.0);
        ContactMemory<P>& m = kept.of_last;
        kept.friction_work += select(where, m.energy(), none);
        m = {{select(where, Vec3<P>{}, m.spring.x), select(where, none, m.spring.stiffness)},
             select(where, Vec3<P>{}, m.viscous_part),
             select(where, none, m.weight)};
    }
    void forget(TileContacts& contacts, int i) const {
        for (std::size_t w = 0; w < acting(); ++w) forget(contacts, i, w);
    }
    void forget(TileContacts& contacts, int i, std::size_t w) const {
        const std::size_t at = static_cast<std::size_t>(i) * acting() + w;
        if (!contacts.touched[at]) return;
        let_go(contacts.kept[at], P(1.0) > P(0.0));
        contacts.touched[at] = 0;
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
    bool find_near(const WallNow* wall, const Box& box, TileContacts& contacts) const {
        const Vec3<P> half = P(0.5) * (box.high - box.low), middle = P(0.5) * (box.high + box.low);
        bool found = false;
        for (std::size_t w = 0; w < acting(); ++w) {
            const WallNow& one = wall[w];
            P room;
            if (one.kind == WallKind::plane) {
                const Vec3d& n = one.direction;
                const Vec3<P> corner{n.x > 0 ? box.low.x : box.high.x, n.y > 0 ? box.low.y : box.high.y,
                                     n.z > 0 ? box.low.z : box.high.z};
                room = margin(one, corner, box.reach);
            } else {
                const P from = norm(away(one, middle)), size = norm(half) + box.reach;
                room = one.side == WallSide::inside ? P(one.radius) - from - size : from - size - P(one.radius);
            }
            contacts.near[w] = any(room < P(0.0));
            found = found || contacts.near[w];
        }
        return found;
    }

    /// From the axis of a tube or the centre of a ball.
    SKEIN_INLINE static Vec3<P> away(const WallNow& wall, const Vec3<P>& x) {
        const Vec3<P> y = x - broadcast<W>(wall.point), a = broadcast<W>(wall.direction);
        return wall.kind == WallKind::tube ? y - dot(y, a) * a : y;
    }
    /// Below 0 where a node of radius `reach` touches the wall.
    SKEIN_INLINE static P margin(const WallNow& wall, const Vec3<P>& x, P reach) {
        if (wall.kind == WallKind::plane) return dot(broadcast<W>(wall.direction), x) - P(wall.level) - reach;
        const Vec3<P> y = away(wall, x);
        const P bound = wall.side == WallSide::inside ? P(wall.radius) - reach : P(wall.radius) + reach;
        return wall.side == WallSide::inside ? bound * abs(bound) - dot(y, y) : dot(y, y) - bound * bound;
    }
    SKEIN_INLINE bool reaches(const WallNow* wall, const TileContacts& contacts, const Vec3<P>& x, P reach) const {
        P least(1.0);
        for (std::size_t w = 0; w < acting(); ++w)
            if (contacts.near[w]) least = min(least, margin(wall[w], x, reach));
        return any(least < P(0.0));
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

    [[gnu::noinline]] void touch(const RodTile<W>& rod, SlotLoad<W>* load, double h, const WallNow* wall, int i, const Vec3<P>& at,
                                 TileContacts& contacts, typename Points::Behind& behind) const {
        const P zero(0.0);
        ContactState<P> state{};
        points_.describe(rod, i, state, behind);

        Vec3<P> force{}, couple{};
        Mask<W> touched = zero > zero;
        for (std::size_t w = 0; w < acting(); ++w) {
            const std::size_t kept_at = static_cast<std::size_t>(i) * acting() + w;
            const Surface s = contacts.near[w] ? surface(wall[w], at) : Surface{};
            const Mask<W> touches = contacts.near[w] ? state.radius_1 > s.distance : zero > zero;
            if (!any(touches)) {
                forget(contacts, i, w);
                continue;
            }
            Kept& kept = contacts.kept[kept_at];
            contacts.touched[kept_at] = 1;
            touched = touched | touches;
            state.normal = s.towards;
            state.distance = s.distance;
            state.velocity_2 = broadcast<W>(wall[w].velocity);
            const FrictionSpring<P> from = kept.of_last.spring;
            const ContactForce<P> out = contact_force<W>(wall[w].kinds, wall[w].law.template as<P>(), state, h, kept.of_last, from);
            kept.friction_work += out.friction_work;
            kept.viscous_work += out.viscous_work;
            force += out.on_1;
            couple += out.arm_1 * out.moment;
            enter(contacts.entry[w], state, out, touches);
        }
        // Where nothing touches not even a zero is added: it would turn -0 into 0, and other lanes decide whether this is reached.
        points_.push(rod, load, i, force, couple, touched, has_friction_);
    }

    static void enter(Entry& e, const ContactState<P>& in, const ContactForce<P>& out, Mask<W> touches) {
        const P zero(0.0);
        e.force -= out.on_1;
        e.normal += out.normal;
        e.touching += select(touches, P(1.0), zero);
        e.max_overlap = max(e.max_overlap, max(in.radius_1 - in.distance, zero) / (in.radius_1 + in.radius_1));
        e.stiffness = max(e.stiffness, out.stiffness);
        e.elastic_energy += out.elastic_energy;
    }

    std::shared_ptr<const Walls> walls_;
    std::shared_ptr<WallContactTiles<W>> contacts_;
    Points points_;
    bool has_friction_ = false;
    std::vector<ContactLaw> law_; ///< by wall that acts
    std::vector<WallNow> now_;    ///< [slot of the step][wall]
};

} // namespace skein
