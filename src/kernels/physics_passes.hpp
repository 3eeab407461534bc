// Passes that physics add to programs. A new one is a structure here, which names and prices it, its place in the list
// below, and a function of the same argument in kernels/make_pass.hpp.
#pragma once

#include "immersion/inertia_in_fluid.hpp"
#include "loads/damping.hpp"
#include "plan/program.hpp"
#include "relaxation/relaxation_estimate.hpp"
#include "skein/loads/load.hpp"
#include "skein/rod/rod_spec.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skein {

namespace pass {

/// Adds a load of the scene.
struct ApplyLoad {
    Load load;
    std::string family; ///< number of the load, and of the group where the load keeps tables of it
    std::string_view name() const { return load.kind(); }
    double ns() const { return load.predicted_ns(); }
    bool lies_along() const { return !load.needs_whole_rods(); }
    bool has_tables() const { return load.keeps_tables_of_group() && !load.has_tables_by_lane(); }
};
/// Adds the loads that joints have found. The time is that of the millipede: a joint to an element.
struct TakeJoinedLoads {
    static constexpr std::string_view name = "joints";
    static constexpr double ns = 8;
};
/// Contacts of nodes with walls. The time is that of bench/scenes/nest: a box with floor and lid.
struct Walls {
    bool by_mass = false; ///< some law has a restitution, whose numbers follow from the mass of a rod
    static constexpr std::string_view name = "walls";
    static constexpr double ns = 8;
    bool lies_whole() const { return !by_mass; }
};
/// Contacts with walls at all points of a body's surface.
struct SurfaceWalls {
    static constexpr std::string_view name = "walls (surface)";
    static constexpr double ns = 8;
};
/// Adds loads of the fluid, and leaves kicks the inertia that is not the fluid's. The time is that of 256 rods of 50
/// elements.
struct FeelFluid {
    std::shared_ptr<const InertiaInFluid> inertia;
    static constexpr std::string_view name = "fluid";
    static constexpr double ns = 9;
};
/// Before walls and neighbours of rods that relax.
struct NoteForces {
    static constexpr std::string_view name = "note forces";
};
/// In the place of the kick: inertia and damping of rods that relax. The time is that of 64 rods of 50 elements.
struct Relax {
    Law law;
    RelaxationContacts contacts;
    static constexpr std::string_view name = "relax";
    static constexpr double ns = 400;
};
/// In the place of the kick: implicit steps, which evaluate the loads of other passes at each correction. The time is
/// that of three corrections of a stage.
struct StepImplicitly {
    Law law;
    std::vector<Damping> damping;
    bool conserves; ///< energy and momenta
    bool audited;   ///< it books energies
    static constexpr std::string_view name = "implicit step";
    static constexpr double ns = 200;
};
/// In the place of the kick: a step in a bed, which evaluates by itself loads that change with the motion. The time is
/// that of bench/scenes/nest.
struct StepInBed {
    Law law;
    std::vector<Damping> damping;
    static constexpr std::string_view name = "bed step";
    static constexpr double ns = 120;
};
/// Audit: kinetic energy of ends before they are moved.
struct AuditEnds {
    static constexpr std::string_view name = "audit ends";
};
/// Audit: internal loads by themselves.
struct AuditInner {
    static constexpr std::string_view name = "audit inner";
    static bool lies_whole() { return true; }
};
/// Audit: all loads.
struct AuditLoads {
    static constexpr std::string_view name = "audit loads";
    static bool lies_whole() { return true; }
};
/// Audit: loads of the fluid.
struct AuditMedium {
    static constexpr std::string_view name = "audit fluid";
};
/// Audit: work of the fluid.
struct AuditMediumWork {
    static constexpr std::string_view name = "audit fluid work";
};
/// Audit: what the step has done.
struct AuditBalance {
    static constexpr std::string_view name = "audit balance";
    static bool lies_whole() { return true; }
};

} // namespace pass

/// All kinds of passes, in the order of a step as docs/design.md has them. Kernels of a level find a kind by the name
/// of its type, which is the same in all of them.
template <class... Kinds> struct PassKindList {
    /// Calls make() with the structure of a pass.
    template <class Maker> static auto make(const PassSpec& pass, const Maker& maker) {
        decltype(maker(std::declval<pass::Orthonormalise>())) made;
        const auto try_kind = [&]<class Kind>(const Kind* kind) {
            if (kind) made = maker(*kind);
            return kind != nullptr;
        };
        if (!(try_kind(pass.get<Kinds>()) || ...)) throw std::logic_error("a pass of no known kind");
        return made;
    }
};
using PassKinds =
    PassKindList<pass::Drift, pass::DriftOnBearings, pass::CloseRing, pass::AuditEnds, pass::MoveEnds,
                 pass::Orthonormalise, pass::Expose, pass::ExposeSurface, pass::Elastic, pass::Unstrained,
                 pass::AuditInner, pass::ApplyLoad, pass::NoteForces, pass::TakeJoinedLoads, pass::Walls,
                 pass::SurfaceWalls, pass::TakeLoads, pass::TakeSurfaceLoads, pass::FoldRing, pass::AuditLoads,
                 pass::FeelFluid, pass::AuditMedium, pass::Kick, pass::Relax, pass::StepImplicitly, pass::StepInBed,
                 pass::Filter, pass::Slide, pass::Hold, pass::Bearings, pass::AuditMediumWork, pass::AuditBalance>;

} // namespace skein
