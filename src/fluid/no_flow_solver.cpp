// Replaces flow_solver.cpp in builds without the fluid, so that kernels of rods are equal objects in both builds.
#include "fluid/make_flow.hpp"

#include "skein/core/error.hpp"

namespace skein {

std::unique_ptr<FlowSolver> make_flow(const Communicator&, const Threads&, const FlowConstants&) {
    throw InputError("the scene has a [fluid], and this program was built without the solver for it: build with "
                     "-DSKEIN_FLUID=ON, which needs FFTW (Debian: libfftw3-dev)");
}

} // namespace skein
