// Forces of walls on the rods of one group.                                                    theory.md (53)-(56)
// Points of a rod touch walls, as balls; `Points` (wall_points.hpp) defines them and the effect of loads on them. The
// wall is body 2 of the contact law: of infinite mass, its surface at distance d of the node, overlap g = r - d, n
// towards it. The arm is r - g/2, to the middle of the overlap, as between rods. The point's surface moves at v + w x
// arm. A tile away from all walls costs no more than its box, a node no more than the distances to the walls that the
// box is near. Springs are kept by tile, node and wall, touched only where nodes touch. Cost: 7 flop per element where
// nothing is near; per plane near 5, per tube 19, per ball 10; 250 per node and wall that touch.
#pragma once

#include "contact/compress.hpp"
#include "contact/contact_limits.hpp"
#include "contact/contact_tangent.hpp"
#include "contact/implicit_walls.hpp"
#include "contact/stage_response.hpp"
#include "contact/wall_contacts.hpp"
#include "contact/wall_points.hpp"
#include "core/transposed.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <bit>
#include <memory>
#include <stdexcept>

namespace skein {

/// A wall at one step.
struct WallNow {
    WallKind kind;
    WallSide side;
    Vec3d point, direction; ///< normal or axis
    double level;           ///< direction.point
    double radius;
    double width; ///< width of rods over their own: 0 where their axis touches
    Vec3d velocity;
    ContactKinds kinds;
    ContactNumbers<double> law;
    double backward, sideways; ///< coefficients of anisotropic friction over that forward
    bool stands;
};

template <int W, class Points = RodNodes<W>> class WallPass final : public TilePass<W>, public ImplicitWalls<W> {
public:
    /// `tangents`: where slopes of its loads go; null: nothing wants them. `in_stages`: implicit steps evaluate it.
    WallPass(std::shared_ptr<const Walls> walls, const RodGroup& group, std::shared_ptr<WallContactTiles<W>> contacts,
             std::shared_ptr<WallTangents<W>> tangents = nullptr, bool in_stages = false)
        : walls_(std::move(walls)), contacts_(std::move(contacts)), tangents_(std::move(tangents)), points_(group),
          slip_mobility_(in_stages ? 0.0 : slip_mobility(group)), in_stages_(in_stages) {
        if (!has_tangents && (tangents_ || in_stages_))
            throw std::logic_error("slopes of walls, or walls in stages, for rods along");
        for (const int w : contacts_->acting()) {
            law_.push_back(nth(walls_->wall, w).law.resolved(mass_at_wall(group)));
        }
    }

    void expect(std::size_t tiles) override { contacts_->expect(tiles); }
    void bind(const RodTile<W>& rod) override {
        TileContacts& contacts = contacts_->add_tile(rod);
        for (int l = 0; rod.strands && l < lanes_of<W>; ++l) // otherwise all lanes have that of the group
            contacts.slip_mobility.set(l, slip_mobility(rod.group_of(l)));
        if (tangents_) tangents_->add_tile(rod);
        if (!in_stages_) return;
        if (slopes_.size() <= rod.number) slopes_.resize(rod.number + 1);
        slopes_[rod.number].point.resize(rod.group->strained() ? to_index(points_.count(rod)) : 0);
    }

    /// Walls at all steps of the batch: driven ones where their states say now.
    void prepare(std::span<const Step> steps) override {
        now_.resize(std::max(now_.size(), to_index(steps.back().slot + 1) * acting()));
        for (const Step& step : steps)
            for (std::size_t i = 0; i < acting(); ++i) {
                const auto at = to_index(contacts_->acting()[i]);
                const Wall& wall = walls_->wall[at];
                const WallState state = in_stages_ ? walls_->within_step(at, step.time) : walls_->at(at, step.time);
                const Vec3d point = wall.point + state.offset,
                            direction = wall.kind == WallKind::tube ? wall.axis : wall.normal;
                now_[to_index(step.slot) * acting() + i] = {wall.kind,
                                                            wall.side,
                                                            point,
                                                            direction,
                                                            dot(direction, point),
                                                            wall.radius,
                                                            wall.touches == WallTouch::axis ? 0.0 : 1.0,
                                                            state.velocity,
                                                            {wall.law.normal, wall.law.friction},
                                                            numbers_at(law_[i], step),
                                                            wall.law.over_forward(wall.law.kinetic_backward),
                                                            wall.law.over_forward(wall.law.kinetic_sideways),
                                                            wall.stands};
            }
    }

    void append_memory(const RodTile<W>& rod, int lane, std::vector<double>& numbers) const override {
        contacts_->of_tile(rod.number).append_memory(lane, numbers);
    }
    std::size_t restore(const RodTile<W>& rod, int lane, std::span<const double> numbers) override {
        return contacts_->of_tile(rod.number).restore(lane, numbers);
    }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        if (tangents_) (*tangents_)[rod.number].clear();
        if (acting() == 0) return;
        const WallNow* wall = &now_[to_index(step.slot) * acting()];
        TileContacts& contacts = contacts_->of_tile(rod.number);
        Box box = box_of(rod);
        if (tangents_) box.reach = box.reach + P(tangents_->zone);
        find_near(wall, box, contacts);
        contacts.checked.clear();
        for (std::size_t w = 0; w < acting(); ++w) {
            if (!contacts.near[w] && !contacts.held[w]) continue;
            contacts.checked.push_back(w);
            if (contacts.held[w]) contacts.entry[w] = Entry{};
            contacts.held[w] = 0;
        }
        if (contacts.checked.empty()) return;

        for (int i = 0; i < points_.count(rod); ++i) {
            const Vec3<P> at = points_.position(rod, i);
            const auto radius = points_.radius(rod, i);
            unsigned some = 0;
            for (const std::size_t w : contacts.checked) {
                std::uint8_t& touched = contacts.touched[to_index(i) * acting() + w];
                unsigned now = 0;
                if (contacts.near[w]) now = bits_of(P(wall[w].width) * P(radius) > surface(wall[w], at).distance);
                for (unsigned gone = touched & ~now; gone != 0; gone &= gone - 1)
                    contacts.end_contact(i, w, std::countr_zero(gone));
                touched = contacts.left[w] = static_cast<std::uint8_t>(now);
                contacts.held[w] = static_cast<std::uint8_t>(contacts.held[w] | (now != 0));
                some |= now;
            }
            while (some != 0) some = push(rod, load, step.kick, wall, contacts, i, at, radius);
            if (has_tangents && tangents_) stiffen_near(rod, step.kick, wall, contacts, i, at, radius);
        }
    }

    void try_state(const RodTile<W>& rod, const Slot<W>* start, SlotLoad<W>* load, const Step& step,
                   const StageSpan<W>& span) const override {
        if constexpr (has_tangents) try_contacts(rod, start, load, step, span);
        else throw std::logic_error("walls of rods along, in a step of other rods");
    }
    void end_stage(const RodTile<W>& rod, const Slot<W>* start, const Step& step,
                   const StageSpan<W>& span) const override {
        if constexpr (has_tangents) end_contacts(rod, start, step, span);
        else throw std::logic_error("walls of rods along, in a step of other rods");
    }
    const WallSlopes<W>& slopes(std::size_t tile) const override { return slopes_[tile]; }
    void keep(std::size_t place) override { contacts_->keep(place); }
    void go_back(std::size_t place) override { contacts_->go_back(place); }

private:
    using P = Pack<W>;
    using Entry = typename WallContactTiles<W>::Entry;
    using TileContacts = typename WallContactTiles<W>::TileContacts;

    /// Bodies at rest and rods along step neither implicitly nor in a bed: that code is left out, as it compiles for
    /// long.
    static constexpr bool has_tangents = W != dual && Points::lies_across;

    void try_contacts(const RodTile<W>& rod, const Slot<W>* start, SlotLoad<W>* load, const Step& step,
                      const StageSpan<W>& span) const {
        slopes_[rod.number].clear();
        for_touches<false>(rod, start, step, span,
                           [&](int i, std::size_t, const Mask<W>& lanes, const ContactState<Pack<W>>& state,
                               const StageContact<Pack<W>>& out) {
                               points_.push(rod, load, i, lanes, out.on_point, out.arm * out.moment);
                               const Pack<W> zero(0.0);
                               Pack<W> slopes[3][3];
                               for (int r = 0; r < 3; ++r)
                                   for (int c = 0; c < 3; ++c) slopes[r][c] = select(lanes, out.slopes[r][c], zero);
                               points_.add_slopes(rod, slopes_[rod.number], i, slopes,
                                                  select(lanes, out.arm, zero) * state.normal,
                                                  select(lanes, out.on_point, Vec3<Pack<W>>{zero, zero, zero}));
                           });
    }
    void end_contacts(const RodTile<W>& rod, const Slot<W>* start, const Step& step, const StageSpan<W>& span) const {
        TileContacts& contacts = contacts_->of_tile(rod.number);
        for_touches<true>(rod, start, step, span,
                          [&](int i, std::size_t w, const Mask<W>& lanes, const ContactState<Pack<W>>& state,
                              const StageContact<Pack<W>>& out) {
                              book(contacts, w, lanes, -out.on_point, out, overlap_of(state, points_.radius(rod, i)));
                          });
    }

    /// Overlap of a point of this radius at rest, over its diameter.
    template <class R> static P overlap_of(const ContactState<P>& state, const R& radius) {
        return max(state.radius_1 - state.distance, P(0.0)) / P(radius + radius);
    }
    /// Adds the force of a point on a wall, its energies and works to the wall's figures. `Out`: ContactForce or
    /// StageContact.
    template <class Out> SKEIN_INLINE static void book(TileContacts& contacts, std::size_t w, const Mask<W>& lanes,
                                                       const Vec3<P>& force, const Out& out, const P& overlap) {
        const auto raise = [&](P& to, const P& other) { to = select(lanes, max(to, other), to); };
        typename WallContactTiles<W>::Work& work = contacts.work[w];
        add_where(lanes, work.friction, out.friction_work);
        add_where(lanes, work.viscous, out.viscous_work);
        Entry& e = contacts.entry[w];
        add_where(lanes, e.force, force);
        add_where(lanes, e.normal, out.normal);
        add_where(lanes, e.touching, P(1.0));
        add_where(lanes, e.elastic_energy, out.elastic_energy);
        raise(e.max_overlap, overlap);
        raise(e.stiffness, out.stiffness);
    }

    /// Bounds of a tile's nodes, and the largest distance from a wall at which one may touch.
    struct Box {
        Vec3<P> low, high;
        P reach;
    };
    /// Slope of a contact over m/h^2 up to which a stage resolves how it begins.
    static constexpr double resolved_slope = 0.1;

    std::size_t acting() const { return contacts_->acting().size(); }

    ContactNumbers<double> numbers_at(const ContactLaw& law, const Step& step) const {
        ContactNumbers<double> numbers = law.at(step.time).numbers();
        numbers.set_spring(step.kick, slip_mobility_);
        return numbers;
    }

    static bool same_kinds(const WallNow& x, const WallNow& y) {
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
    /// Marks the walls that the box is near. Round-off is monotonic: no node of the box is nearer to a plane than its
    /// corner.
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
            contacts.near[w] = one.stands && any(room < P(0.0));
        }
    }

    /// Vector from the axis of a tube or the centre of a ball, m.
    SKEIN_INLINE static Vec3<P> away(const WallNow& wall, const Vec3<P>& x) {
        const Vec3<P> y = x - broadcast<W>(wall.point), a = broadcast<W>(wall.direction);
        return wall.kind == WallKind::tube ? y - dot(y, a) * a : y;
    }
    struct Surface {
        P distance;      ///< distance of the node's axis, m
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

    /// The walls that lanes of a point touch, each its own.
    struct WallOfLanes {
        Vec3<P> towards{}, velocity{};
        P distance{}, width{}, backward{}, sideways{};
        ContactNumbers<P> law{};
        ContactMemory<double>* memory[lanes_of<W>];
        ContactKinds kinds{};
        unsigned lanes = 0, more = 0; ///< lanes taken; lanes that touch further walls

        void take(const WallNow& wall, const Surface& s, unsigned some) {
            const Mask<W> there = where_set<W>(some, 1.0) > P(0.0);
            const auto put = [&](auto& to, const auto& from) { to = lanes == 0 ? from : select(there, from, to); };
            put(towards, s.towards);
            put(distance, s.distance);
            put(velocity, broadcast<W>(wall.velocity));
            put(width, P(wall.width));
            const auto numbers = wall.law.as<P>();
            put(law.stiffness, numbers.stiffness);
            put(law.damping, numbers.damping);
            put(law.kinetic_friction, numbers.kinetic_friction);
            if (wall.kinds.friction == ContactFriction::memory) {
                put(law.static_friction, numbers.static_friction);
                put(law.tangential_stiffness, numbers.tangential_stiffness);
                put(law.tangential_damping, numbers.tangential_damping);
            } else {
                put(law.slip_speed, numbers.slip_speed);
                put(law.compliance, numbers.compliance);
                put(law.twice_step, numbers.twice_step);
                put(backward, P(wall.backward));
                put(sideways, P(wall.sideways));
            }
            lanes |= some;
        }
    };

    /// Takes for each lane the first wall left, if no other wall comes before it. All walls taken have the kind of law
    /// of the first of all.
    WallOfLanes take_walls(const WallNow* wall, TileContacts& contacts, int point, const Vec3<P>& at) const {
        WallOfLanes one;
        alignas(64) static thread_local ContactMemory<double> none; // load_transposed reads 32 bytes at once
        none = {};
        std::fill_n(one.memory, lanes_of<W>, &none);
        const WallNow* first = nullptr;
        for (const std::size_t w : contacts.checked) {
            const unsigned left = contacts.left[w];
            contacts.taken[w] = 0;
            if (left == 0) continue;
            if (!first) first = &wall[w];
            const unsigned now = same_kinds(*first, wall[w]) ? left & ~(one.lanes | one.more) : 0;
            one.more |= left & ~now;
            contacts.left[w] = static_cast<std::uint8_t>(left & ~now);
            contacts.taken[w] = static_cast<std::uint8_t>(now);
            if (now == 0) continue;
            one.take(wall[w], surface(wall[w], at), now);
            for (unsigned bits = now; bits != 0; bits &= bits - 1) {
                const int l = std::countr_zero(bits);
                one.memory[l] = &contacts.memory_at(point, w, l);
            }
        }
        one.kinds = first->kinds;
        return one;
    }

    /// Forces of a point that some lanes have left to push with. Returns which have more.
    template <class R> [[gnu::noinline]] unsigned push(const RodTile<W>& rod, SlotLoad<W>* load, double h,
                                                       const WallNow* wall, TileContacts& contacts, int point,
                                                       const Vec3<P>& at, const R& radius) const {
        WallOfLanes one = take_walls(wall, contacts, point, at);
        if (rod.strands) one.law.compliance = P(h * h) * contacts.slip_mobility;
        const Mask<W> lanes = where_set<W>(one.lanes, 1.0) > P(0.0);
        ContactState<P> state{};
        points_.describe(rod, point, state);
        state.normal = one.towards;
        state.velocity_2 = one.velocity;
        state.radius_1 = one.width * P(radius);
        state.distance = select(lanes, one.distance, state.radius_1);
        const auto spring = load_transposed<W>([&](int l) { return &one.memory[l]->spring.x.x; }),
                   viscous_part = load_transposed<W>([&](int l) { return &one.memory[l]->viscous_part.x; });
        ContactMemory<P> memory{{spring.vector, spring.fourth}, viscous_part.vector, viscous_part.fourth};
        const Lie<P> lie{points_.axis(rod, point), one.backward, one.sideways};
        const ContactForce<P> out =
            contact_force<W>(one.kinds, one.law, state, h, memory, {}, P(0.0),
                             one.kinds.friction == ContactFriction::anisotropic ? &lie : nullptr);
        points_.push(rod, load, point, lanes, out.on_1, out.arm_1 * out.moment);
        if (has_tangents && tangents_) {
            const auto slopes = contact_slopes<W>(one.kinds, one.law, state, h, out, {}, P(0.0), tangents_->zone);
            const auto there = [&](const P& of) { return select(lanes, of, P(0.0)); };
            points_.stiffen(rod, (*tangents_)[rod.number], point,
                            {state.normal, there(slopes.normal), there(slopes.tangential), there(out.arm_1)});
        }
        const P none(0.0);
        const Vec3<P> nowhere{none, none, none};
        store_transposed<W>(select(lanes, memory.spring.x, nowhere), select(lanes, memory.spring.stiffness, none),
                            [&](int l) { return &one.memory[l]->spring.x.x; });
        store_transposed<W>(select(lanes, memory.viscous_part, nowhere), select(lanes, memory.weight, none),
                            [&](int l) { return &one.memory[l]->viscous_part.x; });
        const P overlap = overlap_of(state, radius);
        for (const std::size_t w : contacts.checked)
            if (contacts.taken[w] != 0)
                book(contacts, w, where_set<W>(contacts.taken[w], 1.0) > none, -out.on_1, out, overlap);
        return one.more;
    }

    /// Slopes of points that are near enough to meet a wall in the step.
    template <class R> void stiffen_near(const RodTile<W>& rod, double h, const WallNow* wall,
                                         const TileContacts& contacts, int point, const Vec3<P>& at,
                                         const R& radius) const {
        for (const std::size_t w : contacts.checked) {
            const Surface s = surface(wall[w], at);
            const P gap = s.distance - P(wall[w].width) * P(radius), zone(tangents_->zone), zero(0.0);
            const auto near = (gap >= zero) & (gap < zone);
            if (!contacts.near[w] || !any(near)) continue;
            const P slope = normal_slope(wall[w].kinds.normal, wall[w].law.template as<P>(), h, zone - gap);
            points_.stiffen(rod, (*tangents_)[rod.number], point,
                            {s.towards, select(near, slope, zero), zero, P(wall[w].width) * P(radius)});
        }
    }

    /// Bounds of all places of a stage.
    Box box_of_stage(const RodTile<W>& rod, const RodTile<W>& start, const StageSpan<W>& span) const {
        Box box = box_of(rod);
        const P onward = span.on / span.to;
        for (int i = 0; i < points_.count(rod); ++i) {
            const Vec3<P> before = points_.position(start, i), now = points_.position(rod, i);
            widen(box, before);
            widen(box, fma(onward, now - before, now));
        }
        return box;
    }

    /// Distances of a point from a wall over a stage, and the share of its normal force in the direction now.
    struct StageDistance {
        Surface now;
        P start, end, after, turned; ///< the force stands for the way to `end`; `after` going on
    };
    static StageDistance stage_distance(const WallNow& wall, const Vec3<P>& before, const Vec3<P>& at,
                                        const StageSpan<W>& span) {
        const Vec3<P> moved = span.to * broadcast<W>(wall.velocity), way = (at - before) - moved;
        const P one(1.0);
        StageDistance d{surface(wall, at), surface(wall, before + moved).distance, {}, {}, one};
        d.after = surface(wall, fma(span.on / span.to, way, at)).distance;
        d.end = span.between ? d.after : d.now.distance;
        if (!span.between) return d;
        if (wall.kind == WallKind::plane) return d;
        const P from = norm(away(wall, at)), both = norm(away(wall, before + moved)) + norm(away(wall, at + way));
        d.turned = P(2.0) * from / max(both, P(1e-300));
        return d;
    }

    /// Adds slopes by which the normal turns along a round wall.
    static void add_turning(const WallNow& wall, const StageDistance& d, const Vec3<P>& at, const P& normal,
                            P (&slopes)[3][3]) {
        if (wall.kind == WallKind::plane) return;
        const double sign = wall.side == WallSide::inside ? 1 : -1;
        const P by = P(sign) * normal * d.turned / max(norm(away(wall, at)), P(1e-300));
        detail::add_across(slopes, -by, d.now.towards);
        if (wall.kind == WallKind::tube)
            detail::add_product(slopes, by, broadcast<W>(wall.direction), broadcast<W>(wall.direction));
    }

    /// Notes lanes where a point begins to touch in a stage, and is to go on at the rates of the stage as if all of it
    /// had been in contact: theory.md (135).
    void note_begin(const RodTile<W>& rod, const WallNow& wall, const StageSpan<W>& span, const P& radius,
                    const StageDistance& d, int i) const {
        const P depth = radius - min(d.after, d.end), most = P(resolved_slope) * P(points_.mass(rod, i));
        const auto begins = (radius <= d.start) & (depth > P(0.0)) & (span.on > P(0.0));
        const auto numbers = wall.law.template as<P>();
        const P root = wall.kinds.normal == ContactNormal::hertz ? P(1.5) * sqrt(max(depth, P(0.0))) : P(1.0);
        const P slope = root * fma(numbers.damping, P(1.0) / span.to, numbers.stiffness);
        P& all = slopes_[rod.number].begins;
        all = select(begins & (slope * span.to * span.to > most), P(1.0), all);
    }

    /// Calls use(point, wall, lanes, state, loads) for points that touch walls in a stage. `Ends`: contacts remember
    /// it.
    template <bool Ends, class Use> void for_touches(const RodTile<W>& rod, const Slot<W>* start, const Step& step,
                                                     const StageSpan<W>& span, Use&& use) const {
        if (acting() == 0) return;
        const WallNow* wall = &now_[to_index(step.slot) * acting()];
        TileContacts& contacts = contacts_->of_tile(rod.number);
        RodTile<W> before = rod;
        before.slot = const_cast<Slot<W>*>(start);
        find_near(wall, box_of_stage(rod, before, span), contacts);
        contacts.checked.clear();
        for (std::size_t w = 0; w < acting(); ++w) {
            if (!contacts.near[w] && !(Ends && contacts.held[w])) continue;
            contacts.checked.push_back(w);
            if (!Ends) continue;
            if (contacts.held[w]) contacts.entry[w] = Entry{};
            contacts.held[w] = 0;
        }
        for (int i = 0; !contacts.checked.empty() && i < points_.count(rod); ++i)
            for (const std::size_t w : contacts.checked) touch<Ends>(rod, before, wall[w], span, contacts, i, w, use);
    }
    template <bool Ends, class Use> void touch(const RodTile<W>& rod, const RodTile<W>& before, const WallNow& wall,
                                               const StageSpan<W>& span, TileContacts& contacts, int i, std::size_t w,
                                               Use&& use) const {
        const Vec3<P> at = points_.position(rod, i);
        const P radius = P(wall.width) * P(points_.radius(rod, i)), zero(0.0);
        const StageDistance d = stage_distance(wall, points_.position(before, i), at, span);
        const auto lanes = (radius > d.end) | ((radius > d.start) & (P(span.between ? 1.0 : 0.0) > zero));
        const unsigned now = contacts.near[w] ? bits_of(lanes) : 0;
        if constexpr (Ends) {
            std::uint8_t& touched = contacts.touched[to_index(i) * acting() + w];
            for (unsigned gone = touched & ~now; gone != 0; gone &= gone - 1)
                contacts.end_contact(i, w, std::countr_zero(gone));
            touched = static_cast<std::uint8_t>(now);
            contacts.held[w] = static_cast<std::uint8_t>(contacts.held[w] | (now != 0));
        }
        if (!Ends && contacts.near[w]) note_begin(rod, wall, span, radius, d, i);
        if (now == 0) return;
        ContactState<P> state{};
        points_.describe(rod, i, state);
        state.normal = d.now.towards;
        state.velocity_2 = broadcast<W>(wall.velocity);
        state.radius_1 = radius;
        state.distance = d.now.distance;
        ContactMemory<P> memory{};
        for (int l = 0; l < W; ++l) set_lane(memory, l, contacts.memory_at(i, w, l));
        const Lie<P> lie{points_.axis(rod, i), P(wall.backward), P(wall.sideways)};
        StageContact<P> out =
            stage_contact<W>(wall.kinds, wall.law.template as<P>(), state,
                             {radius - d.start, radius - d.now.distance, radius - d.end, span.between}, d.turned,
                             {span.to, span.to + span.on}, Ends, memory,
                             wall.kinds.friction == ContactFriction::anisotropic ? &lie : nullptr);
        if constexpr (Ends) {
            for (unsigned bits = now; bits != 0; bits &= bits - 1) {
                const int l = std::countr_zero(bits);
                contacts.memory_at(i, w, l) = lane(memory, l);
            }
        } else {
            add_turning(wall, d, at, out.normal, out.slopes);
        }
        use(i, w, lanes, state, out);
    }

    std::shared_ptr<const Walls> walls_;
    std::shared_ptr<WallContactTiles<W>> contacts_;
    std::shared_ptr<WallTangents<W>> tangents_;
    Points points_;
    double slip_mobility_; ///< 1/kg; 0 in stages, which need no spring for regularised friction
    bool in_stages_;
    mutable std::vector<WallSlopes<W>> slopes_; ///< by tile, in stages
    std::vector<ContactLaw> law_;               ///< by wall that acts
    std::vector<WallNow> now_;                  ///< [slot of the step][wall]
};

} // namespace skein
