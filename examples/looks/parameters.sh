#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders the contact sheet of shading keys: a row for each key, with four values from left to right. Needs a build with
# OpenVDB AX (SCRIM_BUILD names it; default: build in the repository) and oiiotool.
#   examples/looks/parameters.sh [FOLDER]     FOLDER: where the pictures go (default: parameters in the build)
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="${SCRIM_BUILD:-$here/../../build}"
folder="${1:-$build/parameters}"
mkdir -p "$folder"
cd "$folder"

# A ball of smoke that is hot below and in its middle.
cat >ball.toml <<'END'
scene_version = 2
[camera]
position = [0, 0.1, 4.6]
target = [0, 0, 0]
fov = 30
resolution = [144, 108]
[[volume]]
name = "ball"
source = "noise"
parameters = { shape = "ball", size = 2, resolution = 96, frequency = 2.5, octaves = 4, softness = 0.8, seed = 3 }
ax = 'vec3f p = getvoxelpws(); f@heat = clamp(f@density * (0.9 - 0.9 * p.y), 0, 1);'
density = { scale = 6 }
[volume.medium]
albedo = [0.9, 0.9, 0.9]
[[light]]
type = "distant"
direction = [-0.7, -0.7, -0.5]
intensity = 9
[ambient]
color = [0.5, 0.55, 0.7]
END

rows=()
row() { # CAPTION OPTION VALUE...: OPTION is the key that gets the values; further --set in `more`
    local caption="$1" key="$2" at=0 pictures=()
    shift 2
    for value in "$@"; do
        at=$((at + 1))
        local name="row${#rows[@]}_$at"
        "$build/bin/scrim" render ball.toml -o "$name.exr" --preview "$name.png" --quality standard -q \
            "${more[@]/#/--set=}" "--set=$key=$value"
        pictures+=("$name.png")
    done
    local file="row${#rows[@]}.png" text="font=DejaVuSans:color=0.9,0.9,0.9"
    oiiotool "${pictures[@]}" --mosaic:pad=2 "$at"x1 --ch R,G,B -o pictures.png
    oiiotool pictures.png --create 822x108 3 --addc 0.05 --paste +240+0 \
        "--text:x=8:y=50:size=14:$text" "${caption%%: *}" "--text:x=8:y=70:size=12:$text" "${caption#*: }" -o "$file"
    rows+=("$file")
}
v=volume.ball d=volume.ball.density m=volume.ball.medium

more=()
row "density.remap: from = [0, 1] ... [0.6, 1]" $d.remap.from '[0, 1]' '[0.2, 1]' '[0.4, 1]' '[0.6, 1]'
row "density.remap: gamma = 0.5, 1, 2, 4" $d.remap.gamma 0.5 1 2 4
row "density.remap: contrast = 0.5, 1, 2, 6" $d.remap.contrast 0.5 1 2 6
row "density.edge: [0, 0.01] ... [0.6, 0.65]" $d.edge '[0, 0.01]' '[0.2, 0.3]' '[0.4, 0.5]' '[0.6, 0.65]'
more=("$d.mask.grid=heat")
row "density.mask: to = [1, 1], [0, 1], [1, 0], [0, 3]" $d.mask.to '[1, 1]' '[0, 1]' '[1, 0]' '[0, 3]'
more=("$d.noise.frequency=3")
row "density.noise: amount = 0, 1, 2, 4" $d.noise.amount 0 1 2 4
more=("$d.noise.amount=3")
row "density.noise: frequency = 1, 2, 4, 8" $d.noise.frequency 1 2 4 8
more=("$d.noise.frequency=2" "$d.noise_mode=erode")
row "density.noise_mode = erode: amount = 0, 0.5, 1, 1.5" $d.noise.amount 0 0.5 1 1.5
more=("$v.displacement.frequency=1.5")
row "displacement: amount = 0, 0.1, 0.25, 0.5" $v.displacement.amount 0 0.1 0.25 0.5
more=("$v.displacement.amount=0.2")
row "displacement: frequency = 0.7, 1.5, 3, 6" $v.displacement.frequency 0.7 1.5 3 6
more=()
row "medium.albedo: ramp over a grid" $m.albedo '[0.9, 0.9, 0.9]' \
    '{ grid = "heat", ramp = [[0, [0.9, 0.9, 0.9]], [0.6, [0.7, 0.2, 0.1]]] }' \
    '{ grid = "heat", ramp = [[0.2, [0.2, 0.4, 0.8]], [0.5, [0.9, 0.8, 0.6]]] }' \
    '{ grid = "heat", ramp = [[0.1, [0.1, 0.1, 0.1]], [0.5, [0.95, 0.95, 0.95]]] }'
row "medium.transparency: white to coloured" $m.transparency '[0.37, 0.37, 0.37]' '[0.6, 0.4, 0.3]' '[0.3, 0.5, 0.8]' \
    '[0.2, 0.7, 0.3]'
more=("$m.transparency=[0.6, 0.4, 0.3]")
row "medium.transparency_depth: 0.3, 1, 3, 10" $m.transparency_depth 0.3 1 3 10
more=("$m.emission={ grid = 'heat', scale = 3, ramp = [[0, [0, 0, 0]], [0.5, [1, 0.3, 0.05]]], mask = { grid = 'heat' } }")
row "medium.emission.mask: from = [0, 1] ... [0.6, 0.7]" $m.emission.mask.from '[0, 1]' '[0.2, 0.6]' '[0.4, 0.6]' \
    '[0.6, 0.7]'
more=("$m.blackbody={ grid = 'heat', kelvin = [400, 2200], intensity = 12 }" "$d.scale=2")
row "medium.blackbody: physical_intensity = 1, 0.7, 0.4, 0" $m.blackbody.physical_intensity 1 0.7 0.4 0
more=("$m.blackbody={ grid = 'heat', kelvin = [400, 2200], intensity = 12, physical_intensity = 0.7 }" "$d.scale=2")
row "medium.blackbody: tint" $m.blackbody.tint '[1, 1, 1]' '[1, 0.4, 0.2]' '[0.3, 1, 0.4]' '[0.3, 0.5, 2]'
more=("$v.parameters.resolution=20")
row "interpolation: linear, smooth (20 voxels)" $v.interpolation linear smooth
more=("$v.parameters.resolution=24" "$d.noise.amount=1" "$d.noise.frequency=7")
row "resample: 1, 2, 3, 4 (24 voxels and noise)" $v.resample 1 2 3 4
more=()
row "clip: boxes" $v.clip '[[-2, -2, -2], [2, 2, 2]]' '[[-2, -2, -2], [2, 2, 0.3]]' '[[-2, -0.4, -2], [2, 0.4, 2]]' \
    '[[-0.5, -0.5, -2], [0.5, 0.5, 2]]'

half=$(((${#rows[@]} + 1) / 2))
for part in 0 1; do
    oiiotool "${rows[@]:part * half:half}" --mosaic:pad=2 1x"$half" -o "column$part.png"
done
oiiotool column0.png column1.png --mosaic:pad=12 2x1 --eraseattrib ".*" --nosoftwareattrib -d uint8 \
    --compression jpeg:88 -o "$here/parameters.jpg"
