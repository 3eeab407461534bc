# skein_module(<name> [SOURCES ...] [DEPENDS ...]): one target per folder of src/, skein_<name>.
# Without sources the target is header-only.

# Flags that decide bits: no contraction but what fma() spells, no fast-math. Kernels are explicit about width.
add_library(skein_flags INTERFACE)
target_compile_features(skein_flags INTERFACE cxx_std_20)
target_compile_options(skein_flags INTERFACE
  -Wall -Wextra -Wno-psabi -Wno-missing-field-initializers -Wno-restrict -Wno-stringop-overflow -ffp-contract=off -fno-math-errno -fno-trapping-math
  $<$<CXX_COMPILER_ID:GNU>:-fno-tree-vectorize;-fno-tree-slp-vectorize>)
target_include_directories(skein_flags INTERFACE ${CMAKE_SOURCE_DIR}/src)
target_compile_definitions(skein_flags INTERFACE OMPI_SKIP_MPICXX=1)

# The headers that most sources read through the project's own, precompiled: a fifth to a half of a source's build. Sources include
# what they use all the same; CMAKE_DISABLE_PRECOMPILE_HEADERS=ON shows that they do.
# A source with an -O or -f of its own skips them: they bring the options they were compiled with, and g++ 12 may crash on the mixture.
set(SKEIN_COMMON_HEADERS
  <algorithm> <array> <cmath> <cstdint> <cstdio> <filesystem> <functional> <immintrin.h> <memory> <numbers> <optional> <span> <string>
  <string_view> <variant> <vector>)

# skein_common_headers(<target>): precompiled once, in core.
function(skein_common_headers name)
  if(name STREQUAL skein_core)
    target_precompile_headers(skein_core PRIVATE ${SKEIN_COMMON_HEADERS})
  else()
    target_precompile_headers(${name} REUSE_FROM skein_core)
  endif()
endfunction()

function(skein_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  if(ARG_SOURCES)
    add_library(skein_${name} STATIC ${ARG_SOURCES})
    target_link_libraries(skein_${name} PUBLIC skein_flags ${ARG_DEPENDS})
    skein_common_headers(skein_${name})
  else()
    add_library(skein_${name} INTERFACE)
    target_link_libraries(skein_${name} INTERFACE skein_flags ${ARG_DEPENDS})
  endif()
endfunction()
