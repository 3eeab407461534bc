// The physics that bring tables to a scene. A new one: its header among these #includes, and its name in the list.
#pragma once

#include "physics/audit/audit_tables.hpp"
#include "physics/contact/contact_tables.hpp"
#include "physics/expectations/expect_tables.hpp"
#include "physics/fluid/fluid_tables.hpp"
#include "physics/implicit/implicit_tables.hpp"
#include "physics/joints/joint_tables.hpp"
#include "physics/loads/load_tables.hpp"
#include "physics/probes/probe_tables.hpp"
#include "physics/relaxation/relaxation_tables.hpp"
#include "physics/rods/rod_tables.hpp"
#include "physics/walls/wall_tables.hpp"
#include "skein/core/objections.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace skein {

struct SceneSpec;
struct Refinement;

/// Members of all, and the calls that go to all in order.
template <class... Physics> struct TablesOf : Physics... {
    static constexpr std::size_t count = sizeof...(Physics);
    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) {
        (Physics::visit_tables(scene, f), ...);
    }
    static void check(const SceneSpec& scene, Objections& objections) { (Physics::check(scene, objections), ...); }
    /// Plans of those that a scene has, in order.
    static void plan(const PlanInput& input, PlannedPhysics& out) { (Physics::plan(input, out), ...); }
    /// Writes numbers in place of those that stand for "auto".
    static void resolve(SceneSpec& scene, std::span<const RodGroup> groups) {
        for_each([&]<class P>(std::type_identity<P>) {
            if constexpr (requires { P::resolve(scene, groups); }) P::resolve(scene, groups);
        });
    }
    /// True if a plan needs all rods of files on every rank.
    static bool needs_all_rods(const SceneSpec& scene) {
        bool all = false;
        for_each([&]<class P>(std::type_identity<P>) {
            if constexpr (requires { P::needs_all_rods(scene); }) all = all || P::needs_all_rods(scene);
        });
        return all;
    }
    /// True if some pass over a group takes whole rods, or keeps tables of them: if rods have sizes of their own, a
    /// plan then needs all of them.
    static bool look_at_whole_rods(const SceneSpec& scene, const RodSpec& rods) {
        bool whole = false;
        for_each([&]<class P>(std::type_identity<P>) {
            if constexpr (requires { P::look_at_whole_rods(scene, rods); })
                whole = whole || P::look_at_whole_rods(scene, rods);
        });
        return whole;
    }
    /// Carries over to other numbers of elements what tables give by element, node or vertex.
    static void refine(SceneSpec& out, const SceneSpec& scene, const Refinement& by) {
        for_each([&]<class P>(std::type_identity<P>) {
            if constexpr (requires { P::refine(out, scene, by); }) P::refine(out, scene, by);
        });
    }
    /// Decisions of refine() that the author of a scene should know.
    static void note_refinement(const SceneSpec& scene, std::vector<std::string>& notes) {
        for_each([&]<class P>(std::type_identity<P>) {
            if constexpr (requires { P::note_refinement(scene, notes); }) P::note_refinement(scene, notes);
        });
    }
    /// Remark above the keys of a table on the reference page; empty: none.
    static std::string_view remark(std::string_view table) {
        std::string_view found;
        for_each([&]<class P>(std::type_identity<P>) {
            if constexpr (requires { P::remark(table); })
                if (found.empty()) found = P::remark(table);
        });
        return found;
    }

private:
    template <class F> static void for_each(F&& f) { (f(std::type_identity<Physics>{}), ...); }
};

using PhysicsTables = TablesOf<LoadTables, JointTables, ContactTables, WallTables, FluidTables, RelaxationTables,
                               ImplicitTables, AuditTables, ProbeTables, ExpectTables, RodTables>;

} // namespace skein
