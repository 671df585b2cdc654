#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a bare Debian 12 to a picture: installs packages, builds Scrim, makes a volume of smoke, renders it to EXR and
# PNG. Nothing but Debian packages is downloaded. Run it again and it only does what is not done yet.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="${SCRIM_BUILD:-$root/build}"
out="$build/quickstart"

echo "== packages"
bash "$root/src/cmake/install_packages.sh"

echo "== configuring in $build"
# A build that has tests keeps them: tests/run.sh was here first.
without_tests="-DSCRIM_BUILD_TESTS=OFF -DSCRIM_BUILD_BENCHMARKS=OFF"
grep -qs '^SCRIM_BUILD_TESTS:BOOL=ON' "$build/CMakeCache.txt" && without_tests=""
# shellcheck disable=SC2086 # several words are meant
bash "$root/src/cmake/configure.sh" release "$build" $without_tests
echo "== building the program (some minutes the first time)"
cmake --build "$build" --target scrim_cli -- --quiet

mkdir -p "$out"
if [ ! -f "$out/smoke.vdb" ]; then
    echo "== making $out/smoke.vdb"
    "$build/bin/scrim" make noise resolution=256 -o "$out/smoke.vdb"
fi
echo "== rendering $out/smoke.exr and $out/smoke.png"
"$build/bin/scrim" render "$out/smoke.vdb" -o "$out/smoke.exr" --preview "$out/smoke.png" --verify 100

echo
echo "Done. Look at $out/smoke.png; the picture to work with is $out/smoke.exr."
echo "Next: $build/bin/scrim render YOUR.vdb -o YOUR.exr"
