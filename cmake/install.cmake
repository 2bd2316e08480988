# SPDX-License-Identifier: Apache-2.0
# Files that `cmake --install` adds beside the modules (src/volume) and the program (cli): libraries, headers, a CMake
# package and nephos.pc.
include(CMakePackageConfigHelpers)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME development)
install(TARGETS nephos EXPORT nephosTargets
  LIBRARY COMPONENT library NAMELINK_COMPONENT development)
install(TARGETS nephos_static nephos_inside EXPORT nephosStaticTargets)
install(DIRECTORY include/nephos DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN *.h)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/nephos)
configure_package_config_file(cmake/nephosConfig.cmake.in ${PROJECT_BINARY_DIR}/nephosConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/nephosConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/nephosConfig.cmake ${PROJECT_BINARY_DIR}/nephosConfigVersion.cmake
  DESTINATION ${package_dir})
foreach(set nephosTargets nephosStaticTargets)
  install(EXPORT ${set} NAMESPACE nephos:: DESTINATION ${package_dir})
endforeach()

# From the folder of nephos.pc to the prefix, so that an installed tree can be moved.
file(RELATIVE_PATH NEPHOS_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
string(REGEX REPLACE "/$" "" NEPHOS_PC_PREFIX ${NEPHOS_PC_PREFIX})
configure_file(cmake/nephos.pc.in ${PROJECT_BINARY_DIR}/nephos.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/nephos.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
