#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The add-on for Blender: its mapping without Blender, itself in bpy, and its pictures beside Cycles'. Makes a folder of
# Python packages below the build, which takes a download of 400 MB the first time.
#   tests/blender/run.sh BUILD_DIR [--no-cycles]
# SCRIM_BPY: the version of bpy (default: 4.5.*), which Python 3.11 can have.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$(cd "${1:?usage: run.sh BUILD_DIR [--no-cycles]}" && pwd)"
bpy="${SCRIM_BPY:-4.5.*}"
export SCRIM="$build/bin/scrim"
fail() {
    echo "blender/run.sh: $*" >&2
    exit 1
}
[ -x "$SCRIM" ] || fail "there is no $SCRIM; build first"
packages="$build/bpy-${bpy%.\*}"
if [ ! -f "$packages/complete" ]; then
    rm -rf "$packages"
    # Blender's libraries want those of a window even where there is none.
    bash "$here/../../src/cmake/install_packages.sh" python3 python3-venv libx11-6 libxrender1 libxfixes3 libxi6 \
        libxkbcommon0 libsm6 libgl1
    # Those of the system know more than pip's own.
    [ ! -r /etc/ssl/certs/ca-certificates.crt ] || export PIP_CERT="${PIP_CERT:-/etc/ssl/certs/ca-certificates.crt}"
    /usr/bin/python3 -m venv "$packages" || fail "cannot make a virtual environment with /usr/bin/python3"
    "$packages/bin/pip" install -q "bpy==$bpy" pytest || fail "cannot install bpy $bpy: it wants Python 3.11"
    touch "$packages/complete"
fi
# Nothing of the user's settings may count.
BLENDER_USER_RESOURCES="$(mktemp -d)"
export BLENDER_USER_RESOURCES
trap 'rm -rf "$BLENDER_USER_RESOURCES"' EXIT
log="$BLENDER_USER_RESOURCES/log"
python="$packages/bin/python"
cd "$here"
# Blender tells of every step on standard output: shown only where a test fails.
timeout 600 "$python" -B run_pytest.py -q -p no:cacheprovider mapping_test.py addon_test.py >"$log" 2>&1 || {
    cat "$log" >&2
    fail "the add-on's tests failed"
}
tail -n 1 "$log"
grep -q skipped "$log" && fail "no test may be skipped"
[ "${2:-}" != "--no-cycles" ] || exit 0
timeout 2400 "$python" -B compare_test.py >"$log" 2>&1 || {
    grep -vE '^(Fra:|Saved|Time:)' "$log" >&2
    fail "a picture differs from Cycles'"
}
grep -E '^\||^compare_test' "$log"
