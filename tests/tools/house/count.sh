#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# How much one must know to work on the engine: what stands between voxel and pixel, and how long it is. Fails where a limit
# is passed.
#   tests/tools/house/count.sh [COMMIT]     of the working tree, or of a commit of the same rooms
# A unit is a header with its source file (and the part of it that is compiled once for each instruction set). A type is
# a struct, class, enum or alias that a header defines, those within another type too: whoever reads the header meets
# them there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
tree="."
if [ $# -gt 0 ]; then
    tree="$(mktemp -d)"
    trap 'rm -rf "$tree"' EXIT
    git archive "$1" src | tar x -C "$tree"
fi
# The engine's rooms; before there was a folder `engine`, those that held it.
rooms=()
for room in engine splat light shade render; do [ ! -d "$tree/src/scrim/$room" ] || rooms+=("$tree/src/scrim/$room"); done
files() { find "${rooms[@]}" -name '*.h' -o -name '*.cpp'; }

types="$(files | grep '\.h$' | grep -v -- '-inl\.h$' | xargs cat | grep -cE '^ *((enum )?(struct|class) [A-Za-z_0-9]+[^;]*\{|using [A-Za-z_0-9]+ =)')"
units="$(files | sed -E 's/(-inl)?\.(h|cpp)$//' | sort -u | wc -l)"
lines="$(files | xargs cat | wc -l)"
longest="$(files | xargs wc -l | grep -v total | sort -n | tail -1 | awk '{print $1, $2}')"
wide="$(find "$tree/src" -name '*.h' -o -name '*.cpp' | xargs awk 'length($0) > 120' | wc -l)"
# A function begins and ends in the first column.
long="$(find "$tree/src" -name '*.h' -o -name '*.cpp' | xargs awk '
    FNR == 1 { open = 0 }
    /^[A-Za-z_].*\(.*\{$/ && !/^(namespace|struct|class|enum|extern|constexpr)/ { start = FNR; open = 1 }
    /^[A-Za-z_].*[,(]$/ { start = FNR; open = 1 }
    /^}/ && open { if (FNR - start + 1 > 60) print FILENAME ":" start; open = 0 }')"
printf 'header types  %4d  (at most 90)\nunits         %4d  (at most 45)\nlines         %4d\nlongest file  %s  (at most 600 lines)\nlines over 120 columns in src  %d  (none)\nfunctions over 60 lines in src  %s  (none)\n' \
    "$types" "$units" "$lines" "$longest" "$wide" "${long:-0}"
[ "$types" -le 90 ] && [ "$units" -le 45 ] && [ "${longest%% *}" -le 600 ] && [ "$wide" -eq 0 ] && [ -z "$long" ]
