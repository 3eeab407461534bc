# skein_module(<name> [EXCEPT ...] [DEPENDS ...]): one target per folder of src/, skein_<name>, of all its sources but some.
# Without sources the target is header-only.

# Flags that decide bits: no contraction but what fma() spells, no fast-math. Kernels are explicit about width, so the compiler need not
# vectorise, and must not: GCC 11 and 12 expand the permutation {0 1 2 4 4 5 6 7} of eight doubles, which arises in loops that copy records of
# ten out of records with gaps, into vpermilpd $178, an instruction that cannot cross halves of 128 bits and gives {0 1 2 2 5 5 6 7}: of
# the third and fourth index they check the lower bound alone. The C is sound; __builtin_shuffle with that mask shows it. Whatever prefers
# 512-bit vectors is hit (-march=x86-64-v4, native on AMD Zen 4). Permutations that kernels spell are of other kinds (core_test).
add_library(skein_flags INTERFACE)
target_compile_features(skein_flags INTERFACE cxx_std_20)
target_compile_options(skein_flags INTERFACE
  -Wall -Wextra -Wno-psabi -Wno-missing-field-initializers -Wno-restrict -Wno-stringop-overflow -Wno-array-bounds -ffp-contract=off -fno-math-errno -fno-trapping-math
  $<$<CXX_COMPILER_ID:GNU>:-fno-tree-vectorize;-fno-tree-slp-vectorize>)
target_include_directories(skein_flags INTERFACE ${CMAKE_SOURCE_DIR}/include ${CMAKE_SOURCE_DIR}/src)
# What fmt defines goes everywhere: precompiled headers serve only sources with the same definitions.
target_compile_definitions(skein_flags INTERFACE OMPI_SKIP_MPICXX=1 $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)

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

# skein_unity(<target>): eight sources in one translation unit, where SKEIN_UNITY asks for it. Names of a file, in an unnamed
# namespace or static, have to differ within a target. Kernels are never joined.
function(skein_unity name)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${SKEIN_UNITY} UNITY_BUILD_BATCH_SIZE 8)
endfunction()

function(skein_module name)
  cmake_parse_arguments(ARG "" "" "EXCEPT;OBJECTS;DEPENDS" ${ARGN})
  file(GLOB sources RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS *.cpp */*.cpp)
  list(REMOVE_ITEM sources ${ARG_EXCEPT})
  if(sources)
    add_library(skein_${name} STATIC ${sources} ${ARG_OBJECTS})
    target_link_libraries(skein_${name} PUBLIC skein_flags ${ARG_DEPENDS})
    skein_common_headers(skein_${name})
    skein_unity(skein_${name})
  else()
    add_library(skein_${name} INTERFACE)
    target_link_libraries(skein_${name} INTERFACE skein_flags ${ARG_DEPENDS})
  endif()
endfunction()
