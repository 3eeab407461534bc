#include "core/own_library.hpp"

#include <cstdlib>
#include <filesystem>

#include <dlfcn.h>

namespace skein {

void* open_own_library(const char* name, void (*function)()) {
    namespace fs = std::filesystem;
    // Ranks and threads of the run use all cores, so BLAS must not start threads.
    setenv("OPENBLAS_NUM_THREADS", "1", 0);
    std::error_code none;
    const fs::path program = fs::read_symlink("/proc/self/exe", none);
    fs::path code;
    if (Dl_info here; dladdr(reinterpret_cast<void*>(function), &here)) code = here.dli_fname;
    for (const fs::path& place : {program.parent_path().parent_path() / "lib", code.parent_path()})
        if (const fs::path file = place / name; fs::exists(file, none))
            return dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    return dlopen(name, RTLD_NOW | RTLD_LOCAL);
}

} // namespace skein
