// Kick with damping over one step at frozen geometry, z = nu h. theory.md (22)-(24)
//   v <- a v + (h/m) b f,     w_i <- a_i w_i + (h/J_i) b_i c_i
//   midpoint      a = max(0, (2 - z)/(2 + z)),  b = (1 - a)/z: right drag and inertia for slow motion
//   exponential   a = exp(-z),  b = phi1(z) = (1 - exp(-z))/z: the exact flow, which keeps fourth order
//   after         a = b = exp(-z): as in published codes, first order
// The first two are second order with any damping, and never less stable than the undamped kick. Held nodes and
// elements have infinite mass: their gain is 0 and their rates stay as they are. Cost: 12 flop per element undamped, 18
// at constant rates, 41 with rates that follow the stretch (exponential 90).
#pragma once

#include "core/exponential.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/strands.hpp"
#include "skein/tiles/tile.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

namespace skein {

/// Damping rates of one group, summed over the scene's damping tables.
struct DampingRates {
    std::vector<double> node;   ///< nu at nodes, 1/s, [n + 1]
    std::vector<Vec3d> element; ///< nu at elements, 1/s, body axes, [n]
    std::vector<Vec3d>
        /// Rates nu per dilatation e = |dx|/l0, 1/s, body axes, [n]; empty where no damping law needs them.
        element_stretched;

    bool none() const { return node.empty(); }
    bool follow_stretch() const { return !element_stretched.empty(); }
};

/// Factors of the kick of a node: numbers, or packs where they differ from lane to lane.
template <class P> struct KickNodeOf {
    P decay, gain; ///< a, (h/m) b
};
/// Factors of the kick of an element.
template <class P> struct KickElementOf {
    Vec3<P> decay, gain;  ///< a_i, (h/J_i) b_i: constant rates
    Vec3<P> z, z_stretch; ///< z_i = z + z_stretch e: rates that follow the stretch
    Vec3<P> impulse;      ///< h/J_i
};

/// Factors of a kick, computed once per group and kick length.
struct KickConstants {
    using Node = KickNodeOf<double>;
    using Element = KickElementOf<double>;
    std::vector<Node> node;       ///< [n + 1]
    std::vector<Element> element; ///< [n]

    /// h: length of the kick, s; a fourth-order scheme has negative ones.
    KickConstants(const RodGroup& group, const DampingRates& rates, double h,
                  DampingScheme scheme = DampingScheme::midpoint);
};

enum class KickKind { undamped, constant_rates, stretched_rates, stretched_exponential, stretched_after, elastica };
inline constexpr std::string_view kick_names[] = {"kick",
                                                  "kick (damped)",
                                                  "kick (damped, rates follow stretch)",
                                                  "kick (damped exponentially, rates follow stretch)",
                                                  "kick, then damping (rates follow stretch)",
                                                  "kick (elastica: J/e, damping after)"};

/// Constants of a group for every kick length of the scheme.
using KicksOfGroup = std::vector<KickConstants>;

/// True where d1 and d2 of every element have the same rate, which is then computed once.
inline bool rates_alike(const KicksOfGroup& kicks) {
    for (const KickConstants& c : kicks)
        for (const KickConstants::Element& e : c.element)
            if (e.z.x != e.z.y || e.z_stretch.x != e.z_stretch.y) return false;
    return true;
}

template <KickKind Kind, int W> class KickPass final : public TilePass<W> {
public:
    explicit KickPass(KicksOfGroup constants) : constants_(std::move(constants)), alike_(rates_alike(constants_)) {}

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        const KickConstants& c = nth(constants_, step.kick_length);
        if (alike_) kick<true>(c, rod, load);
        else kick<false>(c, rod, load);
    }

    /// C: constants of nodes and elements, as numbers or as packs. Alike: see rates_alike.
    template <bool Alike, class C> static void kick(const C& c, const RodTile<W>& rod, const SlotLoad<W>* load) {
        for (int k = 0; k < rod.n; ++k) {
            Slot<W>& s = rod.slot[k];
            kick_element<Alike>(at(c.element, k), load[k], s.spin);
            kick_node(at(c.node, k), load[k].force, s.velocity);
        }
        if (rod.last == rod.n)
            kick_node(at(c.node, rod.n), load[rod.n].force, rod.slot[rod.n].velocity); // bodies have no node n
    }

    /// Change of an element's rate by a unit couple over the kick, body axes.
    template <class C> static Vec3<Pack<W>> gain(const C& c, const Pack<W>& dilatation) {
        const P one(1.0);
        Vec3<P> spin{P(0.0), P(0.0), P(0.0)};
        kick_element<false>(c, SlotLoad<W>{{}, {one, one, one}, dilatation}, spin);
        return spin;
    }

private:
    using P = Pack<W>;

    template <class T> SKEIN_INLINE static const T& at(const std::vector<T>& all, int k) { return nth(all, k); }
    template <class T> SKEIN_INLINE static const T& at(const LaneRows<T>& all, int k) { return all[k]; }

    template <class C> SKEIN_INLINE static void kick_node(const C& c, const Vec3<P>& force, Vec3<P>& velocity) {
        if constexpr (Kind == KickKind::undamped) velocity = fma(P(c.gain), force, velocity);
        else velocity = fma(P(c.gain), force, P(c.decay) * velocity);
    }

    template <bool Alike, class C>
    SKEIN_INLINE static void kick_element(const C& c, const SlotLoad<W>& load, Vec3<P>& spin) {
        const Vec3<P>& couple = load.couple;
        if constexpr (Kind == KickKind::undamped) {
            spin = {fma(P(c.gain.x), couple.x, spin.x), fma(P(c.gain.y), couple.y, spin.y),
                    fma(P(c.gain.z), couple.z, spin.z)};
        } else if constexpr (Kind == KickKind::constant_rates) {
            spin = {fma(P(c.gain.x), couple.x, P(c.decay.x) * spin.x),
                    fma(P(c.gain.y), couple.y, P(c.decay.y) * spin.y),
                    fma(P(c.gain.z), couple.z, P(c.decay.z) * spin.z)};
        } else {
            const P e = load.dilatation;
            const P zx = fma(P(c.z_stretch.x), e, P(c.z.x)), zy = fma(P(c.z_stretch.y), e, P(c.z.y)),
                    zz = fma(P(c.z_stretch.z), e, P(c.z.z));
            Decay<W> x, y, z;
            if constexpr (Kind == KickKind::stretched_rates) {
                const TwoDecays<W> two = midpoint_decays(zx, zz);
                x = two.x;
                z = two.z;
                y = Alike ? x : midpoint_decays(zy, zz).x;
            } else {
                x = decay(zx);
                z = decay(zz);
                y = Alike ? x : decay(zy);
            }
            const auto kicked = [&](auto impulse, const Decay<W>& d, P torque, P w) {
                if constexpr (Kind == KickKind::stretched_rates || Kind == KickKind::stretched_exponential)
                    return fma(P(impulse) * d.mean, torque, d.factor * w);
                else if constexpr (Kind == KickKind::stretched_after) return d.factor * fma(P(impulse), torque, w);
                else return d.factor * fma(P(impulse) * e, torque, w);
            };
            spin = {kicked(c.impulse.x, x, couple.x, spin.x), kicked(c.impulse.y, y, couple.y, spin.y),
                    kicked(c.impulse.z, z, couple.z, spin.z)};
        }
    }

    KicksOfGroup constants_;
    bool alike_;
};

/// Kick of a tile along: all but the kick itself, so that it is compiled once.
template <int W> class KicksAlong : public TilePass<W> {
public:
    /// Constants of every group of the family, by RodGroup::id; `of_rod` computes those of a rod with a size of its
    /// own.
    explicit KicksAlong(std::map<int, KicksOfGroup> constants, std::function<KicksOfGroup(const RodGroup&)> of_rod = {})
        : constants_(std::move(constants)), of_rod_(std::move(of_rod)) {
        for (const auto& [group, kicks] : constants_) alike_ = alike_ && rates_alike(kicks);
    }

    void expect(std::size_t tiles) override { tiles_.resize(tiles); }
    void bind(const RodTile<W>& rod) override {
        auto& kicks = tiles_[rod.number];
        std::vector<KicksOfGroup> own;
        const KicksOfGroup* of_lane[W];
        std::fill_n(of_lane, W, nullptr);
        own.reserve(rod.strands->ranges().size());
        for (const LaneRange& range : rod.strands->ranges()) {
            if (of_rod_) own.push_back(of_rod_(*range.group));
            std::fill_n(of_lane + range.lane, range.lanes, of_rod_ ? &own.back() : &constants_.at(range.group->id()));
        }
        kicks.reserve(constants_.begin()->second.size());
        for (std::size_t length = 0; length < constants_.begin()->second.size(); ++length) {
            Rows& rows = kicks.emplace_back();
            if (of_rod_) {
                rows.node.reserve(rod.n + 1);
                rows.element.reserve(rod.n);
            }
            for (int row = 0; row <= rod.n; ++row) {
                KickNodeOf<P> node{P(1.0), P(0.0)}; // infinite mass where there is no node
                KickElementOf<P> element{{P(1.0), P(1.0), P(1.0)}, {}, {}, {}, {}};
                for (int i = 0; i < W; ++i) {
                    const int slot = rod.strands->slot(i, row);
                    if (slot < 0) continue;
                    const KickConstants& c = (*of_lane[i])[length];
                    set_lane<KickNodeOf>(node, i, nth(c.node, slot));
                    if (static_cast<std::size_t>(slot) < c.element.size())
                        set_lane<KickElementOf>(element, i, nth(c.element, slot));
                }
                rows.node.push_back(node);
                if (row < rod.n) rows.element.push_back(element);
            }
            rows.node.close();
            rows.element.close();
        }
    }

protected:
    using P = Pack<W>;
    struct Rows {
        LaneRows<KickNodeOf<P>> node;
        LaneRows<KickElementOf<P>> element;
    };
    const Rows& rows(const RodTile<W>& rod, const Step& step) const {
        return nth(tiles_[rod.number], step.kick_length);
    }
    bool alike() const { return alike_; }

private:
    std::map<int, KicksOfGroup> constants_;
    std::function<KicksOfGroup(const RodGroup&)> of_rod_;
    bool alike_ = true;
    std::vector<std::vector<Rows>> tiles_; ///< by tile number and kick length
};

template <KickKind Kind, int W> class KickAlongPass final : public KicksAlong<W> {
public:
    using KicksAlong<W>::KicksAlong;
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        const auto& c = this->rows(rod, step);
        if (this->alike()) KickPass<Kind, W>::template kick<true>(c, rod, load);
        else KickPass<Kind, W>::template kick<false>(c, rod, load);
    }
};

} // namespace skein
