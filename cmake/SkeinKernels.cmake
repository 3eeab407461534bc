# Kernels: the passes of rods, contact and search, compiled once per level of instructions (src/core/level.hpp) and chosen at start.
# All else is compiled for the baseline, x86-64. No pack may cross from one to the other: how wide ones are passed depends on the level.
#
# What is compiled for a level must not be called where another is meant, and a linker that finds an inline function twice, of the
# standard library say, keeps either. So the objects of a level are linked into one, in which all names but that of its table of
# entry points (src/kernels/kernels.hpp) are made local, and its code goes into a section with the name of the level:
# tests/architecture/levels_test.py looks for its instructions in all others, and for packs in the names that a level wants of others.

set(SKEIN_WIDTHS 1 2 4 8 CACHE STRING "Widths to build kernels for; those that are missing are served by others; native: the widest of this processor alone")
set(SKEIN_LEVEL_MARCH_x86_64 x86-64)
set(SKEIN_LEVEL_MARCH_x86_64_v3 x86-64-v3)
set(SKEIN_LEVEL_MARCH_x86_64_v4 x86-64-v4)
set(SKEIN_LEVEL_WIDTHS_x86_64 2)
set(SKEIN_LEVEL_WIDTHS_x86_64_v3 1 4)
set(SKEIN_LEVEL_WIDTHS_x86_64_v4 8)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(SKEIN_LEVELS x86_64 x86_64_v3 x86_64_v4)
else()
  set(SKEIN_LEVELS x86_64) # a name only: built for the processor that the compiler aims at
  set(SKEIN_LEVEL_MARCH_x86_64 "")
endif()

# Level that tests and benchmarks are compiled for which look inside kernels: the widest that this machine runs.
set(SKEIN_HERE x86_64)
if(EXISTS /proc/cpuinfo)
  file(STRINGS /proc/cpuinfo flags REGEX "^flags" LIMIT_COUNT 1)
  if(flags MATCHES " avx2 .* bmi2 " AND flags MATCHES " fma ")
    set(SKEIN_HERE x86_64_v3)
    if(flags MATCHES " avx512f " AND flags MATCHES " avx512dq " AND flags MATCHES " avx512bw " AND flags MATCHES " avx512vl ")
      set(SKEIN_HERE x86_64_v4)
    endif()
  endif()
endif()
if(SKEIN_WIDTHS STREQUAL "native")
  list(GET SKEIN_LEVEL_WIDTHS_${SKEIN_HERE} -1 widest)
  set(SKEIN_WIDTHS ${widest})
endif()
set(SKEIN_TEST_LEVEL ${SKEIN_HERE} CACHE STRING "Level that tests and benchmarks of kernels are compiled for: ${SKEIN_LEVELS}")

# skein_kernel_flags(<target> <level>). GNU: instructions are put in order before registers are given out, which gains 4 % of the
# elastic pass. No bit changes.
function(skein_kernel_flags target level)
  if(SKEIN_LEVEL_MARCH_${level})
    target_compile_options(${target} PRIVATE -march=${SKEIN_LEVEL_MARCH_${level}})
  endif()
  if(level STREQUAL x86_64_v4 AND CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized) # of registers that its own headers leave undefined
  endif()
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fschedule-insns -fsched-pressure -fno-gnu-unique>)
endfunction()

set(SKEIN_CONTACT_KERNELS ${CMAKE_SOURCE_DIR}/src/contact/broad_phase.cpp ${CMAKE_SOURCE_DIR}/src/contact/contact_boxes.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/contact_box_pairs.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/contact_vertices.cpp ${CMAKE_SOURCE_DIR}/src/contact/contact_push.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/near_parallel.cpp ${CMAKE_SOURCE_DIR}/src/contact/touching_scan.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/side_changes.cpp ${CMAKE_SOURCE_DIR}/src/contact/contact_energy.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/static_contacts.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/static_boxes.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/static_friction.cpp
                          ${CMAKE_SOURCE_DIR}/src/contact/contacts.cpp ${CMAKE_SOURCE_DIR}/src/core/rotation.cpp)
set(SKEIN_ROD_KERNELS ${CMAKE_SOURCE_DIR}/src/kernels/kernels_at.cpp ${CMAKE_SOURCE_DIR}/src/kernels/load_passes_at.cpp
                      ${CMAKE_SOURCE_DIR}/src/kernels/implicit_at.cpp ${CMAKE_SOURCE_DIR}/src/kernels/bed_at.cpp
                      ${CMAKE_SOURCE_DIR}/src/kernels/rod_tiles.cpp ${CMAKE_SOURCE_DIR}/src/kernels/rod_tiles_layout.cpp)
set(SKEIN_STATIC_KERNELS ${CMAKE_SOURCE_DIR}/src/kernels/static_rods_at.cpp)
if(SKEIN_FLUID)
  set(SKEIN_FLUID_KERNELS ${CMAKE_SOURCE_DIR}/src/fluid/flow_solver.cpp)
else()
  set(SKEIN_FLUID_KERNELS ${CMAKE_SOURCE_DIR}/src/fluid/no_flow_solver.cpp)
endif()

# skein_level(<level>): libraries skein_contact_<level>, skein_fluid_<level>, skein_static_<level> and skein_rods_<level>_w<width>, and in
# SKEIN_LEVEL_OBJECT_<level> the object that joins them. No definition depends on what is built beside them, so that no option makes the
# kernels of rods, the longest to compile, anew.
function(skein_level level)
  add_library(skein_contact_${level} STATIC ${SKEIN_CONTACT_KERNELS})
  add_library(skein_fluid_${level} STATIC ${SKEIN_FLUID_KERNELS})
  add_library(skein_static_${level} STATIC ${SKEIN_STATIC_KERNELS})
  set(parts skein_contact_${level} skein_fluid_${level} skein_static_${level})
  set(entries "")
  foreach(width ${SKEIN_LEVEL_WIDTHS_${level}})
    if(NOT width IN_LIST SKEIN_WIDTHS)
      continue()
    endif()
    add_library(skein_rods_${level}_w${width} STATIC ${SKEIN_ROD_KERNELS})
    target_compile_definitions(skein_rods_${level}_w${width} PRIVATE SKEIN_WIDTH=${width} SKEIN_KERNELS=skein_kernels_w${width})
    list(APPEND parts skein_rods_${level}_w${width})
    list(APPEND entries --keep-global-symbol=skein_kernels_w${width})
  endforeach()
  set(archives "")
  foreach(part ${parts})
    target_link_libraries(${part} PRIVATE skein_flags)
    skein_kernel_flags(${part} ${level})
    if(part STREQUAL skein_contact_${level})
      target_precompile_headers(${part} PRIVATE ${SKEIN_STANDARD_HEADERS})
    else()
      target_precompile_headers(${part} REUSE_FROM skein_contact_${level})
    endif()
    list(APPEND archives $<TARGET_FILE:${part}>)
  endforeach()
  if(NOT entries) # of no width that is built; tests may want its contact
    set(SKEIN_LEVEL_OBJECT_${level} "" PARENT_SCOPE)
    return()
  endif()
  set(script ${CMAKE_CURRENT_BINARY_DIR}/${level}.ld)
  file(CONFIGURE OUTPUT ${script} CONTENT "SECTIONS { skein_${level} : { *(.text.unlikely .text.unlikely.*) *(.text .text.*) } }\n")
  set(joined ${CMAKE_CURRENT_BINARY_DIR}/skein_${level}.o)
  add_custom_command(OUTPUT ${joined}
    COMMAND ${CMAKE_LINKER} -r --force-group-allocation -T ${script} -o ${joined}.all --whole-archive ${archives}
    COMMAND ${CMAKE_OBJCOPY} ${entries} ${joined}.all ${joined}
    COMMAND ${CMAKE_COMMAND} -E rm ${joined}.all
    DEPENDS ${parts} ${script} VERBATIM COMMENT "Joining kernels of ${SKEIN_LEVEL_MARCH_${level}}")
  set(SKEIN_LEVEL_OBJECT_${level} ${joined} PARENT_SCOPE)
endfunction()
