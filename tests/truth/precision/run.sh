#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# How much of a picture is rounding? Renders pictures with the engine as it is and with the same engine compiled to compute
# in double precision (the CMake option SCRIM_DOUBLE, see src/scrim/base/real.h), and compares every channel: the largest
# difference of any pixel, over the channel's brightest value, must be below a hundred-thousandth.
#   tests/truth/precision/run.sh     of the float build in $SCRIM_BUILD, else build; the other is made in build-double
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$(cd "$here/../../.." && pwd)"
build="${SCRIM_BUILD:-$root/build}"
double="$root/build-double"
compare="$build/bin/scrim_same_pixels"
for program in "$build/bin/scrim" "$compare"; do
    [ -x "$program" ] || { echo "run.sh: no $program; tests/run.sh builds it" >&2; exit 2; }
done

echo "-- building the engine in double precision"
bash "$root/src/cmake/configure.sh" release "$double" -DSCRIM_DOUBLE=ON -DSCRIM_BUILD_TESTS=OFF -DSCRIM_BUILD_BENCHMARKS=OFF
cmake --build "$double" --target scrim_cli scrim_source_noise scrim_source_primitives -- --quiet

pictures="$(mktemp -d)"
trap 'rm -rf "$pictures"' EXIT
worst=0 failed=0 number=0
# picture NAME SCENE ARGUMENT...: one of the scenes of tests/tools/identity.
picture() {
    local name="$2-$1" scene="$root/tests/tools/identity/scenes/$2.toml"
    shift 2
    "$build/bin/scrim" render "$scene" "$@" -q -o "$pictures/float.exr"
    "$double/bin/scrim" render "$scene" "$@" -q -o "$pictures/double.exr"
    "$compare" --list "$pictures/float.exr" "$pictures/double.exr" >"$pictures/gaps"
    local channel gap
    read -r channel gap < <(sort -g -k 2 "$pictures/gaps" | tail -1)
    printf '%-24s %9s  %s\n' "$name" "$gap" "$channel"
    number=$((number + 1))
    worst="$(awk -v a="$worst" -v b="$gap" 'BEGIN {print (a + 0 > b + 0) ? a : b}')"
    awk -v gap="$gap" 'BEGIN {exit !(gap < 1e-5)}' || failed=$((failed + 1))
}

echo "-- rendering"
slide=(--set light.lamp.type=spot --set light.lamp.cone=50 --set "light.lamp.position=[2.1,3,1.2]"
    --set "light.lamp.target=[0,0,0]" --set light.lamp.intensity=200 --set light.lamp.slide.fov=40
    --set "light.lamp.slide.file=$root/examples/first.jpg")
# Without a word about it these scenes are shaded at pixels.
picture plain media
picture behind media --set "light.key.direction=[0.3,-0.4,1]"
picture lamp-within media --set "light.lamp.position=[0.2,0.1,0]"
picture texels media --set render.shade=texel
picture per-view media --set render.splat=per-view
picture slide media "${slide[@]}"
picture slide-texels media "${slide[@]}" --set render.shade=texel
picture eye-within media --set "camera.position=[0.1,0.2,0.3]" --set "camera.target=[1,0,0]" --set camera.fov=80
picture bspline media --set render.kernel=bspline
picture orthographic media --set camera.type=orthographic --set camera.height=2.5 --set render.splat=per-view
picture plain surfaces
picture texels surfaces --set render.shade=texel
picture per-view surfaces --set render.splat=per-view
picture plain effects
picture texels effects --set render.shade=texel
picture per-view effects --set render.splat=per-view

echo "$number pictures, of which $failed differ by a hundred-thousandth or more; the largest difference is $worst"
# Two builds of one precision would differ by nothing.
[ "$failed" -eq 0 ] && [ "$worst" != 0 ]
