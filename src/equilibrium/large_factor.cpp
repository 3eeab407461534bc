#include "equilibrium/large_factor.hpp"

#include "core/own_library.hpp"

#include <dlfcn.h>

namespace skein {

#ifdef SKEIN_PETSC

namespace {

/// Function of the library; the number in its name changes with Factor.
using Maker = Factor* (*)(bool symmetric, const Communicator* ranks);
constexpr const char *library_name = "libskein_factor.so", *maker_name = "skein_factor_4";

Maker load() {
    void* const library = open_own_library(library_name, reinterpret_cast<void (*)()>(&make_large_factor));
    return library ? reinterpret_cast<Maker>(dlsym(library, maker_name)) : nullptr;
}

} // namespace

std::unique_ptr<Factor> make_large_factor(bool symmetric, const Communicator* ranks) {
    static const Maker make = load();
    return std::unique_ptr<Factor>(make ? make(symmetric, ranks) : nullptr);
}

#else

std::unique_ptr<Factor> make_large_factor(bool, const Communicator*) { return nullptr; }

#endif

} // namespace skein
