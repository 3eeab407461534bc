// The step of one group as data: passes over its tiles, in order. The plan prints these lists, and
// kernels/make_pass.hpp makes exactly what they name. A new stage is a struct here, a line in program.cpp and a line in
// make_pass.hpp.        theory.md (20)
#pragma once

#include "loads/damping.hpp"
#include "mechanics/gyration.hpp"
#include "skein/loads/load.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace skein {

namespace pass {

/// Positions and frames at constant rates.
struct Drift {
    Gyration top;
};
/// A ring's last node takes the place of its first.
struct CloseRing {
    static constexpr std::string_view name = "close ring";
};
/// Audit: kinetic energy of ends before they are moved.
struct AuditEnds {
    static constexpr std::string_view name = "audit ends";
};
struct MoveEnds {
    static constexpr std::string_view name = "move ends";
};
struct Orthonormalise {
    static constexpr std::string_view name = "orthonormalise";
};
/// Places, rates and radii go where other rods look.
struct Expose {
    static constexpr std::string_view name = "expose";
};
/// Exposes all parts of a body's surface.
struct ExposeSurface {
    static constexpr std::string_view name = "expose surface";
};
/// Sets internal loads.
struct Elastic {
    Law law;
};
/// In the place of that of bodies: nothing is strained.
struct Unstrained {
    static constexpr std::string_view name = "unstrained";
};
/// Audit: internal loads by themselves.
struct AuditInner {
    static constexpr std::string_view name = "audit inner";
};
/// Adds a load of the scene; `number`: its place among those that act on the group.
struct ApplyLoad {
    std::size_t number;
    std::string_view kind;
    bool needs_whole_rods;
    double ns; ///< as predicted
};
struct Walls {
    static constexpr std::string_view name = "walls";
};
/// Walls at all points of a body's surface.
struct SurfaceWalls {
    static constexpr std::string_view name = "walls (surface)";
};
/// Adds the loads that interactions have found.
struct TakeLoads {
    static constexpr std::string_view name = "contact";
};
/// Adds those that joints have found.
struct TakeJoinedLoads {
    static constexpr std::string_view name = "joints";
};
/// Adds those on a body's surface, as force and moment.
struct TakeSurfaceLoads {
    static constexpr std::string_view name = "contact (surface)";
};
/// Adds loads of the fluid, and leaves kicks the inertia that is not the fluid's.
struct FeelFluid {
    static constexpr std::string_view name = "fluid";
};
/// The load on a ring's last node goes to its first.
struct FoldRing {
    static constexpr std::string_view name = "fold ring";
};
/// Audit: all loads.
struct AuditLoads {
    static constexpr std::string_view name = "audit loads";
};
/// Rates, over a `share` of the step.
struct Kick {
    KickKind kind;
    double share;
};
/// Before walls and contacts of rods that relax.
struct NoteForces {
    static constexpr std::string_view name = "note forces";
};
/// In the place of the kick: inertia and damping of rods that relax.
struct Relax {
    static constexpr std::string_view name = "relax";
    Law law;
};
/// Laplacian filter of the rates.
struct Filter {
    static constexpr std::string_view name = "laplacian filter";
    long order;
    double rate; ///< 1/s
};
struct Hold {
    static constexpr std::string_view name = "hold";
};
/// Held directions of ends that slide in others.
struct Slide {
    static constexpr std::string_view name = "slide";
    bool clamped_last; ///< strands keep the frame of such a wall where an element would be, whose pull the held node
                       ///< does not feel
};
/// Audit: what the step has done.
struct AuditBalance {
    static constexpr std::string_view name = "audit balance";
};

} // namespace pass

using PassSpec = std::variant<pass::Drift, pass::CloseRing, pass::AuditEnds, pass::MoveEnds, pass::Orthonormalise,
                              pass::Expose, pass::ExposeSurface, pass::Elastic, pass::Unstrained, pass::AuditInner,
                              pass::ApplyLoad, pass::TakeJoinedLoads, pass::Walls, pass::SurfaceWalls, pass::TakeLoads,
                              pass::TakeSurfaceLoads, pass::FoldRing, pass::AuditLoads, pass::FeelFluid, pass::Kick,
                              pass::NoteForces, pass::Relax, pass::Filter, pass::Slide, pass::Hold, pass::AuditBalance>;

std::string_view name_of(const PassSpec& pass);
/// True if the pass can run over rods cut into strands (rod/strands.hpp).
bool may_lie_along(const PassSpec& pass);
/// Expected time per element-step and core where all lanes carry a rod, ns: for predictions only.
double predicted_ns(const PassSpec& pass);

/// Passes of a step before rods feel each other, and after.
struct GroupProgram {
    std::vector<PassSpec> before, after;

    std::size_t size() const { return before.size() + after.size(); }
    const PassSpec& operator[](std::size_t i) const { return i < before.size() ? before[i] : after[i - before.size()]; }
    /// Names of all, in order.
    std::vector<std::string_view> names() const;
};

namespace interact {

/// Loads of rods that touch on each other.
struct Contacts {
    static constexpr std::string_view name = "contacts";
};
/// Joints of assemblies, whose forces act within visits (tiles/clusters.hpp); here are their figures.
struct Joints {
    static constexpr std::string_view name = "joints";
};
/// Contacts with walls, and the servos that drive some of them.
struct Walls {
    static constexpr std::string_view name = "walls";
};
/// The fluid, which steps behind the rods.
struct Fluid {
    static constexpr std::string_view name = "fluid";
};

} // namespace interact

/// Effects of rods on each other between `before` and `after`, or to walls; interactions are made from these, in this
/// order.
using InteractionSpec = std::variant<interact::Joints, interact::Contacts, interact::Walls, interact::Fluid>;

std::string_view name_of(const InteractionSpec& interaction);
/// Expected time per element-step and core, ns: for predictions only.
double predicted_ns(const InteractionSpec& interaction);

/// Parts of a scene that decide which passes a group has, besides its own.
struct ProgramNeeds {
    std::span<const Load> loads;      ///< that act on the group
    std::span<const Damping> damping; ///< that act on the group
    KickKind kick = KickKind::undamped;
    bool walls = false;   ///< some act on the group
    bool coupled = false; ///< rods feel each other
    bool joined = false;
    bool audit = false;
    bool relax = false; ///< rest is wanted
    bool feels_fluid = false;
};
GroupProgram program_of(const RodGroup& group, const ProgramNeeds& needs);

} // namespace skein
