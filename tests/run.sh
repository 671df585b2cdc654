#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a bare Debian 12 to all tests passed: installs packages, builds, runs every test.
#   tests/run.sh              release build and tests, and the installed package
#   tests/run.sh --sanitize   the same tests, built with address and undefined-behaviour sanitizers
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
preset=release
[ "${1:-}" = "--sanitize" ] && preset=asan
build="$root/build"
[ "$preset" = "asan" ] && build="$root/build-asan"

bash "$root/src/cmake/install_packages.sh" libgtest-dev libbenchmark-dev
cd "$root"
echo "== configuring ($preset)"
cmake --preset "$preset" >/dev/null
# Whole programs at a time: a process for every test (as ctest has it) takes longer to start than to run. Sanitizers slow
# brute force down most and learn least from it, since the same code runs in quicker tests (and the
# engine's in those of stability and effects).
if [ "$preset" = "asan" ]; then
    export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
    export SCRIM_FUZZ_RUNS=20
    programs="error unit stability fuzz plugin effect"
    targets="--target $(printf 'scrim_%s_tests ' $programs)"
    filter='-*EveryAngle*:*TenThousandSheets*:*ManySheets*:Study.*:Ways/Place*:*Mutations*random_scene*:*AgreeWithBruteForce*:*classifiedPerView*'
else
    programs="error analytic paper stability fuzz unit engine plugin effect invariance"
    targets="" # all of them
    filter='*'
fi
echo "== building ($preset)"
# shellcheck disable=SC2086 # several words are meant
cmake --build --preset "$preset" $targets -- --quiet
echo "== testing ($preset)"
printf '%s\n' $programs |
    xargs -P "$(nproc)" -I{} env "$build/bin/scrim_{}_tests" --gtest_brief=1 --gtest_filter="$filter"
if [ "$preset" = "release" ] && [ -x tests/install/check.sh ]; then
    echo "== the installed package"
    tests/install/check.sh "$build"
fi
