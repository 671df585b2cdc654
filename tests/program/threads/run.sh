#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders side by side under the thread sanitizer. Debian's oneTBB is not built with it and gives false reports, and to
# suppress those would hide real ones: so oneTBB is built with it first, from Debian's source package.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)"
build="$root/build-tsan"
tbb="$build/tbb"
sudo=""
[ "$(id -u)" -eq 0 ] || sudo="sudo"
bash "$root/src/cmake/install_packages.sh" libgtest-dev libbenchmark-dev xz-utils

if [ ! -e "$tbb/lib/libtbb.so" ]; then
    echo "== building oneTBB with the thread sanitizer"
    mkdir -p "$tbb/source"
    # The machine's own mirror, for sources; its lists stay as they are.
    uri="$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | head -n 1)"
    echo "deb-src ${uri:-http://deb.debian.org/debian} bookworm main" >"$tbb/sources.list"
    options=(-o "Dir::Etc::SourceList=$tbb/sources.list" -o Dir::Etc::SourceParts=/dev/null -o "Dir::State::Lists=$tbb/lists"
        -o APT::Sandbox::User=root)
    mkdir -p "$tbb/lists/partial"
    $sudo apt-get "${options[@]}" update -qq
    (cd "$tbb" && $sudo apt-get "${options[@]}" source -qq --download-only onetbb)
    tar -xf "$tbb"/onetbb_*.orig.tar.* -C "$tbb/source" --strip-components=1
    cmake -S "$tbb/source" -B "$tbb/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_TEST=OFF -DTBB_STRICT=OFF \
        -DTBBMALLOC_BUILD=OFF -DTBB_SANITIZE=thread >"$tbb/configure.log"
    cmake --build "$tbb/build" --target tbb -- --quiet >"$tbb/build.log" 2>&1 || { cat "$tbb/build.log" >&2; exit 1; }
    mkdir -p "$tbb/lib"
    find "$tbb/build" -name 'libtbb.so*' -exec cp -P {} "$tbb/lib" \;
fi

echo "== building the tests with the thread sanitizer"
bash "$root/src/cmake/configure.sh" tsan "$build"
cmake --build "$build" --target scrim_thread_tests -- --quiet
echo "== testing"
# The program asks for libtbb.so.12 and gets ours, which has the sanitizer's eyes.
ldd_of() { LD_LIBRARY_PATH="$tbb/lib" ldd "$build/bin/scrim_thread_tests"; }
ldd_of | grep -q "libtbb.so.12 => $tbb/lib" || { echo "threads/run.sh: the tests do not use the oneTBB built here" >&2; exit 1; }
LD_LIBRARY_PATH="$tbb/lib" TSAN_OPTIONS="halt_on_error=1 second_deadlock_stack=1" "$build/bin/scrim_thread_tests" --gtest_brief=1
