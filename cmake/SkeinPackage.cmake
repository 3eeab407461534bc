# What `cmake --install` leaves: the program, one static library of all modules and joined kernels, the headers in include/skein, and a
# package that find_package(Skein) finds, with the target Skein::skein. docs/embedding.md shows its use.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(objects "")
foreach(module IN LISTS SKEIN_MODULES)
  get_target_property(type skein_${module} TYPE)
  if(NOT type STREQUAL INTERFACE_LIBRARY) # of headers alone
    list(APPEND objects $<TARGET_OBJECTS:skein_${module}>)
  endif()
endforeach()
set_source_files_properties(${SKEIN_JOINED_KERNELS} PROPERTIES EXTERNAL_OBJECT ON GENERATED ON)
add_library(skein_library STATIC ${objects} ${SKEIN_JOINED_KERNELS})
add_dependencies(skein_library skein_kernels)
file(GLOB_RECURSE headers CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/include/skein/*.hpp)
# Each header is compiled by itself, with nothing but include/ in reach, by skein_library_verify_interface_header_sets.
target_sources(skein_library PUBLIC FILE_SET HEADERS BASE_DIRS ${CMAKE_SOURCE_DIR}/include FILES ${headers})
set_target_properties(skein_library PROPERTIES OUTPUT_NAME skein EXPORT_NAME skein LINKER_LANGUAGE CXX VERIFY_INTERFACE_HEADER_SETS ON)
target_compile_features(skein_library PUBLIC cxx_std_20)
# Packs are wider than the baseline's registers, which is no news; and multiply-adds are contracted where they are spelled fma().
target_compile_options(skein_library INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-psabi> -ffp-contract=off)
target_link_libraries(skein_library PRIVATE MPI::MPI_CXX TBB::tbb hdf5::hdf5 ZLIB::ZLIB tomlplusplus::tomlplusplus fmt::fmt)

# libskein.so for programs in other languages, and the header of its functions.
add_library(skein_shared SHARED ${CMAKE_SOURCE_DIR}/src/simulation/c_interface.cpp)
target_link_libraries(skein_shared PRIVATE skein_studies)
target_link_options(skein_shared PRIVATE LINKER:--version-script=${CMAKE_CURRENT_LIST_DIR}/skein.map)
set_target_properties(skein_shared PROPERTIES OUTPUT_NAME skein LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
install(TARGETS skein_shared LIBRARY DESTINATION lib)
install(FILES ${CMAKE_SOURCE_DIR}/include/skein/skein.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/skein)

# Multigrid for the pressure of a fluid: opened by runs that ask for it, and by them alone, so that no other sees PETSc.
if(SKEIN_PETSC)
  add_library(skein_multigrid MODULE ${CMAKE_SOURCE_DIR}/src/fluid/petsc_multigrid.cpp)
  target_link_libraries(skein_multigrid PRIVATE skein_flags PkgConfig::PETSC MPI::MPI_CXX)
  set_target_properties(skein_multigrid PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
  # Factors of large stiffnesses, opened in the same way.
  add_library(skein_factor MODULE ${CMAKE_SOURCE_DIR}/src/equilibrium/petsc_factor.cpp)
  target_link_libraries(skein_factor PRIVATE skein_flags PkgConfig::PETSC MPI::MPI_CXX Eigen3::Eigen)
  set_target_properties(skein_factor PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
  add_dependencies(skein skein_multigrid skein_factor)
  install(TARGETS skein_multigrid skein_factor LIBRARY DESTINATION lib)
endif()

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Skein)
install(TARGETS skein RUNTIME)
install(TARGETS skein_library EXPORT SkeinTargets ARCHIVE FILE_SET HEADERS)
install(EXPORT SkeinTargets NAMESPACE Skein:: DESTINATION ${package})
configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/SkeinConfig.cmake.in ${CMAKE_BINARY_DIR}/SkeinConfig.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/SkeinConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/SkeinConfig.cmake ${CMAKE_BINARY_DIR}/SkeinConfigVersion.cmake DESTINATION ${package})
