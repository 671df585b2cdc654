#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders the gallery: every scene of this folder as OpenEXR into a folder, and as JPEG into pictures/ beside this
# script. Needs a build (SCRIM_BUILD names it; default: build in the repository).
#   examples/paper/render.sh [FOLDER [NAME...]]     FOLDER: default gallery in the build; NAME: only these scenes
# Scenes of scans need the folder $SCRIM_DATA (default: ../shared/data beside the repository) and are left out without.
# SCRIM_GALLERY_SIZE sets the pictures' edge, in pixels (512).
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$(cd "$here/../.." && pwd)"
build="${SCRIM_BUILD:-$root/build}"
scrim="$build/bin/scrim"
SCRIM_DATA="$(realpath -m "${SCRIM_DATA:-$root/../shared/data}")"
export SCRIM_DATA
size="${SCRIM_GALLERY_SIZE:-512}"
folder="${1:-$build/gallery}"
[ $# -gt 0 ] && shift
wanted=("$@")
pictures="$here/pictures"

if [ ! -x "$scrim" ]; then
    echo "render.sh: no $scrim: build Scrim first, or name its build folder in SCRIM_BUILD" >&2
    exit 1
fi
mkdir -p "$folder" "$pictures"

# picture NAME SCENE [--set ...]: one picture of a scene.
picture() {
    local name="$1" scene="$2"
    shift 2
    if [ ${#wanted[@]} -gt 0 ] && [[ " ${wanted[*]} " != *" $scene "* ]]; then return; fi
    if grep -q 'SCRIM_DATA}' "$here/$scene.toml" && [ ! -d "$SCRIM_DATA/scan" ]; then
        echo "$name: left out: no folder $SCRIM_DATA/scan (SCRIM_DATA names the folder of scans)"
        return
    fi
    # oiiotool, where there is one, writes JPEG of a chosen quality and without the command line in it.
    local preview="$pictures/$name.jpg"
    command -v oiiotool >/dev/null && preview="$folder/$name.png"
    "$scrim" render "$here/$scene.toml" -o "$folder/$name.exr" --preview "$preview" --res "${size}x${size}" \
        --progress none "$@"
    if [ "$preview" != "$pictures/$name.jpg" ]; then
        oiiotool --nosoftwareattrib "$preview" --eraseattrib ".*" --compression jpeg:88 -o "$pictures/$name.jpg"
    fi
}

picture teddy teddy
picture bonsai bonsai
picture room_haze room_haze
picture hipip_grid hipip_grid
picture hipip_grid_without_shadow hipip_grid --set light.grid.shadows=false
picture robot robot
picture rings rings
picture smoky_room smoky_room
picture room room
picture smooth_objects smooth_objects
picture smooth_objects_without_shadow smooth_objects --set light.sun.shadows=false
picture brain brain
picture robot_two_lights robot_two_lights
picture robot_one_light robot_two_lights --set light.second.intensity=0
picture slide_rings slide_rings
picture slide_logo slide_logo
picture beams beams
picture beams_unattenuated beams_unattenuated
picture perpendicular perpendicular
picture perpendicular_without_shadow perpendicular --set light.beam.shadows=false
picture perpendicular_image_aligned perpendicular --set render.sheets=image-aligned --set render.splat=per-view \
    --set render.max_slant=85
picture rings_two_lights rings_two_lights
picture lights_around lights_around
picture light_inside light_inside
picture nine_lights nine_lights
