#include "physics/joints/joint_tables.hpp"

#include "joints/junction.hpp"

#include <nlohmann/json.hpp>

namespace skein {

void tidy_echo(nlohmann::json& table, const JointSpec& joint, const CoreTables&, bool) {
    if (shares_node(joint)) table["stiffness"] = "auto";
}

bool stays_in_stage(JointSpec& joint, const ActingStages& acting) {
    if (acting.throughout) return true;
    joint.events.from = acting.begin;
    joint.events.until = acting.end;
    return true;
}

} // namespace skein
