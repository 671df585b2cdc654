#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders the four pictures of the front page and joins them to strip.jpg, beside this script. Needs a build (SCRIM_BUILD
# names it; default: build in the repository), oiiotool, and the scans ($SCRIM_DATA; default: ../shared/data beside the
# repository).
#   examples/strip.sh [FOLDER]     FOLDER: where the pictures go (default: strip in the build)
# The sky behind the cloud is a gradient that the picture is laid over, as in a composite: no volume is that far away.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$(cd "$here/.." && pwd)"
build="${SCRIM_BUILD:-$root/build}"
folder="${1:-$build/strip}"
SCRIM_DATA="$(realpath -m "${SCRIM_DATA:-$root/../shared/data}")"
export SCRIM_DATA
[ -d "$SCRIM_DATA/scan" ] || { echo "strip.sh: no folder $SCRIM_DATA/scan (SCRIM_DATA names the folder of scans)" >&2; exit 1; }
mkdir -p "$folder"

picture() { # NAME [OPTION...]
    local name="$1"
    shift
    "$build/bin/scrim" render "$here/scenes/$name.toml" --res 400x400 -o "$folder/$name.exr" --preview "$folder/$name.png" \
        --progress none "$@"
}
picture room
picture cloud
picture campfire
picture scan

cd "$folder"
sky=0.16,0.17,0.30,1:topright=0.05,0.08,0.20,1:bottomleft=0.98,0.62,0.32,1:bottomright=0.55,0.30,0.36,1
oiiotool cloud.exr --fullpixels --ch A -o alpha.exr
oiiotool cloud.png --ch R,G,B alpha.exr --chappend --pattern "fill:topleft=$sky" 400x400 4 --over --ch R,G,B \
    -d uint8 -o cloud_sky.png
oiiotool --nosoftwareattrib room.png cloud_sky.png campfire.png scan.png --mosaic:pad=4 4x1 --eraseattrib ".*" \
    --compression jpeg:90 -o "$here/strip.jpg"
