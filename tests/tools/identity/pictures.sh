#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Prints the pictures that run.sh compares, one a line: a name, and the arguments of `scrim render`, split by tabs.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$here/../../.."
data="${SCRIM_DATA:-$root/../shared/data}"

picture() { # NAME ARGUMENT...
    printf '%s' "$1"
    shift
    printf '\t%s' "$@"
    printf '\n'
}
# from NAME SCENE ARGUMENT...: one of the scenes beside this script.
from() {
    local name="$1" scene="$2"
    shift 2
    picture "$scene-$name" "$here/scenes/$scene.toml" "$@"
}

# Lights from all sides, of all kinds, outside of the volume and within: both orders of compositing, all cuts of a light.
number=0
for x in -1 0 1; do
    for y in -1 0 1; do
        for z in -1 0 1; do
            [ "$x$y$z" != 000 ] || continue
            number=$((number + 1))
            from "distant$number" media --set "light.key.direction=[$x,$y.1,$z.05]"
            from "point$number" media --set "light.lamp.position=[$((2 * x)),$((2 * y)).3,$((2 * z)).2]"
            if [ $((number % 3)) = 0 ]; then
                from "within$number" media --set "light.lamp.position=[0.$((x + 1)),0.$((y + 1)),0.$((z + 1))]"
                from "spot$number" surfaces --set "light.spot.position=[$((2 * x)),$((2 * y)).2,$((2 * z)).1]"
                from "back$number" surfaces --set "light.back.direction=[$x.2,$y.1,$z]"
                from "key$number" effects --set "light.key.direction=[$x,$y.1,$z.05]"
                from "slide$number" media --set "light.lamp.type=spot" --set "light.lamp.cone=50" \
                    --set "light.lamp.position=[$((3 * x)).1,$((3 * y)),$((3 * z)).2]" --set "light.lamp.target=[0,0,0]" \
                    --set "light.lamp.intensity=200" --set "light.lamp.slide.fov=40" \
                    --set "light.lamp.slide.file=$root/examples/first.jpg"
            fi
        done
    done
done

# Every dial, on every scene.
for scene in media surfaces effects; do
    from plain "$scene"
    for dial in texel=1.1 kernel=gaussian kernel=bspline shade=texel shade=pixel shadow_filter=nearest sheets=image-aligned \
        splat=per-view simd=sse4 simd=avx2 lod=8 antialias=2 opacity_cutoff=0.2 texel=0.35 sheet_thickness=3 \
        footprint_steps=4 max_slant=30 cross_fade=20 shadow_texel=2; do
        from "$dial" "$scene" --set "render.$dial"
    done
    from per-view-plane "$scene" --set render.splat=per-view --set render.shadow_plane=image \
        --set render.cross_fade=0 --set "light[1].intensity=0"
    for quality in draft high; do from "$quality" "$scene" --quality "$quality"; done
    from crop "$scene" --crop 20,17,41,39
    from crop-per-view "$scene" --crop 20,17,41,39 --set render.splat=per-view
    from crop-pixels "$scene" --crop 3,5,64,20 --set render.shade=pixel
    from overscan "$scene" --set camera.overscan=9
    from wide "$scene" --set camera.fov=130
    from orthographic "$scene" --set camera.type=orthographic --set camera.height=2.5
    from orthographic-per-view "$scene" --set camera.type=orthographic --set camera.height=2.5 --set render.splat=per-view
    from within "$scene" --set "camera.position=[0.1,0.2,0.3]" --set "camera.target=[1,0,0]" --set camera.fov=80
    from near "$scene" --set camera.near=3.2
    from passes "$scene" --memory 9M
    from layers "$scene" --set 'output.layers=["light","ambient","emission","albedo","depth","transmittance"]'
    from depth-pixels "$scene" --set 'output.layers=["depth"]' --set render.shade=pixel
    from one-thread "$scene" --threads 1
done
from slide-repeat media --set "light.key.slide.file=$root/examples/first.jpg" --set light.key.slide.width=0.4 \
    --set "light.key.position=[0,0,0]" --set light.key.slide.outside=repeat
from slide-clamp media --set "light.key.slide.file=$root/examples/first.jpg" --set light.key.slide.width=0.4 \
    --set "light.key.position=[0,0,0]" --set light.key.slide.outside=clamp
from no-shadows media --set light.key.shadows=false --set light.lamp.shadows=false

# Examples and the figures of the paper.
for scene in "$root"/examples/scenes/*.toml "$root"/examples/paper/*.toml; do
    if grep -q SCRIM_DATA "$scene"; then [ -d "$data" ] || continue; fi
    # Volumes that take seconds to make: coarser ones show as much.
    case "$(basename "$scene" .toml)" in
        first) coarser="volume.plume.parameters.resolution=64" ;;
        lamps | projector) coarser="volume.fog.parameters.resolution=48" ;;
        light_inside | room | slide_logo | smoky_room | rings | nine_lights) coarser="render.quality=draft" ;;
        *) coarser="output.type=float" ;;
    esac
    picture "example-$(basename "$scene" .toml)" "$scene" --frames 1 --res 80x80 --set output.type=float --set "$coarser"
done

# Real volumes.
[ -d "$data" ] || exit 0
for asset in "$data"/vdb/*.vdb "$data"/usd/*.vdb "$data"/sequence/*/*[05].vdb "$data"/edge/*.vdb; do
    # Not all that lies there is a volume that can be shown.
    case "$asset" in *points*.vdb | *pointgrid*.vdb) continue ;; esac
    picture "asset-$(basename "$(dirname "$asset")")-$(basename "$asset" .vdb)" "$asset" --res 72x56 --set output.type=float
done
for dial in splat=per-view shade=pixel; do
    picture "asset-smoke1-$dial" "$data/vdb/smoke1.vdb" --res 72x56 --set output.type=float --set "render.$dial"
done
