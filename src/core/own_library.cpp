#include "core/own_library.hpp"

#include <cstdlib>
#include <filesystem>

#include <dlfcn.h>

namespace skein {

void* open_own_library(const char* name, void (*function)()) {
    namespace fs = std::filesystem;
    // Ranks and threads of the run use all cores, so BLAS must not start threads.
    setenv("OPENBLAS_NUM_THREADS", "1", 0);
    // One kind of kernels on all machines with AVX2, so that their bits are the same. OpenBLAS has its oldest ones for
    // models that it does not know.
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) setenv("OPENBLAS_CORETYPE", "Haswell", 0);
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
