# SPDX-License-Identifier: Apache-2.0
# Installs program, library, headers and the package config that gives others `scrim::scrim`. What the library is
# built on stays behind its shared object: a consumer needs GLM and nothing else.
include(CMakePackageConfigHelpers)

# The component `runtime` is what renders, `pictures` reads slides and writes previews (and brings 260 libraries along); the
# rest is for who builds on it.
install(TARGETS scrim EXPORT scrimTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime
                                                  NAMELINK_COMPONENT development)
install(TARGETS scrim_meshes scrim_vdb LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/scrim COMPONENT runtime)
install(TARGETS scrim_images LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/scrim COMPONENT pictures)
install(TARGETS scrim_load RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/scrim COMPONENT runtime)
install(TARGETS scrim_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
# Headers that users of the library need, and no others. They include only one another.
foreach(
    header
    scrim.h
    base/error.h
    base/messages.h
    base/version.h
    geometry/bounds.h
    geometry/box2.h
    geometry/camera.h
    geometry/spaces.h
    image/colour.h
    image/image.h
    image/texture.h
    scene/classified.h
    scene/dials.h
    scene/frame_path.h
    scene/keyed.h
    scene/light.h
    scene/medium.h
    scene/quality.h
    scene/scene.h
    scene/scene_lines.h
    shot/shot.h
    shot/shot_frame.h
    shot/shot_options.h
    solid/triangle_mesh.h
    volume/field_builder.h
    volume/grid_request.h
    volume/load_options.h
    volume/scrim_source.h # of volume sources, in C
    volume/sparse_field.h
    volume/vdb_file.h
    volume/vdb_info.h)
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES scrim/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/scrim/${folder})
endforeach()
install(EXPORT scrimTargets NAMESPACE scrim:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/scrimConfig.cmake.in scrimConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim)
write_basic_package_version_file(scrimConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scrimConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/scrimConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim)
