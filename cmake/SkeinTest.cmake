# Tests by kind. A test of unit kind is one process; one of mpi kind runs on 1, 2, 3 and 4 ranks, whatever the cores here.

# Flags like -march=native ask for instructions of this machine in all code, which then runs on no older one.
set(SKEIN_PORTABLE ON)
if(CMAKE_CXX_FLAGS MATCHES "-m(arch|avx|fma)")
  set(SKEIN_PORTABLE OFF)
endif()

# The main() of mpi kind, compiled once, and with it the headers that all tests read.
add_library(skein_test_main OBJECT ${CMAKE_SOURCE_DIR}/tests/mpi/main.cpp)
target_link_libraries(skein_test_main PUBLIC skein_parallel GTest::gtest)
set(headers ${SKEIN_COMMON_HEADERS} <fstream> <gtest/gtest.h> <random>)
if(SKEIN_UNITY) # as modules that know whole scenes
  list(APPEND headers ${SKEIN_SCENE_HEADERS} ${CMAKE_SOURCE_DIR}/src/scene/make_groups.hpp ${CMAKE_SOURCE_DIR}/src/scene/make_plan.hpp)
endif()
target_precompile_headers(skein_test_main PRIVATE ${headers})

# skein_test_build(<target>): how tests are compiled. They spend their time in the libraries, so -O1: two thirds of the build, the
# same bits.
function(skein_test_build name)
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(NOT name STREQUAL skein_test_main)
    target_precompile_headers(${name} REUSE_FROM skein_test_main)
  endif()
endfunction()
skein_test_build(skein_test_main)

# skein_kernel_test_build(<target> <level>): how tests that look inside kernels are compiled, with headers that are precompiled per level.
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/tests/no_code.cpp CONTENT "")
function(skein_kernel_test_build name level)
  set(first skein_test_headers_${level})
  if(NOT TARGET ${first})
    add_library(${first} OBJECT ${CMAKE_BINARY_DIR}/tests/no_code.cpp)
    target_link_libraries(${first} PRIVATE skein_flags GTest::gtest)
    target_compile_options(${first} PRIVATE $<$<CONFIG:Release>:-O1>)
    skein_kernel_flags(${first} ${level})
    target_precompile_headers(${first} PRIVATE ${SKEIN_STANDARD_HEADERS} <fstream> <gtest/gtest.h> <random>)
  endif()
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  skein_kernel_flags(${name} ${level})
  target_precompile_headers(${name} REUSE_FROM ${first})
endfunction()

# Passes of all loads for tests of the baseline, compiled once.
add_library(skein_test_passes STATIC ${CMAKE_SOURCE_DIR}/tests/support/load_passes.cpp)
target_link_libraries(skein_test_passes PUBLIC skein_loads)
target_compile_options(skein_test_passes PRIVATE $<$<CONFIG:Release>:-O1>)

# Tests that jobscripts/sanitize.sh runs.
add_custom_target(sanitized_tests)

# skein_unit_test(<name> [KERNELS [LEVEL <level>]] SOURCES ... [DEPENDS ...]): GoogleTest cases without MPI, one ctest case for all. KERNELS: compiled
# for a level, that of this machine if none is named, as the sources look inside kernels.
function(skein_unit_test name)
  cmake_parse_arguments(ARG "KERNELS" "LEVEL" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  if(ARG_KERNELS)
    if(NOT ARG_LEVEL)
      set(ARG_LEVEL ${SKEIN_TEST_LEVEL})
    endif()
    skein_kernel_test_build(${name} ${ARG_LEVEL})
  else()
    skein_test_build(${name})
  endif()
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} GTest::gtest_main)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES LABELS "unit;fast;sanitized" TIMEOUT $<IF:$<CONFIG:Debug>,900,300>)
  add_dependencies(sanitized_tests ${name})
endfunction()

# What Open MPI needs to run as root, in a container, with more ranks than cores. It is not to look for graphics
# processors by a display, which may be another test's and end before it.
set(SKEIN_MPI_ENVIRONMENT
  OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
  OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_mpi_yield_when_idle=1
  HWLOC_COMPONENTS=-gl)

# Tests of many cores start first (COST), and those of one core fill what they leave. In the order of their names they would wait until
# all of one core are done, and then run one by one on half of the machine.

# skein_mpi_run(<test name> RANKS <n> COMMAND ...): one ctest case of the label mpi.
function(skein_mpi_run name)
  cmake_parse_arguments(ARG "" "RANKS" "COMMAND" ${ARGN})
  add_test(NAME ${name} COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ARG_RANKS} ${ARG_COMMAND})
  set_tests_properties(${name} PROPERTIES LABELS mpi PROCESSORS ${ARG_RANKS} COST ${ARG_RANKS} TIMEOUT 900 ENVIRONMENT "${SKEIN_MPI_ENVIRONMENT}")
endfunction()

# skein_mpi_test(<name> SOURCES ... [DEPENDS ...]): GoogleTest cases on 1, 2, 3 and 4 ranks.
function(skein_mpi_test name)
  cmake_parse_arguments(ARG "KERNELS" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  if(ARG_KERNELS)
    skein_kernel_test_build(${name} ${SKEIN_TEST_LEVEL})
  else()
    skein_test_build(${name})
  endif()
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} skein_test_main)
  foreach(ranks 1 2 3 4)
    skein_mpi_run(${name}_np${ranks} RANKS ${ranks} COMMAND $<TARGET_FILE:${name}>)
  endforeach()
endfunction()
