#include "physics/joints/joint_tables.hpp"

#include "joints/junction.hpp"

#include <nlohmann/json.hpp>

namespace skein {

void tidy_echo(nlohmann::json& table, const JointSpec& joint, const CoreTables&, bool) {
    if (shares_node(joint)) table["stiffness"] = "auto";
}

} // namespace skein
