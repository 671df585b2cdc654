#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Does a change of the code change a picture? Renders the pictures of pictures.sh with this tree's build and with that of
# a commit from before, and compares all channels of all pixels bit by bit. What headers say may differ.
#   tests/tools/identity/run.sh [--within RELATIVE] [COMMIT]     COMMIT: of before; else the one in the file `baseline`
# A picture that either build fails to render must fail in both. First a change of one ulp of one light is planted, which
# must be found. `baseline`'s build and its pictures are kept in build-baseline.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$(cd "$here/../../.." && pwd)"
within=0
if [ "${1:-}" = "--within" ]; then
    within="$2"
    shift 2
fi
commit="$(git -C "$root" rev-parse "${1:-$(cat "$here/baseline")}")"
build="${SCRIM_BUILD:-$root/build}"
before="$root/build-baseline/$commit"
export SCRIM_DATA="${SCRIM_DATA:-$root/../shared/data}"

if [ ! -x "$before/build/bin/scrim" ]; then
    echo "-- building $commit"
    mkdir -p "$before/tree"
    git -C "$root" archive "$commit" | tar x -C "$before/tree"
    bash "$before/tree/src/cmake/configure.sh" release "$before/build" -DSCRIM_BUILD_TESTS=OFF -DSCRIM_BUILD_BENCHMARKS=OFF
    cmake --build "$before/build" -- --quiet
fi
compare="$build/bin/scrim_same_pixels"
[ -x "$compare" ] || { echo "run.sh: no $compare; tests/run.sh builds it" >&2; exit 2; }

# render BUILD FOLDER: the pictures of the list that FOLDER lacks; of those that fail the reason instead.
list="$(mktemp)"
trap 'rm -f "$list"' EXIT
"$here/pictures.sh" >"$list"
render() {
    mkdir -p "$2"
    # shellcheck disable=SC2016
    tr '\n' '\0' <"$list" | xargs -0 -P "$(nproc)" -I{} bash -c '
        IFS=$'"'\t'"' read -r -a words <<<"$3"
        name="$2/${words[0]}"
        [ -e "$name.exr" ] || [ -e "$name.failed" ] || "$1/bin/scrim" render "${words[@]:1}" -q -o "$name.exr" \
            >"$name.log" 2>&1 || { [ $? -eq 5 ] || mv "$name.log" "$name.failed"; }' render "$1" "$2" {}
}
echo "-- rendering $(wc -l <"$list") pictures twice"
render "$before/build" "$before/pictures"
after="$root/build-baseline/after"
rm -rf "$after"
render "$build" "$after"

echo "-- planting one ulp"
"$build/bin/scrim" render "$here/scenes/media.toml" --set light.key.intensity=9.0000009 -q -o "$after/planted.exr"
if "$compare" "$before/pictures/media-plain.exr" "$after/planted.exr" >/dev/null; then
    echo "run.sh: a planted change of one ulp was not found" >&2
    exit 1
fi

same=0 failed=0 differ=0
while IFS=$'\t' read -r name _; do
    if [ -e "$before/pictures/$name.failed" ] && [ -e "$after/$name.failed" ]; then
        failed=$((failed + 1))
    elif [ -e "$before/pictures/$name.exr" ] && [ -e "$after/$name.exr" ] &&
        "$compare" --within "$within" "$before/pictures/$name.exr" "$after/$name.exr"; then
        same=$((same + 1))
    else
        [ ! -e "$after/$name.failed" ] || cat "$after/$name.failed"
        echo "   differs: $name"
        differ=$((differ + 1))
    fi
done <"$list"
echo "$same pictures are the same, $differ differ, $failed fail in both"
[ "$differ" -eq 0 ] && [ "$same" -ge 150 ]
