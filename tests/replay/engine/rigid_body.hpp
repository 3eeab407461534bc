// Cylinders and spheres of reference files: one node with one frame.
//   v' = f/m,   w' = J^-1 ((J w) x w + c),   and the drift of rods
// The axis of a cylinder is d3, its position the centre.
#pragma once

#include "constraints.hpp"
#include "rod.hpp"

#include <functional>

namespace skein::replay {

struct RigidBody {
    enum class Shape { cylinder, sphere };
    Shape shape;
    double radius, length, mass; ///< m, m (a sphere's: its diameter), kg
    Vec3d inertia;               ///< diagonal in the body frame, kg m^2
    Slot<1> slot;
    Vec3d force{0, 0, 0}, couple{0, 0, 0}; ///< external, of the step so far: lab, N; body, N m

    Vec3d position() const { return lane(slot.position, 0); }
    Vec3d velocity() const { return lane(slot.velocity, 0); }
    Vec3d axis() const { return frame(slot).d3; }
};

/// `entry` of `systems`, a cylinder or a sphere.
RigidBody read_body(const Entry& entry);

/// The step of one body.
class BodyProgram {
public:
    BodyProgram(RigidBody& body, const Stepping& stepping, const std::vector<Entry>& constraints,
                const std::vector<Entry>& dampers);

    void move(const Step& step) const;
    void kick(const Step& step) const;
    /// The state moved on to the end of its step.
    Slot<1> closed_state(double lag, double time) const;

private:
    RigidBody& body_;
    std::size_t stages_;
    std::vector<std::shared_ptr<const Constraint>> constraints_;
    double kept_ = 1; ///< what dampers leave of the rates in every stage
};

/// A load on a body alone. Throws NotBuilt.
std::function<void(const Step&)> make_body_load(const Entry& entry, RigidBody& body);

} // namespace skein::replay
