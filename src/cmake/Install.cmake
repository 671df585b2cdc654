# SPDX-License-Identifier: Apache-2.0
# Installs the program, the library, headers, documents, and the package config that defines `scrim::scrim`. The
# libraries that Scrim uses stay behind its shared object: a consumer needs GLM and nothing else.
#
# The components, each of which becomes a Debian package (Packages.cmake): `library` (with the modules it loads and the program that
# reads volumes), `program`, `pictures` (reads slides and writes previews, and brings 260 libraries along), `ax` (runs
# OpenVDB AX, and brings LLVM along), `development`.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(scrim_modules ${CMAKE_INSTALL_LIBDIR}/scrim)
install(TARGETS scrim EXPORT scrimTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
                                                  NAMELINK_COMPONENT development)
install(TARGETS scrim_meshes scrim_vdb LIBRARY DESTINATION ${scrim_modules} COMPONENT library)
install(TARGETS scrim_images LIBRARY DESTINATION ${scrim_modules} COMPONENT pictures)
if(SCRIM_WITH_AX)
    install(TARGETS scrim_ax LIBRARY DESTINATION ${scrim_modules} COMPONENT ax)
endif()
install(TARGETS scrim_load scrim_load_vdb RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/scrim COMPONENT library
                                          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/scrim COMPONENT library)
install(TARGETS scrim_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
# The headers that users of the library need, and no others. They include no other headers of Scrim.
foreach(
    header
    scrim.h
    base/error.h
    base/messages.h
    base/version.h
    geometry/bounds.h
    geometry/half_space.h
    geometry/box2.h
    geometry/camera.h
    geometry/spaces.h
    guard/load_options.h
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
    volume/block_memory.h
    volume/field_builder.h
    volume/grid_request.h
    volume/point_cloud.h
    volume/scrim_source.h # for volume sources, in C
    volume/sparse_field.h
    volume/vdb_file.h
    volume/vdb_info.h)
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES scrim/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/scrim/${folder} COMPONENT development)
endforeach()
install(EXPORT scrimTargets NAMESPACE scrim:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim COMPONENT development)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/scrimConfig.cmake.in scrimConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim)
write_basic_package_version_file(scrimConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scrimConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/scrimConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scrim COMPONENT development)

# The rest has no place in a wheel, and is of no use with sanitizers.
if(SKBUILD OR SCRIM_SANITIZE OR NOT PROJECT_IS_TOP_LEVEL)
    return()
endif()

# Man pages and shell completion, made from the same tables as the program's help.
set(scrim_pages ${PROJECT_BINARY_DIR}/man)
file(MAKE_DIRECTORY ${scrim_pages})
set(scrim_page_files ${scrim_pages}/scrim.1 ${scrim_pages}/scrim-scene.5 ${scrim_pages}/completion)
set(scrim_page_commands COMMAND scrim_cli help --man > scrim.1 COMMAND scrim_cli help --man scene > scrim-scene.5
                        COMMAND scrim_cli help --completion > completion)
foreach(command render plan study bake info make merge view help)
    list(APPEND scrim_page_files ${scrim_pages}/scrim-${command}.1)
    list(APPEND scrim_page_commands COMMAND scrim_cli help --man ${command} > scrim-${command}.1)
endforeach()
set(scrim_farm ${PROJECT_SOURCE_DIR}/plugins/farm)
find_program(SCRIM_PYTHON3 python3)
if(SCRIM_PYTHON3)
    list(APPEND scrim_page_files ${scrim_pages}/scrim-submit.1)
    list(APPEND scrim_page_commands COMMAND ${SCRIM_PYTHON3} ${scrim_farm}/scrim-submit --man > scrim-submit.1)
endif()
add_custom_command(OUTPUT ${scrim_page_files} ${scrim_page_commands} WORKING_DIRECTORY ${scrim_pages}
                   DEPENDS scrim_cli ${scrim_farm}/scrim_farm/command.py ${scrim_farm}/scrim_farm/man_page.py VERBATIM)
add_custom_target(scrim_pages ALL DEPENDS ${scrim_page_files})
install(DIRECTORY ${scrim_pages}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program FILES_MATCHING PATTERN *.1)
install(FILES ${scrim_pages}/scrim-scene.5 DESTINATION ${CMAKE_INSTALL_MANDIR}/man5 COMPONENT program)
install(FILES ${scrim_pages}/completion DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME scrim
        COMPONENT program)

# The farm's scripts form one folder; they find it by following the link in bin. The kit lies beside it, as in the source
# tree.
install(PROGRAMS ${scrim_farm}/scrim-submit DESTINATION ${CMAKE_INSTALL_DATADIR}/scrim/farm COMPONENT program)
install(DIRECTORY ${scrim_farm}/scrim_farm DESTINATION ${CMAKE_INSTALL_DATADIR}/scrim/farm COMPONENT program
        FILES_MATCHING PATTERN *.py)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/plugins/kit/scrim_kit DESTINATION ${CMAKE_INSTALL_DATADIR}/scrim/kit
        COMPONENT program FILES_MATCHING PATTERN *.py)
file(RELATIVE_PATH scrim_farm_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/scrim/farm/scrim-submit)
file(CREATE_LINK ${scrim_farm_from_bin} ${PROJECT_BINARY_DIR}/scrim-submit SYMBOLIC)
install(FILES ${PROJECT_BINARY_DIR}/scrim-submit DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)

install(FILES ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program
        PATTERN *.exr EXCLUDE PATTERN *.vdb EXCLUDE PATTERN __pycache__ EXCLUDE PATTERN quickstart.sh EXCLUDE
        PATTERN strip.sh EXCLUDE)
