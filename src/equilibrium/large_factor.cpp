#include "equilibrium/large_factor.hpp"

#include <cstdlib>
#include <filesystem>

#include <dlfcn.h>

namespace skein {

#ifdef SKEIN_PETSC

namespace {

namespace fs = std::filesystem;

/// Function of the library; the number in its name changes with Factor.
using Maker = Factor* (*)(bool symmetric);
constexpr const char *library_name = "libskein_factor.so", *maker_name = "skein_factor_1";

Maker load() {
    // Ranks and threads of the run use all cores, so BLAS must not start threads.
    setenv("OPENBLAS_NUM_THREADS", "1", 0);
    std::error_code none;
    const fs::path program = fs::read_symlink("/proc/self/exe", none);
    fs::path code;
    if (Dl_info here; dladdr(reinterpret_cast<void*>(&make_large_factor), &here))
        code = here.dli_fname; // may be libskein.so
    void* library = nullptr;
    for (const fs::path& place : {program.parent_path().parent_path() / "lib", code.parent_path()})
        if (const fs::path file = place / library_name; !library && fs::exists(file, none))
            library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) library = dlopen(library_name, RTLD_NOW | RTLD_LOCAL);
    return library ? reinterpret_cast<Maker>(dlsym(library, maker_name)) : nullptr;
}

} // namespace

std::unique_ptr<Factor> make_large_factor(bool symmetric) {
    static const Maker make = load();
    return std::unique_ptr<Factor>(make ? make(symmetric) : nullptr);
}

#else

std::unique_ptr<Factor> make_large_factor(bool) { return nullptr; }

#endif

} // namespace skein
