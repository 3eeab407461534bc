// Two elements that move along the unknowns of their slots, over dual numbers: loads on them have their slopes.
//   places     x + u, exp(theta) Q;  rates  (x - x_0)/H, log(Q Q_0^T)/H, or free ones
#pragma once

#include "core/dual_rotation.hpp"
// The above comes before all templates over packs.
#include "contact/attached_slot.hpp"
#include "contact/static_friction.hpp"
#include "tiles/slot_slopes.hpp"

#include <array>
#include <vector>

namespace skein {

/// An element of a contact: two slots, of a body the same, with what they are in the reference state.
struct ElementAtRest {
    const AttachedSlot* slot[2];
    const Slot<1>* now[2];
    const Slot<1>* then[2];
    double radius; ///< m
};

/// Motion of an element along some of its unknowns, or of its rates.
class MovedElement {
public:
    using P = Pack<dual>;

    /// Slopes of a slot's six unknowns, or of its three displacements, begin at `first`; below 0: it does not move.
    MovedElement(const ElementAtRest& element, const int (&first)[2], bool along_rates) {
        if (along_rates) {
            take_rates(element, first);
            return;
        }
        Vec3<P::Slopes> turn{P::Slopes(0.0), P::Slopes(0.0), P::Slopes(0.0)};
        if (first[0] >= 0) {
            turn.x.set(first[0] + 3, 1);
            turn.y.set(first[0] + 4, 1);
            turn.z.set(first[0] + 5, 1);
        }
        frame = turned_along(lane(element.now[0]->director, 0), turn);
        const Vec3<P> way = relative_rotation(frame, broadcast<dual>(lane(element.then[0]->director, 0)));
        spin = transpose_times(frame, rate() * way);
        for (const int i : {0, 1}) {
            const int own = element.slot[i]->on_body ? first[0] : first[i];
            node_[i] = broadcast<dual>(lane(element.now[i]->position, 0));
            if (own >= 0) {
                node_[i].x.d.set(own, 1);
                node_[i].y.d.set(own + 1, 1);
                node_[i].z.d.set(own + 2, 1);
            }
            velocity_[i] = rate() * (node_[i] - broadcast<dual>(lane(element.then[i]->position, 0)));
            if (!element.slot[i]->on_body) continue;
            arm[i] = transpose_times(frame, broadcast<dual>(element.slot[i]->arm));
            node_[i] = node_[i] + arm[i];
            velocity_[i] = velocity_[i] + cross(spin, arm[i]);
        }
    }
    const Vec3<P>& start() const { return node_[0]; }
    Vec3<P> edge() const { return node_[1] - node_[0]; }
    Vec3<P> point(const P& share) const { return node_[0] + share * edge(); }
    Vec3<P> velocity(const P& share) const { return velocity_[0] + share * (velocity_[1] - velocity_[0]); }

    Quaternion<P> frame;
    Vec3<P> spin;                            ///< lab
    Vec3<P> arm[2] = {nowhere(), nowhere()}; ///< of nodes of a body, lab

private:
    void take_rates(const ElementAtRest& element, const int (&first)[2]) {
        frame = broadcast<dual>(lane(element.now[0]->director, 0));
        const auto free = [](int slope) {
            Vec3<P> rates = nowhere();
            rates.x.d.set(slope, 1);
            rates.y.d.set(slope + 1, 1);
            rates.z.d.set(slope + 2, 1);
            return rates;
        };
        spin = first[0] >= 0 ? transpose_times(frame, free(first[0] + 3)) : nowhere();
        for (const int i : {0, 1}) {
            const bool on_body = element.slot[i]->on_body;
            const int own = on_body ? first[0] : first[i];
            node_[i] = broadcast<dual>(lane(element.now[i]->position, 0));
            velocity_[i] = own >= 0 ? free(own) : nowhere();
            if (!on_body) continue;
            arm[i] = transpose_times(frame, broadcast<dual>(element.slot[i]->arm));
            node_[i] = node_[i] + arm[i];
            velocity_[i] = velocity_[i] + cross(spin, arm[i]);
        }
    }
    static P rate() { return P(1 / long_step); }
    static Vec3<P> nowhere() { return {P(0.0), P(0.0), P(0.0)}; }
    Vec3<P> node_[2], velocity_[2];
};

/// Loads on the slots of both elements: forces at their nodes, lab, and couples on them, body.
struct ElementLoads {
    Vec3<Pack<dual>> force[4], couple[4];
};

/// Slopes of loads that make a matrix: by places a stiffness, by rates a damping.
enum class Slopes { by_places, by_rates };

/// Calls load(a, b) with elements that move along the unknowns of the first, of the second, and of the nodes behind
/// both, and appends the slopes of its loads.
template <class Load> void add_slopes_of_loads(Slopes by, const ElementAtRest (&element)[2], const Load& load,
                                               std::vector<SlotCoupling>& out) {
    constexpr int still = -1;
    const bool rates = by == Slopes::by_rates;
    const int moves[3][2][2] = {{{0, still}, {still, still}}, {{still, still}, {0, still}}, {{still, 0}, {still, 3}}};
    const AttachedSlot* const slot[4] = {element[0].slot[0], element[0].slot[1], element[1].slot[0],
                                         element[1].slot[1]};
    for (int p = 0; p < 3; ++p) {
        if (p == 2 && slot[1]->on_body && slot[3]->on_body) return;
        const ElementLoads loads =
            load(MovedElement(element[0], moves[p][0], rates), MovedElement(element[1], moves[p][1], rates));
        for (std::size_t row = 0; row < 4; ++row) {
            const auto put = [&](std::size_t column, int first, int count) {
                const std::size_t of = slot[row]->slot, column_of = slot[column]->slot;
                SlotCoupling& coupling = out.emplace_back(SlotCoupling{of, column_of, {}});
                add_slopes(loads.force[row], loads.couple[row], !rates && of == column_of && count == slot_unknowns,
                           coupling.block, first, count);
            };
            if (p < 2) {
                put(2 * static_cast<std::size_t>(p), 0, slot_unknowns);
            } else {
                if (!slot[1]->on_body) put(1, 0, 3);
                if (!slot[3]->on_body) put(3, 3, 3);
            }
        }
    }
}

} // namespace skein
