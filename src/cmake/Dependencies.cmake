# SPDX-License-Identifier: Apache-2.0
# Finds the libraries that Scrim uses. Debian's packages have some traps, which are avoided here.

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(TBB CONFIG REQUIRED)  # before OpenVDB, whose module would replace it

# OpenVDB has no package config, but a find module in its own folder. That folder also holds modules for OpenEXR
# and TBB, and the module sets BUILD_SHARED_LIBS: both are undone right after.
set(scrim_module_path ${CMAKE_MODULE_PATH})
find_path(SCRIM_OPENVDB_MODULES FindOpenVDB.cmake
          PATHS /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB /usr/lib/cmake/OpenVDB
                /usr/lib64/cmake/OpenVDB /usr/local/lib/cmake/OpenVDB
          REQUIRED)
list(PREPEND CMAKE_MODULE_PATH ${SCRIM_OPENVDB_MODULES})
find_package(OpenVDB 10 REQUIRED COMPONENTS openvdb)
set(CMAKE_MODULE_PATH ${scrim_module_path})
unset(BUILD_SHARED_LIBS)
unset(BUILD_SHARED_LIBS CACHE)

# NanoVDB consists of headers. Its files may be compressed by Blosc, which OpenVDB uses, too.
find_path(SCRIM_NANOVDB_INCLUDE nanovdb/NanoVDB.h REQUIRED)
find_library(SCRIM_BLOSC_LIBRARY blosc REQUIRED)

# OpenVDB AX has no config of its own. It brings LLVM along, so that builds may do without it.
find_path(SCRIM_AX_INCLUDE openvdb_ax/ax.h)
find_library(SCRIM_AX_LIBRARY openvdb_ax)
if(SCRIM_AX_INCLUDE AND SCRIM_AX_LIBRARY)
    option(SCRIM_WITH_AX "Build the module that runs OpenVDB AX" ON)
else()
    option(SCRIM_WITH_AX "Build the module that runs OpenVDB AX" OFF)
    if(SCRIM_WITH_AX)
        message(FATAL_ERROR "SCRIM_WITH_AX needs OpenVDB AX (Debian: libopenvdb-ax-dev)")
    endif()
endif()

find_package(OpenEXR CONFIG REQUIRED)
find_package(OpenImageIO CONFIG REQUIRED)
# Its target names an include folder of OpenCV that does not exist.
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "")
pkg_check_modules(OpenColorIO REQUIRED IMPORTED_TARGET OpenColorIO)  # its CMake config has a wrong path

pkg_check_modules(seccomp REQUIRED IMPORTED_TARGET libseccomp)

pkg_check_modules(murmurhash REQUIRED IMPORTED_TARGET libmurmurhash)

find_package(glm CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(tomlplusplus CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(hwy CONFIG REQUIRED)
find_package(embree 3 CONFIG REQUIRED)

# Libraries of the volume sources. The CMake configs of Teem and NIfTI do not work, and that of
# GDCM wants all of its programs, so they are found by their files.
find_package(ZLIB REQUIRED)
find_package(assimp CONFIG REQUIRED)
find_path(SCRIM_TEEM_INCLUDE teem/nrrd.h REQUIRED)
find_library(SCRIM_TEEM_LIBRARY teem REQUIRED)
find_path(SCRIM_NIFTI_INCLUDE nifti2_io.h PATH_SUFFIXES nifti REQUIRED)
find_library(SCRIM_NIFTI_LIBRARY nifti2 REQUIRED)
add_library(scrim_teem INTERFACE)
target_include_directories(scrim_teem SYSTEM INTERFACE ${SCRIM_TEEM_INCLUDE})
target_link_libraries(scrim_teem INTERFACE ${SCRIM_TEEM_LIBRARY})
add_library(scrim_nifti INTERFACE)
target_include_directories(scrim_nifti SYSTEM INTERFACE ${SCRIM_NIFTI_INCLUDE})
target_link_libraries(scrim_nifti INTERFACE ${SCRIM_NIFTI_LIBRARY})
find_path(SCRIM_GDCM_INCLUDE gdcmImageReader.h PATH_SUFFIXES gdcm-3.0 REQUIRED)
add_library(scrim_gdcm INTERFACE)
target_include_directories(scrim_gdcm SYSTEM INTERFACE ${SCRIM_GDCM_INCLUDE})
foreach(part MSFF DSED Common)
    find_library(SCRIM_GDCM_${part} gdcm${part} REQUIRED)
    target_link_libraries(scrim_gdcm INTERFACE ${SCRIM_GDCM_${part}})
endforeach()
