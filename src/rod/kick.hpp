// Kick with damping over one step at frozen geometry, z = nu h.                         theory.md (22)-(24)
//   v <- a v + (h/m) b f,     w_i <- a_i w_i + (h/J_i) b_i c_i
//   midpoint      a = max(0, (2 - z)/(2 + z)),  b = (1 - a)/z: slow motion feels the right drag and the right inertia
//   exponential   a = exp(-z),  b = phi1(z) = (1 - exp(-z))/z: the exact flow, so that fourth order is kept
//   after         a = b = exp(-z): as published codes do it, first order
// The first two are second order with any damping, and never less stable than the undamped kick. Held nodes and elements have
// infinite mass: their gain is 0 and their rates stay as they are.
// Cost: 12 flop per element undamped, 18 at constant rates, 41 with rates that follow the stretch (exponential 90).
#pragma once

#include "core/exponential.hpp"
#include "rod/tile.hpp"

#include <vector>

namespace skein {

/// Damping rates of one group, summed over the scene's damping tables.
struct DampingRates {
    std::vector<double> node;             ///< nu at nodes, 1/s, [n + 1]
    std::vector<Vec3d> element;           ///< nu at elements, 1/s, body axes, [n]
    std::vector<Vec3d> element_stretched; ///< nu per dilatation e = |dx|/l0, 1/s, body axes, [n]; empty where no damping law needs it

    bool none() const { return node.empty(); }
    bool follow_stretch() const { return !element_stretched.empty(); }
};

/// What the kick multiplies with, worked out once per group and kick length.
struct KickConstants {
    struct Node {
        double decay, gain; ///< a, (h/m) b
    };
    struct Element {
        Vec3d decay, gain;   ///< a_i, (h/J_i) b_i: constant rates
        Vec3d z, z_stretch;  ///< z_i = z + z_stretch e: rates that follow the stretch
        Vec3d impulse;       ///< h/J_i
    };
    std::vector<Node> node;
    std::vector<Element> element;

    /// h: length of the kick, s; a fourth-order scheme has negative ones.
    KickConstants(const RodGroup& group, const DampingRates& rates, double h, DampingScheme scheme = DampingScheme::midpoint);
};

enum class KickKind { undamped, constant_rates, stretched_rates, stretched_exponential, stretched_after, elastica };
inline constexpr std::string_view kick_names[] = {"kick",
                                                  "kick (damped)",
                                                  "kick (damped, rates follow stretch)",
                                                  "kick (damped exponentially, rates follow stretch)",
                                                  "kick, then damping (rates follow stretch)",
                                                  "kick (elastica: J/e, damping after)"};

template <KickKind Kind, int W> class KickPass final : public TilePass<W> {
public:
    /// Constants for every kick length of the scheme.
    explicit KickPass(std::vector<KickConstants> constants) : constants_(std::move(constants)), alike_(true) {
        for (const KickConstants& c : constants_)
            for (const KickConstants::Element& e : c.element) alike_ = alike_ && e.z.x == e.z.y && e.z_stretch.x == e.z_stretch.y;
    }
    std::string_view name() const override { return kick_names[static_cast<std::size_t>(Kind)]; }

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        const KickConstants& c = constants_[static_cast<std::size_t>(step.kick_length)];
        if (alike_) kick<true>(c, rod, load);
        else kick<false>(c, rod, load);
    }

private:
    using P = Pack<W>;

    /// Alike: d1 and d2 have the same rate, which is then worked out once.
    template <bool Alike> static void kick(const KickConstants& c, const RodTile<W>& rod, const SlotLoad<W>* load) {
        for (int k = 0; k < rod.n; ++k) {
            Slot<W>& s = rod.slot[k];
            kick_element<Alike>(c.element[static_cast<std::size_t>(k)], load[k], s.spin);
            kick_node(c.node[static_cast<std::size_t>(k)], load[k].force, s.velocity);
        }
        kick_node(c.node[static_cast<std::size_t>(rod.n)], load[rod.n].force, rod.slot[rod.n].velocity);
    }

    SKEIN_INLINE static void kick_node(const KickConstants::Node& c, const Vec3<P>& force, Vec3<P>& velocity) {
        if constexpr (Kind == KickKind::undamped) velocity = fma(P(c.gain), force, velocity);
        else velocity = fma(P(c.gain), force, P(c.decay) * velocity);
    }

    template <bool Alike> SKEIN_INLINE static void kick_element(const KickConstants::Element& c, const SlotLoad<W>& load, Vec3<P>& spin) {
        const Vec3<P>& couple = load.couple;
        if constexpr (Kind == KickKind::undamped) {
            spin = {fma(P(c.gain.x), couple.x, spin.x), fma(P(c.gain.y), couple.y, spin.y), fma(P(c.gain.z), couple.z, spin.z)};
        } else if constexpr (Kind == KickKind::constant_rates) {
            spin = {fma(P(c.gain.x), couple.x, P(c.decay.x) * spin.x), fma(P(c.gain.y), couple.y, P(c.decay.y) * spin.y),
                    fma(P(c.gain.z), couple.z, P(c.decay.z) * spin.z)};
        } else {
            const P e = load.dilatation;
            const P zx = fma(P(c.z_stretch.x), e, P(c.z.x)), zy = fma(P(c.z_stretch.y), e, P(c.z.y)), zz = fma(P(c.z_stretch.z), e, P(c.z.z));
            Decay<W> x, y, z;
            if constexpr (Kind == KickKind::stretched_rates) {
                const TwoDecays<W> two = midpoint_decays(zx, zz);
                x = two.x, z = two.z;
                y = Alike ? x : midpoint_decays(zy, zz).x;
            } else {
                x = decay(zx), z = decay(zz);
                y = Alike ? x : decay(zy);
            }
            const auto kicked = [&](double impulse, const Decay<W>& d, P torque, P w) {
                if constexpr (Kind == KickKind::stretched_rates || Kind == KickKind::stretched_exponential) return fma(P(impulse) * d.mean, torque, d.factor * w);
                else if constexpr (Kind == KickKind::stretched_after) return d.factor * fma(P(impulse), torque, w);
                else return d.factor * fma(P(impulse) * e, torque, w);
            };
            spin = {kicked(c.impulse.x, x, couple.x, spin.x), kicked(c.impulse.y, y, couple.y, spin.y), kicked(c.impulse.z, z, couple.z, spin.z)};
        }
    }

    std::vector<KickConstants> constants_;
    bool alike_;
};

} // namespace skein
