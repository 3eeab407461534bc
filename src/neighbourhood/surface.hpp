// Surface of rigid bodies in the exposure.                                                              theory.md (59c)
//   x_s = x_c + Q^T a,  v_s = v_c + Q^T (w x a)       a: of slot s, along the axes
//   F = sum f_s,  C = sum [a x Q f_s + Q c_s]
// Each part is an element of its own, between two slots. Loads on these come together at the centre of mass. A box
// shows its centre and a radius that covers it. The rates of its second slot, which has no element, are its first two
// axes. Cost: 60 flop per slot each way.
#pragma once

#include "core/rotation.hpp"
#include "neighbourhood/exposure.hpp"
#include "rod/body_shape.hpp"

namespace skein {

/// Calls show(position, radius, velocity, spin) for each exposed slot of a body, in order; all in the lab.
template <int W, class Show> SKEIN_INLINE void for_surface_slots(const BodyShape& body, const Slot<W>& s, Show&& show) {
    using P = Pack<W>;
    const Vec3<P> turning = transpose_times(s.director, s.spin);
    for (const BodyShape::Part& part : body.part) {
        const auto place = [&](const Vec3d& arm) {
            return s.position + transpose_times(s.director, broadcast<W>(arm));
        };
        const auto rate = [&](const Vec3d& arm) {
            return s.velocity + transpose_times(s.director, cross(s.spin, broadcast<W>(arm)));
        };
        const auto axis = [&](const Vec3d& of_box) {
            return transpose_times(s.director, broadcast<W>(transpose_times(part.axes, of_box)));
        };
        show(place(part.from), part.cover(), rate(part.from), turning);
        if (part.box) show(place(part.from), -1, axis({1, 0, 0}), axis({0, 1, 0}));
        else show(place(part.to), -1, rate(part.to), Vec3<P>{P(0.0), P(0.0), P(0.0)});
    }
}

template <int W> class ExposeSurfacePass final : public TilePass<W> {
public:
    ExposeSurfacePass(std::shared_ptr<Exposure> exposure, const BodyShape& body)
        : exposure_(std::move(exposure)), body_(body) {}

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        if (!step.meets()) return;
        const ExposedLanes<W> lanes(*exposure_, rod);
        std::size_t k = 0;
        for_surface_slots(body_, step.ahead == 0 ? rod.slot[0] : moved(rod.slot[0], Pack<W>(step.ahead)),
                          [&](const auto& position, double radius, const auto& velocity, const auto& spin) {
                              lanes.store(k++, position, radius, velocity, spin);
                          });
    }

private:
    /// A body after a time at its present rates.
    static Slot<W> moved(const Slot<W>& s, const Pack<W>& time) {
        Slot<W> after = s;
        after.position = fma(time, s.velocity, s.position);
        after.director = rotation(time * s.spin) * s.director;
        return after;
    }

    std::shared_ptr<Exposure> exposure_;
    const BodyShape& body_; ///< shape of the group's bodies
};

template <int W> class TakeSurfaceLoadsPass final : public TilePass<W> {
public:
    TakeSurfaceLoadsPass(std::shared_ptr<const Exposure> exposure, std::shared_ptr<const SlotLoads> loads,
                         const BodyShape& body)
        : exposure_(std::move(exposure)), loads_(std::move(loads)), body_(body) {}

    void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const override {
        using P = Pack<W>;
        const Quaternion<P>& q = rod.slot[0].director;
        const LoadsOfLanes<W> taken(*exposure_, *loads_, rod);
        if (!taken.any()) return;
        std::size_t k = 0;
        const auto take = [&](const Vec3d& place) {
            const Vec3<P> force = taken.force(k);
            load[0].force += force;
            load[0].couple += cross(broadcast<W>(place), q * force);
            ++k;
        };
        for (const BodyShape::Part& part : body_.part) {
            load[0].couple += q * taken.couple(k);
            take(part.from);
            take(part.to);
        }
    }

private:
    std::shared_ptr<const Exposure> exposure_;
    std::shared_ptr<const SlotLoads> loads_;
    const BodyShape& body_;
};

} // namespace skein
