# SPDX-License-Identifier: Apache-2.0
# How our own code is compiled: an interface target instead of global flags, so that nothing leaks into consumers.
add_library(scrim_build_settings INTERFACE)
target_compile_features(scrim_build_settings INTERFACE cxx_std_20)
target_compile_options(
    scrim_build_settings
    INTERFACE # No fused multiply-add but those that the code names: pixels then do not depend on what gets inlined where.
              -ffp-contract=off
              -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
              # GCC 12 sees overlapping copies in the concatenation of strings where there are none (its bug 105651).
              $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> $<$<BOOL:${SCRIM_WERROR}>:-Werror>)
if(SCRIM_SANITIZE)
    target_compile_options(scrim_build_settings INTERFACE -fsanitize=${SCRIM_SANITIZE} -fno-omit-frame-pointer
                                                          -fno-sanitize-recover=all)
    target_link_options(scrim_build_settings INTERFACE -fsanitize=${SCRIM_SANITIZE})
endif()
if(SCRIM_BUILD_FUZZERS) # the fuzzers see which branches an input takes
    target_compile_options(scrim_build_settings INTERFACE -fsanitize=fuzzer-no-link)
endif()
