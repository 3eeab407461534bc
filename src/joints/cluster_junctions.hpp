// Junctions over a cluster of tiles (tiles/clusters.hpp): half cells that meet, nodes that move as one.
//                                                                                           theory.md (73a)-(73e)
//   nodes           v = sum w_i v_i/sum w_i,  w_i = m_i/b_i of the kick: the velocity of one node with all their loads
//   one on a body   impulses give nodes the velocities V + w x r_i of its places and keep both momenta;
//                   besides g_i = (h/2) w x (w x r_i), so that a drift takes them to where the body's goes
// In a block of copies a junction is between the same slots in all lanes. In a copy by itself it has one lane.
#pragma once

#include "joints/joint_events.hpp"
#include "joints/star_law.hpp"
#include "skein/core/index.hpp"
#include "tiles/clusters.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <vector>

namespace skein {

/// Place of a slot of a group's rod in a cluster.
struct ClusterPlace {
    std::size_t across;         ///< slot, in a block of copies
    std::size_t within;         ///< slot, in a copy by itself
    int lane = 0, end_lane = 1; ///< lane there; end of the lanes that repeat it
    std::size_t tile_across = 0, tile_within = 0;
};
/// Place of a joint's memory in that of a cluster, in packs.
struct JointMemoryPlace {
    std::size_t across, within;
    int lane; ///< within
};
using PlaceInCluster = std::function<ClusterPlace(int group, std::int64_t rod, int slot)>;

/// Gains of rates by a unit force or couple in a kick of the given length: (h/m) b of a node, (h/J) b of an element.
struct KickGains {
    std::function<double(int group, std::int64_t rod, int node, std::size_t length)> node;
    std::function<Vec3d(int group, std::size_t length)> body;
    std::size_t lengths = 1;
};

/// A hub for one length of kicks.
struct HubShares {
    std::vector<double> share; ///< weight of a member's velocity less the first's; w_i on a body
    double inv_weight = 0;     ///< 1/sum w of a body
    Vec3d moment{0, 0, 0};     ///< sum w_i a_i
    Mat3d inv_inertia{};       ///< about the common centre, body axes
};
/// By length of kicks.
std::vector<HubShares> hub_shares(const Hub& hub, const KickGains& gains);

template <int W> class ClusterJunctions {
public:
    /// `tearing`: memory of joints that tear, by number.
    ClusterJunctions(const Junctions& all, const PlaceInCluster& place, const KickGains& gains,
                     const std::map<std::size_t, JointMemoryPlace>& tearing) {
        const auto memory = [&](std::size_t joint) {
            return joint == no_joint ? std::nullopt : std::optional(tearing.at(joint));
        };
        for (const Hub& hub : all.hubs) {
            HubOfCluster& h =
                hubs_.emplace_back(HubOfCluster{hub.body, {}, {}, hub_shares(hub, gains), memory(hub.joint)});
            for (const Hub::Member& m : hub.members) {
                h.places.push_back(place(m.group, m.rod, m.node));
                h.arms.push_back(m.arm);
            }
            hub_of_shared_.insert(hub_of_shared_.end(), h.places.size() - 1, hubs_.size() - 1);
        }
        for (const Star& star : all.stars) {
            StarOfCluster& s = stars_.emplace_back(
                StarOfCluster{star, {}, {}, memory(star.joint), star.break_strain, star.rest_dilatation()});
            for (std::size_t i = 0; i < star.members.size(); ++i) {
                const Star::Member& m = star.members[i];
                s.element.push_back(place(m.group, m.rod, m.element));
                s.next.push_back(m.length > 0 ? place(m.group, m.rod, m.element + 1) : s.element.back());
            }
        }
    }
    bool empty() const { return hubs_.empty(); }
    bool turns() const { return !stars_.empty(); }
    bool tears() const {
        return std::any_of(stars_.begin(), stars_.end(), [](const StarOfCluster& s) { return s.memory.has_value(); });
    }
    /// Nodes that go with the first of their hub, across.
    std::vector<SharedSlot> shared_slots() const {
        std::vector<SharedSlot> all;
        for (const HubOfCluster& h : hubs_)
            for (std::size_t i = 1; i < h.places.size(); ++i)
                all.push_back({static_cast<std::uint32_t>(h.places[i].across),
                               static_cast<std::uint32_t>(h.places[0].across), h.body, h.arms[i]});
        return all;
    }
    /// Lanes in which node i of these has not been torn off.
    Mask<W> goes_along(std::size_t i, const Pack<W>* memory) const {
        const std::optional<JointMemoryPlace>& of = hubs_[hub_of_shared_[i]].memory;
        return (of ? memory_at(memory, of->across).state : Pack<W>(0.0)) < Pack<W>(2.0);
    }
    /// Slots that the half cells of each star depend on, across.
    void append_joined_slots(std::vector<std::vector<std::uint32_t>>& all) const {
        for (const StarOfCluster& s : stars_) {
            std::vector<std::uint32_t>& of = all.emplace_back();
            for (const auto* places : {&s.element, &s.next})
                for (const ClusterPlace& place : *places) of.push_back(static_cast<std::uint32_t>(place.across));
            std::sort(of.begin(), of.end());
            of.erase(std::unique(of.begin(), of.end()), of.end());
        }
    }

    /// Adds loads of half cells; `moments`: by tile of the cluster, null where none are made.
    /// Stars tear before, but in trials; `h`: the step, s.
    void add_loads(const Slot<W>* slot, const EndMoments<W>* moments, JoinedLoad<W>* load, Pack<W>* memory, double h,
                   bool across, JointTime time) const {
        for (const StarOfCluster& s : stars_)
            with_star_law(s.star, [&]<class L>(L) {
                if (across) add_star<L>(s, Across{slot, moments, load, memory, h, time});
                else add_star<L>(s, Within{slot, moments, load, memory, h, time});
            });
    }
    /// Takes nodes to their hubs' places, after a drift.
    void gather(Slot<W>* slot, const Pack<W>* memory, bool across) const {
        for (const HubOfCluster& h : hubs_) for_whole(h, slot, memory, across, [&](auto&& at) { gather(h, at); });
    }
    /// Gives them their velocities, after a kick.
    void move_as_one(Slot<W>* slot, const Pack<W>* memory, const Step& step, bool across) const {
        for (const HubOfCluster& h : hubs_)
            for_whole(h, slot, memory, across, [&](auto&& at) { move_as_one(h, step, at); });
    }

private:
    struct HubOfCluster {
        bool body;
        std::vector<ClusterPlace> places;
        std::vector<Vec3d> arms;
        std::vector<HubShares> shares;
        std::optional<JointMemoryPlace> memory; ///< of the joint that may tear
    };
    struct StarOfCluster {
        Star star;
        std::vector<ClusterPlace> element, next;
        std::optional<JointMemoryPlace> memory;
        double break_strain, rest_dilatation;
    };
    static const JointMemory<Pack<W>>& memory_at(const Pack<W>* memory, std::size_t place) {
        return *reinterpret_cast<const JointMemory<Pack<W>>*>(memory + place);
    }
    /// f(at), at(i) gives access to slot i of a hub where it has not been torn.
    template <class F>
    static void for_whole(const HubOfCluster& h, Slot<W>* slot, const Pack<W>* memory, bool across, F&& f) {
        const Pack<W> torn(2.0);
        if (!across) {
            if (!h.memory || memory_at(memory, h.memory->within).state[h.memory->lane] < 2)
                f([&](std::size_t i) { return LaneOfSlot{slot[h.places[i].within], h.places[i]}; });
        } else if (!h.memory) f([&](std::size_t i) { return WholeSlot{slot[h.places[i].across]}; });
        else if (const Mask<W> whole = memory_at(memory, h.memory->across).state < torn; any(whole))
            f([&](std::size_t i) { return SomeLanes{slot[h.places[i].across], whole}; });
    }
    template <class F> static void with_star_law(const Star& star, F&& f) { with_energy_law(star.law, f); }

    // Access to a slot in all lanes, in some, and in one.
    struct WholeSlot {
        static constexpr int width = W;
        Slot<W>& slot;
        Slot<W> read() const { return slot; }
        void place(const Vec3<Pack<W>>& x) const { slot.position = x; }
        void velocity(const Vec3<Pack<W>>& v) const { slot.velocity = v; }
        void spin(const Vec3<Pack<W>>& w) const { slot.spin = w; }
    };
    struct SomeLanes {
        static constexpr int width = W;
        Slot<W>& slot;
        Mask<W> which;
        Slot<W> read() const { return slot; }
        void place(const Vec3<Pack<W>>& x) const { slot.position = select(which, x, slot.position); }
        void velocity(const Vec3<Pack<W>>& v) const { slot.velocity = select(which, v, slot.velocity); }
        void spin(const Vec3<Pack<W>>& w) const { slot.spin = select(which, w, slot.spin); }
    };
    struct LaneOfSlot {
        static constexpr int width = 1;
        Slot<W>& slot;
        const ClusterPlace& at;
        Slot<1> read() const { return lane(slot, at.lane); }
        void place(const Vec3<Pack<1>>& x) const { set(slot.position, x); }
        void velocity(const Vec3<Pack<1>>& v) const { set(slot.velocity, v); }
        void spin(const Vec3<Pack<1>>& w) const { set(slot.spin, w); }
        void set(Vec3<Pack<W>>& all, const Vec3<Pack<1>>& one) const {
            for (int l = at.lane; l < at.end_lane; ++l) set_lane(all, l, lane(one, 0));
        }
    };

    template <class At> static void gather(const HubOfCluster& h, At&& at) {
        constexpr int V = decltype(at(0))::width;
        using P = Pack<V>;
        const Slot<V> first = at(0).read();
        if (h.body) {
            for (std::size_t i = 1; i < h.places.size(); ++i)
                at(i).place(first.position + transpose_times(first.director, broadcast<V>(h.arms[i])));
            return;
        }
        Vec3<P> x = first.position;
        for (std::size_t i = 1; i < h.places.size(); ++i)
            x = fma(P(h.shares[0].share[i]), at(i).read().position - first.position, x);
        for (std::size_t i = 0; i < h.places.size(); ++i) at(i).place(x);
    }

    template <class At> static void move_as_one(const HubOfCluster& h, const Step& step, At&& at) {
        constexpr int V = decltype(at(0))::width;
        using P = Pack<V>;
        const HubShares& shares = nth(h.shares, step.kick_length);
        const Slot<V> first = at(0).read();
        if (!h.body) {
            Vec3<P> v = first.velocity;
            for (std::size_t i = 1; i < h.places.size(); ++i)
                v = fma(P(shares.share[i]), at(i).read().velocity - first.velocity, v);
            for (std::size_t i = 0; i < h.places.size(); ++i) at(i).velocity(v);
            return;
        }
        const Vec3<P>& w = first.spin;
        const auto ahead = [&](const Vec3<P>& arm) { return P(0.5 * step.dt) * cross(w, cross(w, arm)); };
        Vec3<P> impulse{P(0.0), P(0.0), P(0.0)}, angular = impulse; // body axes
        for (std::size_t i = 1; i < h.places.size(); ++i) {
            const Vec3<P> arm = broadcast<V>(h.arms[i]);
            const Vec3<P> slip =
                first.director * (at(i).read().velocity - first.velocity) - (cross(w, arm) + ahead(arm));
            const Vec3<P> of_node = P(shares.share[i]) * slip;
            impulse += of_node;
            angular += cross(arm, of_node);
        }
        const Vec3<P> moment = broadcast<V>(shares.moment);
        const P inv_weight(shares.inv_weight);
        const Vec3<P> turn = detail::times(shares.inv_inertia, angular - inv_weight * cross(moment, impulse)),
                      shift = inv_weight * (impulse - cross(turn, moment));
        const Vec3<P> velocity = first.velocity + transpose_times(first.director, shift), spin = w + turn;
        for (std::size_t i = 1; i < h.places.size(); ++i) {
            const Vec3<P> arm = broadcast<V>(h.arms[i]);
            at(i).velocity(velocity + transpose_times(first.director, cross(spin, arm) + ahead(arm)));
        }
        at(0).velocity(velocity);
        at(0).spin(spin);
    }

    struct Across {
        static constexpr int width = W;
        const Slot<W>* slot;
        const EndMoments<W>* moments;
        JoinedLoad<W>* load;
        Pack<W>* memory;
        double h;
        JointTime time;
        /// f(state, lost work) of a joint that may tear.
        template <class F> void with_memory(const JointMemoryPlace& at, F&& f) const {
            JointMemory<Pack<W>>& own = *reinterpret_cast<JointMemory<Pack<W>>*>(memory + at.across);
            f(own.state, own.axis.lost_work);
        }
        Slot<W> read(const ClusterPlace& at) const { return slot[at.across]; }
        EndMoment<Pack<W>> moment(const ClusterPlace& at, bool start) const {
            const EndMoments<W>& m = moments[at.tile_across];
            return start ? m.start : m.end;
        }
        void add_force(const ClusterPlace& at, const Vec3<Pack<W>>& f) const {
            load[at.across].force += f;
            if constexpr (W == dual) load[at.across].force_size += norm(lane(f, 0));
        }
        void add_couple(const ClusterPlace& at, const Vec3<Pack<W>>& c) const {
            load[at.across].couple += c;
            if constexpr (W == dual) load[at.across].couple_size += norm(lane(c, 0));
        }
    };
    struct Within {
        static constexpr int width = 1;
        const Slot<W>* slot;
        const EndMoments<W>* moments;
        JoinedLoad<W>* load;
        Pack<W>* memory;
        double h;
        JointTime time;
        template <class F> void with_memory(const JointMemoryPlace& at, F&& f) const {
            JointMemory<Pack<W>>& own = *reinterpret_cast<JointMemory<Pack<W>>*>(memory + at.within);
            Pack<1> state(own.state[at.lane]), lost(own.axis.lost_work[at.lane]);
            f(state, lost);
            own.state.set(at.lane, state[0]);
            own.axis.lost_work.set(at.lane, lost[0]);
        }
        Slot<1> read(const ClusterPlace& at) const { return lane(slot[at.within], at.lane); }
        EndMoment<Pack<1>> moment(const ClusterPlace& at, bool start) const {
            const EndMoment<Pack<W>>& m = start ? moments[at.tile_within].start : moments[at.tile_within].end;
            return {broadcast<1>(lane(m.body, at.lane)), broadcast<1>(lane(m.lab, at.lane))};
        }
        static void add(Vec3<Pack<W>>& all, int l, const Vec3<Pack<1>>& one) {
            set_lane(all, l, lane(all, l) + lane(one, 0));
        }
        void add_force(const ClusterPlace& at, const Vec3<Pack<1>>& f) const { add(load[at.within].force, at.lane, f); }
        void add_couple(const ClusterPlace& at, const Vec3<Pack<1>>& c) const {
            add(load[at.within].couple, at.lane, c);
        }
    };

    template <class L, class Layout> static void add_star(const StarOfCluster& s, const Layout& layout) {
        constexpr int V = Layout::width;
        using P = Pack<V>;
        const std::size_t n = s.element.size();
        StarElements<P> now;
        StarLoads<P> out{};
        for (std::size_t i = 0; i < n; ++i) {
            const Star::Member& m = s.star.members[i];
            const Slot<V> element = layout.read(s.element[i]);
            now[i] = {element.director, layout.read(s.next[i]).position - element.position, {P(0.0), P(0.0), P(0.0)}};
            if (layout.moments && m.length > 0) {
                const EndMoment<P> moment = layout.moment(s.element[i], m.side > 0);
                now[i].moment = P(m.side) * (moment.body + element.director * moment.lab);
            }
        }
        star_loads<L, V>(s.star, layout.moments != nullptr, now, out);
        if (s.memory)
            layout.with_memory(*s.memory,
                               [&](P& state, P& lost_work) { tear<L>(s, layout, now, out, state, lost_work); });
        for (std::size_t i = 0; i < n; ++i) {
            layout.add_couple(s.element[i], out[i].couple);
            if constexpr (L::bending_pulls)
                if (s.star.members[i].length > 0) {
                    layout.add_force(s.element[i], out[i].force);
                    layout.add_force(s.next[i], -out[i].force);
                }
        }
    }

    /// Elements of a star as the step began.
    template <class Layout> static auto half_a_step_before(const StarOfCluster& s, const Layout& layout) {
        using P = Pack<Layout::width>;
        const P back(layout.time == JointTime::staggered ? -0.5 * layout.h : 0.0);
        StarElements<P> then;
        for (std::size_t i = 0; i < s.element.size(); ++i) {
            const auto element = layout.read(s.element[i]), next = layout.read(s.next[i]);
            then[i] = {rotation(back * element.spin) * element.director,
                       next.position - element.position + back * (next.velocity - element.velocity),
                       {P(0.0), P(0.0), P(0.0)}};
        }
        return then;
    }
    /// Ends a star whose elements are strained too much. Its half cells lose the energy that they had as the step
    /// began: the step is made without them.
    template <class L, class Layout>
    static void tear(const StarOfCluster& s, const Layout& layout, const StarElements<Pack<Layout::width>>& now,
                     StarLoads<Pack<Layout::width>>& out, Pack<Layout::width>& state, Pack<Layout::width>& lost_work) {
        constexpr int V = Layout::width;
        using P = Pack<V>;
        const P torn(2.0), none(0.0);
        P dilatation = none;
        for (std::size_t i = 0; i < s.element.size(); ++i) {
            const Star::Member& m = s.star.members[i];
            dilatation += P(m.share / m.length) * (now[i].director * now[i].edge).z;
        }
        const Mask<V> tears = (state < torn) & (dilatation > P((1 + s.break_strain) * s.rest_dilatation));
        if (layout.time != JointTime::trial && any(tears)) {
            P energy = none;
            StarLoads<P> unused;
            star_loads<L, V>(s.star, false, half_a_step_before(s, layout), unused, &energy);
            lost_work = lost_work - select(tears, energy, none);
            state = select(tears, torn, state);
        }
        const Mask<V> whole = state < torn;
        for (std::size_t i = 0; i < s.element.size(); ++i) {
            out[i].couple = select(whole, out[i].couple, Vec3<P>{none, none, none});
            out[i].force = select(whole, out[i].force, Vec3<P>{none, none, none});
        }
    }

    std::vector<HubOfCluster> hubs_;
    std::vector<std::size_t> hub_of_shared_; ///< by number of shared_slots()
    std::vector<StarOfCluster> stars_;
};

} // namespace skein
