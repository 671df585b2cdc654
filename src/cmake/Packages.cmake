# SPDX-License-Identifier: Apache-2.0
# Debian packages, made by CPack (see packages.sh), one for each component of Install.cmake.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The developers of Scrim <developers@scrim.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENTS_ALL library program pictures development debian_python)
if(SCRIM_WITH_AX)
    list(APPEND CPACK_COMPONENTS_ALL ax)
endif()
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/debian/finish.cmake)

set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(scrim_same "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(scrim_about "Scrim renders OpenVDB volumes (smoke, clouds, fire, scans) with volumetric
shadows by sheet-based splatting into colour-managed OpenEXR: fast, and
without noise.

")
# scrim_package(COMPONENT NAME SECTION DEPENDS SUMMARY TEXT)
macro(scrim_package component name section depends summary text)
    string(TOUPPER ${component} scrim_upper)
    set(CPACK_DEBIAN_${scrim_upper}_PACKAGE_NAME ${name})
    set(CPACK_DEBIAN_${scrim_upper}_PACKAGE_SECTION ${section})
    set(CPACK_DEBIAN_${scrim_upper}_PACKAGE_DEPENDS "${depends}")
    set(CPACK_DEBIAN_${scrim_upper}_DESCRIPTION "${summary}\n${scrim_about}${text}")
    set(CPACK_COMPONENT_${scrim_upper}_DESCRIPTION "${summary}\n${scrim_about}${text}")
endmacro()
set(scrim_library libscrim${SCRIM_ABI})
scrim_package(library ${scrim_library} libs "" "renderer of OpenVDB volumes, shared library"
              "This package holds the library, what reads volumes, and volume sources.")
scrim_package(program scrim graphics "${scrim_library} ${scrim_same}, python3:any" "renderer of OpenVDB volumes"
              "This package holds the program, what sends shots to render farms, and the\ndocuments.")
scrim_package(pictures scrim-pictures graphics "${scrim_library} ${scrim_same}"
              "renderer of OpenVDB volumes, slides and previews"
              "This package reads pictures (slides of projectors, domes) and writes previews,\nby OpenImageIO.")
scrim_package(ax scrim-ax graphics "${scrim_library} ${scrim_same}" "renderer of OpenVDB volumes, expressions"
              "This package runs expressions in OpenVDB AX, which change volumes before they\nare rendered. It brings LLVM.")
scrim_package(development libscrim-dev libdevel "${scrim_library} ${scrim_same}, libglm-dev"
              "renderer of OpenVDB volumes, headers" "This package holds what programs that use the library are built with.")
scrim_package(debian_python python3-scrim python
              "${scrim_library} ${scrim_same}, scrim ${scrim_same}, python3 (>= 3.11), python3 (<< 3.12), python3-numpy"
              "renderer of OpenVDB volumes, Python module" "This package holds the module scrim of Python.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS scrim-pictures)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3-scrim, scrim-ax")
set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-tornado, python3-tomlkit") # for scrim view
# The dependency of packages that use the library, and the trigger that makes the library known: CPack's own way calls
# ldconfig by hand.
file(WRITE ${PROJECT_BINARY_DIR}/debian/shlibs "libscrim ${SCRIM_ABI} ${scrim_library} ${scrim_same}\n")
file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/shlibs ${PROJECT_BINARY_DIR}/debian/triggers)
set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/debian/postinst
                                                     ${CMAKE_CURRENT_LIST_DIR}/debian/prerm)
set(CPACK_SCRIM_SOURCE ${PROJECT_SOURCE_DIR}) # for finish.cmake
set(CPACK_SCRIM_PACKAGES library:${scrim_library} program:scrim pictures:scrim-pictures development:libscrim-dev
                         debian_python:python3-scrim)
if(SCRIM_WITH_AX)
    list(APPEND CPACK_SCRIM_PACKAGES ax:scrim-ax)
endif()
include(CPack)
