# SPDX-License-Identifier: Apache-2.0
# The settings for compiling our own code. They are an interface target and not global flags, so that consumers do not
# inherit them.
add_library(scrim_build_settings INTERFACE)
target_compile_features(scrim_build_settings INTERFACE cxx_std_20)
target_compile_options(
    scrim_build_settings
    INTERFACE # Only explicit fused multiply-adds: otherwise pixels would depend on what is inlined where.
              -ffp-contract=off
              -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
              # GCC 12 wrongly warns of overlapping copies when strings are concatenated (its bug 105651).
              $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> $<$<BOOL:${SCRIM_WERROR}>:-Werror>)
if(SCRIM_SANITIZE)
    target_compile_options(scrim_build_settings INTERFACE -fsanitize=${SCRIM_SANITIZE} -fno-omit-frame-pointer
                                                          -fno-sanitize-recover=all)
    # These checks look for faults that end in a crash. The address sanitizer explains such crashes, and with the checks
    # the code would be twice as large.
    if(SCRIM_SANITIZE MATCHES "address.*undefined")
        target_compile_options(scrim_build_settings
                               INTERFACE -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow
                                         -fno-sanitize=nonnull-attribute,returns-nonnull-attribute)
    endif()
    target_link_options(scrim_build_settings INTERFACE -fsanitize=${SCRIM_SANITIZE})
endif()
if(SCRIM_BUILD_FUZZERS) # lets fuzzers see which branches an input takes
    target_compile_options(scrim_build_settings INTERFACE -fsanitize=fuzzer-no-link)
endif()

# What runs once a frame is quick enough without most of the optimiser, which would take half the time of the build.
# OpenVDB's templates would take ten minutes and 4 GB a file with the undefined-behaviour sanitizer.
set(SCRIM_ONCE_OPTIONS -O1)
set(SCRIM_OPENVDB_OPTIONS -O1)
if(SCRIM_SANITIZE)
    set(SCRIM_ONCE_OPTIONS -O0)
    set(SCRIM_OPENVDB_OPTIONS -O0 -fno-sanitize=all)
endif()
