#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# packages.sh BUILD_DIR [FOLDER]: makes Debian packages from a finished build, in FOLDER (default: BUILD_DIR/packages). The
# build must use Debian's folders, as configure.sh sets them; python3-scrim needs -DSCRIM_BUILD_PYTHON=ON.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="$(cd "${1:?usage: packages.sh BUILD_DIR [FOLDER]}" && pwd)"
out="${2:-$build/packages}"
bash "$root/src/cmake/install_packages.sh" dpkg-dev file
cmake --build "$build" --target scrim_python_plain scrim_python_stub -- --quiet
mkdir -p "$out"
rm -f "$out"/*.deb
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
umask 022
(cd "$build" && cpack --config CPackConfig.cmake -B "$out") >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
rm -rf "$out/_CPack_Packages"
ls -l "$out" | awk '/\.deb$/ { printf "%7.2f MB  %s\n", $5 / 1e6, $9 }'
