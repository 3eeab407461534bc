// The solver as a level of instructions has it (cmake/SkeinKernels.cmake).
#pragma once

#include "fluid/flow.hpp"

namespace skein {

/// Throws InputError where Skein was built without the fluid, the ranks are too many for the planes of cells, or what
/// solves for the pressure cannot be loaded.
std::unique_ptr<FlowSolver> make_flow(const Communicator& comm, const Threads& threads, const FlowConstants& constants);

} // namespace skein
