// Libraries of Skein that a run opens when it needs them, so that other runs do not load what these are linked to.
#pragma once

namespace skein {

/// Handle of the library `name`, or null: dlerror() has the reason. It is looked for in lib beside the program's
/// folder, beside the code of `function`, which may lie in libskein.so, and where the system looks.
void* open_own_library(const char* name, void (*function)());

} // namespace skein
