// Named fields of a system at a recorded step, as the run has them and as the file has them.
#pragma once

#include "rigid_body.hpp"

#include <map>

namespace skein::replay {

using Fields =
    std::map<std::string, std::vector<double>>; ///< of one system at one step, flat, in the order of the file

inline constexpr const char* state_fields[] = {"position", "velocity", "directors", "omega"};
bool of_state(const std::string& field);

/// State and what follows from it, with the published definitions. `state`: of the end of the step; loads are those
/// that acted last.
Fields fields_of(const Rod& rod, const std::vector<Slot<1>>& state);
Fields fields_of(const RigidBody& body, const Slot<1>& state);

/// Those of `computed` that the file has; the state must be there.
Fields reference_fields(const Entry& entry, const Fields& computed);

} // namespace skein::replay
