#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What shadows cost and how right they are, for every scene of examples/paper: prints a table in Markdown. Time with
# shadows over time without is the paper's own measure (section 3.2: 1.56 for the bonsai tree, "less than twice" for all).
#   tests/tools/bench/figures.sh [NAME...]     all scenes, or these; needs a build (SCRIM_BUILD names it), and a quiet
#                                        machine
# Seconds are those of "render" in --stats: the median of five runs with shadows and five without, taken by turns, on two
# threads, at the scene's own resolution. The error is that of --verify: relative RMSE against brute force at random
# pixels, with its 95 % interval. Scenes of scans need the folder $SCRIM_DATA (default: ../shared/data beside the
# repository). SCRIM_RUNS, SCRIM_PIXELS and SCRIM_THREADS change the numbers of runs (5), pixels (24) and threads (2).
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)"
scrim="${SCRIM_BUILD:-$root/build}/bin/scrim"
scenes="$root/examples/paper"
SCRIM_DATA="$(realpath -m "${SCRIM_DATA:-$root/../shared/data}")"
export SCRIM_DATA
runs="${SCRIM_RUNS:-5}" pixels="${SCRIM_PIXELS:-24}" threads="${SCRIM_THREADS:-2}"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

# number KEY: its first value in the statistics of the last run. They are indented JSON, one key a line.
number() { sed -n "s/^ *\"$1\": \([-0-9.e+]*\),*\$/\1/p" "$work/stats.json" | head -n 1; }

# render SCENE [OPTION...]: one run, quietly.
render() {
    local scene="$1"
    shift
    "$scrim" render "$scenes/$scene.toml" -o "$work/x.exr" --stats "$work/stats.json" --threads "$threads" -q "$@"
}

median() { sort -g | awk '{ v[NR] = $1 } END { print NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2 }'; }

# The lights of a scene, by name, as options that take their shadows away.
without_shadows() {
    awk '/^\[\[/ { light = $0 == "[[light]]" } light && /^name = / { gsub(/"/, "", $3); print "--set"; print "light." $3 ".shadows=false" }' \
        "$scenes/$1.toml"
}

# row TITLE SCENE [OPTION...]: a row of the table.
row() {
    local title="$1" scene="$2" with without i
    shift 2
    if grep -q 'SCRIM_DATA}' "$scenes/$scene.toml" && [ ! -d "$SCRIM_DATA/scan" ]; then
        echo "| $title | no folder $SCRIM_DATA/scan | | | |"
        return
    fi
    local bare=()
    mapfile -t bare < <(without_shadows "$scene")
    : >"$work/with" && : >"$work/without"
    for ((i = 0; i < runs; i++)); do
        render "$scene" "$@" && number render >>"$work/with"
        render "$scene" "$@" "${bare[@]}" && number render >>"$work/without"
    done
    with="$(median <"$work/with")" without="$(median <"$work/without")"
    local error="-"
    if [ "$pixels" -gt 0 ]; then
        render "$scene" "$@" --verify "$pixels"
        error="$(awk -v e="$(number error)" -v l="$(number lower)" -v u="$(number upper)" \
            'BEGIN { printf "%.2f (%.2f to %.2f)", 100 * e, 100 * l, 100 * u }')"
    fi
    awk -v t="$title" -v a="$with" -v b="$without" -v e="$error" \
        'BEGIN { printf "| %s | %.3f | %.3f | %.2f | %s |\n", t, a, b, a / b, e }'
}

echo "| scene | with shadows, s | without, s | ratio | error, % |"
echo "| --- | --- | --- | --- | --- |"
names=("$@")
if [ ${#names[@]} -eq 0 ]; then
    for file in "$scenes"/*.toml; do
        name="$(basename "$file" .toml)"
        case "$name" in bonsai | beams_unattenuated) ;; *) names+=("$name") ;; esac
    done
    names+=(bonsai)
fi
for name in "${names[@]}"; do
    if [ "$name" != bonsai ]; then
        row "$name" "$name"
        continue
    fi
    # The paper's timing: 256 x 256 x 128 voxels to 512 x 512 pixels. An orthographic camera has no 'fov'.
    row "bonsai, shared, perspective" bonsai
    row "bonsai, per-view, perspective" bonsai --set render.splat=per-view
    sed 's/^fov = .*/height = 330/; s/^\[camera\]/[camera]\ntype = "orthographic"/' "$scenes/bonsai.toml" >"$work/ortho.toml"
    scenes="$work"
    row "bonsai, shared, orthographic" ortho
    row "bonsai, per-view, orthographic" ortho --set render.splat=per-view
    row "bonsai, per-view, orthographic, image-aligned" ortho --set render.splat=per-view --set render.sheets=image-aligned
    scenes="$root/examples/paper"
done
