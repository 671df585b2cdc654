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
echo "== building ($preset)"
cmake --build --preset "$preset" -- --quiet
echo "== testing ($preset)"
# Sanitizers slow brute force down most and learn least from it: the same code runs in quicker tests.
quick=()
[ "$preset" = "asan" ] &&
    quick=(-LE pictures -E 'OrderOfThickness|RealFile|SlideInSmoke|Classified.AgreesWithBruteForce|NineAllRound|Popping')
ctest --preset "$preset" -j "$(nproc)" "${quick[@]}"
if [ "$preset" = "release" ] && [ -x tests/install/check.sh ]; then
    echo "== the installed package"
    tests/install/check.sh "$build"
fi
