#include "physics/contact/law_check.hpp"

#include <fmt/format.h>

namespace skein {

void check_law(const ContactLaw& law, double assumed, Objections& objections) {
    if (law.stiffness == 0 && law.restitution <= 0)
        objections.add("", "it needs 'stiffness', a number or \"auto\", or 'restitution' and 'collision_time' [s]");
    if (law.stiffness_is_automatic() && law.restitution > 0)
        objections.add("stiffness", "'stiffness' = \"auto\" has no use beside 'restitution', which chooses it");
    if (!law.stiffness_is_automatic()) objections.unused({"accepted_overlap"}, "without stiffness = \"auto\"");
    else if (law.accepted_overlap > assumed)
        objections.add(objections.given("accepted_overlap") ? "accepted_overlap" : "stiffness",
                       fmt::format("an accepted overlap of {:g} is more than the {:g} that the time step allows for",
                                   law.accepted_overlap, assumed));
    if (law.restitution <= 0) {
        objections.unused({"collision_time", "collision_speed"}, "without 'restitution'");
    } else {
        if (law.collision_time <= 0) objections.add("", "'restitution' needs 'collision_time' [s]");
        if (law.normal == ContactNormal::linear) objections.unused({"collision_speed"}, "for the linear law");
        else if (law.collision_speed <= 0)
            objections.add("", "'restitution' of the hertz law needs 'collision_speed' [m/s]");
    }
    if (law.friction == ContactFriction::none)
        objections.unused({"static_friction", "kinetic_friction", "friction_from"}, "without 'friction'");
    else if (law.static_friction <= 0 && law.kinetic_friction <= 0)
        objections.add("", "friction needs 'static_friction' or 'kinetic_friction'");
    if (slips_always(law.friction) && law.slip_speed <= 0) objections.add("", "this friction needs 'slip_speed' [m/s]");
    if (law.friction != ContactFriction::anisotropic)
        objections.unused({"kinetic_backward", "kinetic_sideways"}, "without friction = \"anisotropic\"");
    else if (law.kinetic_friction <= 0)
        objections.add("", "anisotropic friction needs 'kinetic_friction', of motion along the tangent, above 0");
    if (law.soft_until == 0) objections.unused({"soft_stiffness", "soft_damping"}, "without 'soft_until' [s]");
}

} // namespace skein
