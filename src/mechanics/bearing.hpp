// Drift and kick of elements on bearings (rod/bearing.hpp). theory.md (47c)-(47e)
//   held but about e  Q <- Q R(h s e),  s = (n.J w)/(n.J n): exact, as n = Q e stays
//   held about e      lab momentum across e stays. Five midpoint turns, of fourth order:
//                     u = h w',  w' the rate of this momentum in R(u/2) Q,  Q <- R(u) Q;  u.Q e = 0 before and after
//   kick              w <- that of (47c) with the gains of the kick
#pragma once

#include "core/rotation.hpp"
#include "mechanics/kick.hpp"
#include "rod/bearing.hpp"
#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"

#include <utility>
#include <vector>

namespace skein {

namespace detail {

inline constexpr int most_bearing_iterations = 40;
/// Square of the change of a turn, over itself, at which it is found.
inline constexpr double found_turn_squared = 2e-31;
/// Shares of five steps of second order that are one of fourth: 1/(4 - 4^(1/3)), and 1 less four of them.
inline constexpr double fifth = 0.4144907717943757;
inline constexpr double fourth_order_shares[] = {fifth, fifth, 1 - 4 * fifth, fifth, fifth};

/// Turn in a time h about directions across the axis, at a lab momentum that is free along it. Each lane counts its own
/// iterations, so that its bits do not depend on others.
template <int W> Vec3<Pack<W>> turn_across(const Bearing& bearing, const Quaternion<Pack<W>>& q,
                                           const Vec3<Pack<W>>& momentum, const Vec3<Pack<W>>& inv_inertia, Pack<W> h) {
    using P = Pack<W>;
    Vec3<P> u{P(0.0), P(0.0), P(0.0)};
    Mask<W> active = P(1.0) > P(0.0);
    for (int i = 0; i < most_bearing_iterations && any(active); ++i) {
        const Quaternion<P> middle = rotation_by_twice(P(0.25) * u) * q;
        const Vec3<P> next = h * rate_on(bearing, middle, scale(inv_inertia, middle * momentum), inv_inertia),
                      change = next - u;
        u = select(active, next, u);
        active = active & (dot(change, change) > P(found_turn_squared) * dot(next, next));
    }
    return u;
}

} // namespace detail

/// Turns an element on its bearing for a time h.
template <int W> void turn_on(const Bearing& bearing, const ElementConstants& c, Slot<W>& s, Pack<W> h) {
    using P = Pack<W>;
    const Vec3<P> inv_inertia = broadcast<W>(c.inv_inertia);
    Quaternion<P>& q = s.director;
    if (bearing.turns_about) {
        s.spin = rate_on(bearing, q, s.spin, inv_inertia);
        const Vec3<P> axis = broadcast<W>(bearing.axis);
        q = q * rotation((h * dot(q * axis, s.spin)) * axis);
        return;
    }
    const Vec3<P> momentum = transpose_times(q, scale(broadcast<W>(c.inertia), s.spin));
    for (const double share : detail::fourth_order_shares)
        q = rotation(detail::turn_across(bearing, q, momentum, inv_inertia, P(share) * h)) * q;
    s.spin = rate_on(bearing, q, scale(inv_inertia, q * momentum), inv_inertia);
}

/// Calls drift(), and turns elements on bearings for the same time as these do.
template <int W, class Drift>
void drift_on(const std::vector<Bearing>& bearings, const RodTile<W>& rod, double h, Drift&& drift) {
    static thread_local AlignedVector<Slot<W>> before;
    before.clear();
    for (const Bearing& b : bearings) before.push_back(rod.slot[b.element]);
    drift();
    for (std::size_t i = 0; i < bearings.size(); ++i) {
        const Bearing& b = bearings[i];
        turn_on(b, rod.element[b.element], before[i], Pack<W>(h));
        rod.slot[b.element].director = before[i].director;
        rod.slot[b.element].spin = before[i].spin;
    }
}

/// Drift of rods with bearings.
template <class Top, int W> class BearingDriftPass final : public TilePass<W> {
public:
    explicit BearingDriftPass(const RodGroup& group) : bearings_(bearings_of(group)) {}
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        drift_on(bearings_, rod, step.drift, [&] { drift<Top, W>(rod, step.drift); });
    }

private:
    std::vector<Bearing> bearings_;
};

/// Impulses of bearings by the inertia of their elements.
template <int W> class BearingPass final : public TilePass<W> {
public:
    /// `shares`: of the inertia that kicks feel, [n], or none where they feel all of it.
    BearingPass(const RodGroup& group, const std::vector<Vec3d>& shares) : bearings_(bearings_of(group)) {
        for (const Bearing& b : bearings_) {
            const Vec3d &j = nth(group.element, b.element).inertia,
                        &of = shares.empty() ? Vec3d{1, 1, 1} : nth(shares, b.element);
            gain_.push_back({1 / (of.x * j.x), 1 / (of.y * j.y), 1 / (of.z * j.z)});
        }
    }
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override {
        for (std::size_t i = 0; i < bearings_.size(); ++i) {
            Slot<W>& s = rod.slot[bearings_[i].element];
            s.spin = rate_on(bearings_[i], s.director, s.spin, broadcast<W>(gain_[i]));
        }
    }

private:
    std::vector<Bearing> bearings_;
    std::vector<Vec3d> gain_; ///< 1/(kg m^2)
};

/// Impulses of bearings in a damped kick, which damps them as it damps those of couples.
template <KickKind Kind, int W> class DampedBearingPass final : public TilePass<W> {
public:
    DampedBearingPass(const RodGroup& group, KicksOfGroup kicks, std::vector<Vec3d> shares)
        : bearings_(bearings_of(group)), kicks_(std::move(kicks)), shares_(std::move(shares)) {}
    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const override {
        for (const Bearing& b : bearings_) {
            Slot<W>& s = rod.slot[b.element];
            Vec3<Pack<W>> gain = KickPass<Kind, W>::gain(nth(nth(kicks_, step.kick_length).element, b.element),
                                                         load[b.element].dilatation);
            if (!shares_.empty()) {
                const Vec3d& of = nth(shares_, b.element);
                gain = scale(broadcast<W>(Vec3d{1 / of.x, 1 / of.y, 1 / of.z}), gain);
            }
            s.spin = rate_on(b, s.director, s.spin, gain);
        }
    }

private:
    std::vector<Bearing> bearings_;
    KicksOfGroup kicks_;
    std::vector<Vec3d> shares_; ///< of the inertia that kicks feel; none where they feel all of it
};

} // namespace skein
