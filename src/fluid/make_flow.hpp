// Flow solver of a level of instructions (cmake/SkeinKernels.cmake).
#pragma once

#include "fluid/flow.hpp"

namespace skein {

/// Throws InputError if Skein was built without the fluid, or if there are too many ranks for the planes of cells. It
/// also does if the library for the pressure cannot be loaded.
std::unique_ptr<FlowSolver> make_flow(const Communicator& comm, const Threads& threads, const FlowConstants& constants);

} // namespace skein
