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
# What fmt and nlohmann-json define goes everywhere: precompiled headers serve only sources with the same definitions.
target_compile_definitions(skein_flags INTERFACE OMPI_SKIP_MPICXX=1)
foreach(library fmt::fmt nlohmann_json::nlohmann_json)
  target_compile_definitions(skein_flags INTERFACE $<TARGET_PROPERTY:${library},INTERFACE_COMPILE_DEFINITIONS>)
  target_include_directories(skein_flags SYSTEM INTERFACE $<TARGET_PROPERTY:${library},INTERFACE_INCLUDE_DIRECTORIES>)
endforeach()

# The headers that most sources read through the project's own, precompiled: a fifth to a half of a source's build. Sources include
# what they use all the same; CMAKE_DISABLE_PRECOMPILE_HEADERS=ON shows that they do.
# A source with an -O or -f of its own skips them: they bring the options they were compiled with, and g++ 12 may crash on the mixture.
set(SKEIN_STANDARD_HEADERS
  <algorithm> <array> <cmath> <cstdint> <cstdio> <cstring> <filesystem> <functional> <immintrin.h> <limits> <map> <memory> <numbers> <numeric>
  <optional> <span> <string> <string_view> <variant> <vector>)
set(SKEIN_COMMON_HEADERS ${SKEIN_STANDARD_HEADERS} <charconv> <fmt/format.h> <nlohmann/json.hpp>)

# Modules that know whole scenes read these headers of the project too, 3 s a source. They are precompiled where sources are joined: a
# build that compiles one source after an edit would compile all of these modules after an edit of such a header.
set(SKEIN_SCENE_MODULES skein_physics skein_scene skein_simulation skein_studies skein)
set(SKEIN_SCENE_HEADERS ${CMAKE_SOURCE_DIR}/src/physics/scene_spec.hpp ${CMAKE_SOURCE_DIR}/src/plan/plan.hpp)

# skein_common_headers(<target>): precompiled once, in core, and once in physics for modules that know whole scenes.
function(skein_common_headers name)
  if(SKEIN_UNITY AND name IN_LIST SKEIN_SCENE_MODULES)
    set(first skein_physics)
    set(headers ${SKEIN_COMMON_HEADERS} ${SKEIN_SCENE_HEADERS})
  else()
    set(first skein_core)
    set(headers ${SKEIN_COMMON_HEADERS})
  endif()
  if(name STREQUAL first)
    target_precompile_headers(${name} PRIVATE ${headers})
  else()
    target_precompile_headers(${name} REUSE_FROM ${first})
  endif()
endfunction()

# skein_build(<target>): how all but kernels is compiled. -O2 takes a fifth less time than -O3, and shipped scenes run as fast: their time
# goes into kernels. Libraries do not wait for those that they are linked with.
function(skein_build name)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O2>)
  set_target_properties(${name} PROPERTIES OPTIMIZE_DEPENDENCIES ON)
  skein_common_headers(${name})
endfunction()

# skein_unity(<target>): twenty sources, or SKEIN_UNITY_OF_<target>, in one translation unit, where SKEIN_UNITY asks for it: all read the
# same headers. Names of a file, in an unnamed namespace or static, have to differ within a target. Kernels are never joined.
set(SKEIN_UNITY_OF_skein_equilibrium 7) # Eigen's templates take a gigabyte
function(skein_unity name)
  set(batch 20)
  if(DEFINED SKEIN_UNITY_OF_${name})
    set(batch ${SKEIN_UNITY_OF_${name}})
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${SKEIN_UNITY} UNITY_BUILD_BATCH_SIZE ${batch})
endfunction()

function(skein_module name)
  cmake_parse_arguments(ARG "" "" "EXCEPT;OBJECTS;DEPENDS" ${ARGN})
  file(GLOB sources RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS *.cpp */*.cpp)
  list(REMOVE_ITEM sources ${ARG_EXCEPT})
  if(sources)
    add_library(skein_${name} STATIC ${sources} ${ARG_OBJECTS})
    target_link_libraries(skein_${name} PUBLIC skein_flags ${ARG_DEPENDS})
    skein_build(skein_${name})
    skein_unity(skein_${name})
  else()
    add_library(skein_${name} INTERFACE)
    target_link_libraries(skein_${name} INTERFACE skein_flags ${ARG_DEPENDS})
  endif()
endfunction()
