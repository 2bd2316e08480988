# SPDX-License-Identifier: Apache-2.0
# Debian packages, made by `cpack -G DEB` in the build folder: the library with its modules, what programs are built with,
# and the program with its manual.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the makers of nephos")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libnephos${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libnephos-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME nephos)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)

include(CPack)
cpack_add_component(library DESCRIPTION "Volumetric clouds under a physical sky: the library")
cpack_add_component(development DEPENDS library DESCRIPTION "Volumetric clouds under a physical sky: headers")
cpack_add_component(program DEPENDS library DESCRIPTION "Volumetric clouds under a physical sky: the program")
