#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# configure.sh PRESET BUILD_DIR [OPTION...]: configures a build. quickstart.sh and run.sh both use it, so that one build
# serves both, whichever runs first. Libraries go to Debian's folder for them, so that packages can be made from the same
# build.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
preset="$1" build="$2"
shift 2
# A folder that was configured elsewhere (a tree that was copied or moved) cannot be configured again.
home="$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt" 2>/dev/null || true)"
if [ -n "$home" ] && [ "$home" != "$root" ]; then rm -rf "$build/CMakeCache.txt" "$build/CMakeFiles"; fi
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
cd "$root"
multiarch="$(dpkg-architecture -qDEB_HOST_MULTIARCH 2>/dev/null || gcc -print-multiarch)"
cmake --preset "$preset" -B "$build" -DCMAKE_INSTALL_LIBDIR="lib/$multiarch" ${CI:+-DSCRIM_WERROR=ON} "$@" >"$log" 2>&1 || {
    cat "$log" >&2
    exit 1
}
