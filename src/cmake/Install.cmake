# SPDX-License-Identifier: Apache-2.0
# Installs program, library, headers and the package config that gives others `scrim::scrim`. What the library is
# built on stays behind its shared object: a consumer needs GLM and nothing else.
include(CMakePackageConfigHelpers)

install(TARGETS scrim EXPORT scrimTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS scrim_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/scrim DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING
        PATTERN "*.h")
install(EXPORT scrimTargets NAMESPACE scrim:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/scrimConfig.cmake.in scrimConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim)
write_basic_package_version_file(scrimConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scrimConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/scrimConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim)
