// Walls on the rods of one group.                                                                           theory.md (53)-(56)
// Nodes touch walls, as balls of the mean of their elements' present radii r = r0/sqrt(e) (r0 where the law keeps sections), e = |dx|/l0.
// The wall is body 2 of the contact law: of infinite mass, its surface at distance d of the node, overlap g = r - d, n towards it; so the
// arm is r - g/2, to the middle of the overlap, as between rods. The node's surface moves at v + w x arm, w the mean lab spin of its
// elements; the force goes to the node, half of the couple to each of its elements.
// Stands behind the elastic pass, whose dilatations bound the radii: a node farther from all walls than that costs no more than looking.
// Springs are kept by tile, node and wall, and touched only where nodes do.
// Cost: per plane 4 flop, per tube 18, per ball 9 where nothing is near; some 250 flop per node and wall that touch.
#pragma once

#include "contact/response.hpp"
#include "contact/wall_book.hpp"

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

template <int W> class WallPass final : public TilePass<W> {
public:
    static constexpr std::string_view pass_name = "walls";

    WallPass(std::shared_ptr<const Walls> walls, const RodGroup& group, std::shared_ptr<WallBook<W>> book)
        : walls_(std::move(walls)), book_(std::move(book)), section_shrinks_(group.law() == Law::incompressible) {
        for (const ElementConstants& e : group.element) largest_radius_ = std::max(largest_radius_, e.radius);
    }
    std::string_view name() const override { return pass_name; }

    void bind(const RodTile<W>& rod) override { book_->add_page(rod); }

    /// Walls at all steps of the batch: driven ones where their states say now.
    void prepare(std::span<const Step> steps) override {
        now_.clear();
        for (const Step& step : steps)
            for (const int w : book_->acting()) {
                const auto at = static_cast<std::size_t>(w);
                const Wall& wall = walls_->wall[at];
                const WallState state = walls_->at(at, step.time);
                const Vec3d point = wall.point + state.offset, direction = wall.kind == WallKind::tube ? wall.axis : wall.normal;
                now_.push_back({wall.kind, wall.side, point, direction, dot(direction, point), wall.radius, state.velocity, {wall.law.normal, wall.law.friction}, wall.law.at(step.time).numbers()});
            }
    }

    std::span<Vec3<Pack<W>>> memory(const RodTile<W>& rod) override {
        typename WallBook<W>::Page& page = book_->page(rod.number);
        std::fill(page.touched.begin(), page.touched.end(), std::uint8_t{1}); // what is put back has to be looked at
        return {&page.kept.data()->spring, 2 * page.kept.size()};
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        if (acting() == 0) return;
        const WallNow* wall = &now_[static_cast<std::size_t>(step.slot) * acting()];
        Page& page = book_->page(rod.number);
        const P reach = largest_present_radius(rod, load);
        const int nodes = rod.group->closed() ? rod.n : rod.n + 1;

        if (page.busy) {
            std::fill(page.entry.begin(), page.entry.end(), Entry{});
            page.busy = false;
        }
        for (int i = 0; i < nodes; ++i) {
            if (any(margin(wall, rod.slot[i].position, reach) < P(0.0))) {
                page.busy = true;
                touch(rod, load, step.kick, wall, i, page);
            } else if (page.touched[static_cast<std::size_t>(i)]) {
                forget(page, i);
            }
        }
    }

private:
    using P = Pack<W>;
    using Entry = typename WallBook<W>::Entry;
    using Kept = typename WallBook<W>::Kept;
    using Page = typename WallBook<W>::Page;
    static_assert(sizeof(Kept) == 2 * sizeof(Vec3<P>));

    std::size_t acting() const { return book_->acting().size(); }

    /// What springs held when a node leaves its walls is lost to friction.
    static void let_go(Kept& kept) {
        kept.spring = {};
        kept.sums.y += kept.sums.x;
        kept.sums.x = P(0.0);
    }
    void forget(Page& page, int i) const {
        for (std::size_t w = 0; w < acting(); ++w) let_go(page.kept[static_cast<std::size_t>(i) * acting() + w]);
        page.touched[static_cast<std::size_t>(i)] = 0;
    }

    /// No node is thicker, by a margin for round-off: |dx|/l0 is never below the dilatation.
    P largest_present_radius(const RodTile<W>& rod, const SlotLoad<W>* load) const {
        const double largest = largest_radius_ * (1 + 1e-6);
        if (!section_shrinks_) return P(largest);
        P least = load[0].dilatation;
        for (int k = 1; k < rod.n; ++k) least = min(least, load[k].dilatation);
        return P(largest) / sqrt(max(least, P(1e-300)));
    }

    /// From the axis of a tube or the centre of a ball.
    SKEIN_INLINE static Vec3<P> away(const WallNow& wall, const Vec3<P>& x) {
        const Vec3<P> y = x - skein::broadcast<W>(wall.point), a = skein::broadcast<W>(wall.direction);
        return wall.kind == WallKind::tube ? y - dot(y, a) * a : y;
    }
    /// Below 0 where a node of radius `reach` would touch a wall.
    SKEIN_INLINE P margin(const WallNow* wall, const Vec3<P>& x, P reach) const {
        P least(1.0);
        for (std::size_t w = 0; w < acting(); ++w) {
            const WallNow& one = wall[w];
            P here;
            if (one.kind == WallKind::plane) {
                here = dot(skein::broadcast<W>(one.direction), x) - P(one.level) - reach;
            } else {
                const Vec3<P> y = away(one, x);
                const P bound = one.side == WallSide::inside ? P(one.radius) - reach : P(one.radius) + reach;
                here = one.side == WallSide::inside ? bound * abs(bound) - dot(y, y) : dot(y, y) - bound * bound;
            }
            least = min(least, here);
        }
        return least;
    }

    struct Surface {
        P distance;       ///< of the node's axis
        Vec3<P> towards;  ///< the wall
    };
    static Surface surface(const WallNow& wall, const Vec3<P>& x) {
        if (wall.kind == WallKind::plane) return {dot(skein::broadcast<W>(wall.direction), x) - P(wall.level), -skein::broadcast<W>(wall.direction)};
        const Vec3<P> y = away(wall, x);
        const P from = norm(y);
        const double sign = wall.side == WallSide::inside ? 1 : -1;
        return {P(sign) * (P(wall.radius) - from), (P(sign) / max(from, P(1e-300))) * y};
    }

    P radius(const RodTile<W>& rod, int k) const {
        const ElementConstants& c = rod.element[k];
        if (!section_shrinks_) return P(c.radius);
        return P(c.radius) / sqrt(P(c.inv_rest_length) * norm(rod.slot[k + 1].position - rod.slot[k].position));
    }
    static Vec3<P> lab_spin(const RodTile<W>& rod, int k) { return transpose_times(rod.slot[k].director, rod.slot[k].spin); }

    [[gnu::noinline]] void touch(const RodTile<W>& rod, SlotLoad<W>* load, double h, const WallNow* wall, int i, Page& page) const {
        const int n = rod.n;
        // At an end both are the one element there.
        const int before = i > 0 ? i - 1 : rod.group->closed() ? n - 1 : 0, after = i < n ? i : n - 1;
        const P half(0.5), zero(0.0);
        const Slot<W>& node = rod.slot[i];
        ContactState<P> state{};
        state.radius_1 = half * (radius(rod, before) + radius(rod, after));
        state.velocity_1 = node.velocity;
        state.spin_1 = half * (lab_spin(rod, before) + lab_spin(rod, after));

        Vec3<P> force{}, couple{};
        Mask<W> touched = zero > zero;
        for (std::size_t w = 0; w < acting(); ++w) {
            Kept& kept = page.kept[static_cast<std::size_t>(i) * acting() + w];
            const Surface s = surface(wall[w], node.position);
            const Mask<W> touches = state.radius_1 > s.distance;
            if (!any(touches)) {
                let_go(kept);
                continue;
            }
            touched = touched | touches;
            state.normal = s.towards;
            state.distance = s.distance;
            state.velocity_2 = skein::broadcast<W>(wall[w].velocity);
            ContactSpring<P> spring{kept.spring, kept.sums.x};
            const ContactForce<P> out = contact_force<W>(wall[w].kinds, broadcast(wall[w].law), state, h, spring);
            kept.spring = spring.x;
            kept.sums.x = spring.energy;
            kept.sums.y += out.rubbed;
            kept.sums.z += out.damped;
            force += out.on_1;
            couple += out.arm_1 * out.moment;
            enter(page.entry[w], state, out, touches);
        }
        page.touched[static_cast<std::size_t>(i)] = 1;
        // Where nothing touches not even a zero is added: it would turn -0 into 0, and other lanes decide whether this is reached.
        load[i].force = select(touched, load[i].force + force, load[i].force);
        for (const int k : {before, after}) {
            const Vec3<P> more = load[k].couple + half * (rod.slot[k].director * couple);
            load[k].couple = select(touched, more, load[k].couple);
        }
    }

    static void enter(Entry& e, const ContactState<P>& in, const ContactForce<P>& out, Mask<W> touches) {
        const P zero(0.0);
        e.force -= out.on_1;
        e.normal += out.normal;
        e.touching += select(touches, P(1.0), zero);
        e.deepest = max(e.deepest, max(in.radius_1 - in.distance, zero) / (in.radius_1 + in.radius_1));
        e.stiffness = max(e.stiffness, out.stiffness);
        e.stored += out.stored;
    }
    static ContactNumbers<P> broadcast(const ContactNumbers<double>& n) {
        return {n.stiffness, n.damping, n.static_friction, n.kinetic_friction, n.tangential_stiffness, n.tangential_damping, n.slip_speed};
    }
    static Vec3<P> broadcast(const Vec3d& v) { return skein::broadcast<W>(v); }

    std::shared_ptr<const Walls> walls_;
    std::shared_ptr<WallBook<W>> book_;
    bool section_shrinks_;
    double largest_radius_ = 0;
    std::vector<WallNow> now_; ///< [step of the batch][wall]
};

} // namespace skein
