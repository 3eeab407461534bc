#include "fluid/pressure_solver.hpp"

#include "skein/core/error.hpp"

#include "core/own_library.hpp"

#include <dlfcn.h>

namespace skein {

#ifdef SKEIN_PETSC

namespace {

/// Function of the library; the number in its name changes with PressureSolver and TensorGrid.
using Maker = PressureSolver* (*)(const Communicator& comm, const TensorGrid& grid, double tolerance,
                                  std::string& fault);
constexpr const char *library_name = "libskein_multigrid.so", *maker_name = "skein_multigrid_1";

Maker load() {
    void* const library = open_own_library(library_name, reinterpret_cast<void (*)()>(&make_multigrid));
    if (!library)
        throw InputError(
            std::string("fluid.pressure = \"multigrid\" needs Skein's library for it, which cannot be loaded: ") +
            dlerror());
    void* const maker = dlsym(library, maker_name);
    if (!maker)
        throw InputError(std::string(library_name) + " belongs to another release of Skein: it has no " + maker_name);
    return reinterpret_cast<Maker>(maker);
}

} // namespace

std::unique_ptr<PressureSolver> make_multigrid(const Communicator& comm, const TensorGrid& grid, double tolerance) {
    static const Maker make = load();
    std::string fault;
    std::unique_ptr<PressureSolver> solver(make(comm, grid, tolerance, fault));
    if (!solver) throw InputError("multigrid for the pressure of the fluid: " + fault);
    return solver;
}

#else

std::unique_ptr<PressureSolver> make_multigrid(const Communicator&, const TensorGrid&, double) {
    throw InputError("the scene has fluid.pressure = \"multigrid\", and this program was built without it: build with "
                     "-DSKEIN_PETSC=ON, which needs PETSc (Debian: petsc-dev)");
}

#endif

} // namespace skein
