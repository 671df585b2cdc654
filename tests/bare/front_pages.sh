#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs every command of README.md and examples/README.md with what examples/quickstart.sh has built and nothing else.
# Pictures are small and shots have two frames: it is about what is there, and tests/run.sh looks at the pictures.
#   tests/bare/front_pages.sh [BUILD]
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
build="$(realpath "${1:-$root/build}")"
export SCRIM_DATA="${SCRIM_DATA:-$root/../shared/data}"
export PATH="$build/bin:$PATH"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cd "$work"
cp "$build/quickstart/smoke.vdb" .
cp -r "$root/examples" .
# "head.nrrd", whatever the reader's is called: a bright cube in a dark one.
{
    printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 16 16 16\nencoding: ascii\nspacings: 1 1 1\n\n'
    for ((i = 0; i < 4096; ++i)); do printf '%d ' $((i / 256 % 16 / 4 % 3 > 0 ? 200 : 0)); done
} >head.nrrd

# Lines of the front page's shell, and what stands between ` and ` on the examples' page.
commands() {
    grep -hE '^(build/bin/)?scrim ' "$root/README.md"
    grep -ohE '`scrim [^`]*`' "$root/examples/README.md" | tr -d '`'
}
run=0 left=0
while IFS= read -r line; do
    command="$(sed -E 's#^build/bin/##; s/ # .*//; s/--frames 1-48(x8)?/--frames 1-2/; s/--turntable 24/--turntable 2/' <<<"$line")"
    case "$command" in
        "scrim render "*.toml* | "scrim render "*.usda*) command="$command --res 64x48 --quality draft" ;;
    esac
    lacks=""
    case "$command" in
        *scan.toml*) [ -d "$SCRIM_DATA" ] || lacks="the volumes of SCRIM_DATA" ;;
        *.usda*) [ -n "${SCRIM_PYTHON:-}" ] || lacks="OpenUSD (SCRIM_PYTHON), which comes from PyPI" ;;
    esac
    if [ -n "$lacks" ]; then
        echo "front_pages.sh: left out for want of $lacks: $line"
        left=$((left + 1))
        continue
    fi
    eval "$command" >log 2>&1 || {
        cat log >&2
        echo "front_pages.sh: failed: $line" >&2
        exit 1
    }
    run=$((run + 1))
done < <(commands)
[ "$run" -ge 18 ] || { echo "front_pages.sh: $run commands were found, expected 18 at least" >&2; exit 1; }
echo "front_pages.sh: $run commands did what they say, $left left out"
