// The physics that bring tables to a scene. A new one: its header among these #includes, and its name in the list.
#pragma once

#include "physics/contact/contact_tables.hpp"
#include "physics/fluid/fluid_tables.hpp"
#include "physics/joints/joint_tables.hpp"
#include "physics/loads/load_tables.hpp"
#include "physics/walls/wall_tables.hpp"

namespace skein {

/// Members of all, and one function that names their tables in order.
template <class... Physics> struct TablesOf : Physics... {
    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) {
        (Physics::visit_tables(scene, f), ...);
    }
};

using PhysicsTables = TablesOf<LoadTables, ContactTables, WallTables, JointTables, FluidTables>;

} // namespace skein
