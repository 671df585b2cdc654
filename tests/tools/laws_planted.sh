#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# laws_planted.sh [BUILD [NAME ...]]: how much the laws of tests/truth/laws see. Plants bugs that a person could make,
# one at a time: each in a copy of one source file, from which a library of its own is linked. Checks drawn scenes 1 to
# 300 with it, and prints 'NAME: found by scene S, law L' or 'NAME: not found'. Fails if any was not found.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="$(cd "${1:-$root/build}" && pwd)"
shift || true
only=" $* "
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cd "$build"
library="$(ls lib/*/libscrim.so.*.*.*)"
missed=0

commandOf() { # TARGET: what builds it
    ninja -t commands "$1" | tail -1 | sed 's|^[^ ]*ccache ||'
}

plant() { # NAME FILE CODE PLANTED
    [[ "$only" == "  " || "$only" == *" $1 "* ]] || return 0
    local file="scrim/$2" object="src/CMakeFiles/scrim.dir/scrim/$2.o" dir="$work/$1" command first log
    mkdir -p "$dir/src/$(dirname "$file")" "$dir/lib"
    if [ "$(grep -cF "$3" "$root/src/$file")" -ne 1 ]; then
        echo "laws_planted.sh: $2: expected one line with '$3'" >&2
        exit 2
    fi
    CODE="$3" PLANTED="$4" perl -pe 's/\Q$ENV{CODE}\E/$ENV{PLANTED}/' "$root/src/$file" >"$dir/src/$file"
    command="$(commandOf "$object")"
    command="${command/-o $object/-o $dir/planted.o}"
    command="${command/-MF $object.d/-MF $dir/planted.d}"
    command="${command/-c $root\/src\/$file/-c $dir/src/$file}"
    eval "${command/-I$root\/src/-I$dir/src -I$root/src}"
    command="$(commandOf "$library")"
    command="${command/$object/$dir/planted.o}"
    eval "${command/-o $library/-o $dir/lib/$(basename "${library%.*.*}")}"
    log="$dir/log"
    for ((first = 1; first < 300; first += 20)); do
        SCRIM_LAWS_SHRINK=0 LD_LIBRARY_PATH="$dir/lib" "$root/tests/tools/laws.sh" $first 20 "$build" >"$log" 2>&1 || true
        grep -q "^\[  \(PASSED\|FAILED\)" "$log" || { echo "$1: the laws did not end: $(tail -1 "$log")" >&2; exit 1; }
        if grep -q '^seed [0-9]* breaks' "$log"; then
            sed -nE "s/^seed ([0-9]+) breaks (\w+):.*/$1: found by scene \1, law \2/p" "$log" | head -1
            return
        fi
    done
    echo "$1: not found"
    missed=1
}

# A lamp without decay decays. The test of a linked shadow looks at the first volume, whichever casts it. Walls send
# back the colour red alone. Cells take light through volumes that cast no shadow in it. A box of tiles lacks its last
# column.
plant lights engine/light/light_sweep.cpp 'out.decay = light.point().decay;' 'out.decay = true;'
plant linking engine/model/plan.cpp 'litBy(shadows[i], light)' 'litBy(shadows[0], light)'
plant walls engine/solve/first_light.cpp 'firstOfSide(side)[colour]' 'firstOfSide(side)[0]'
plant cells engine/passes/light_cells.cpp 'wsCorner, margin, false, casters)' 'wsCorner, margin, false, {})'
plant tiles engine/model/plan.cpp 'all.include(sheets[n]);' \
    'all.include(Box2<int>{sheets[n].x0, sheets[n].y0, sheets[n].x1 - 1, sheets[n].y1});'
exit $missed
