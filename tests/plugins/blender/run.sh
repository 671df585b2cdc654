#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The add-on for Blender: its mapping without Blender, itself in bpy and in Debian's Blender 3.4, there also from a zip
# and in a window, and its pictures beside Cycles'. Makes a folder of Python packages below the build, which takes a
# download of 400 MB the first time; Debian's Blender is as much.
#   tests/plugins/blender/run.sh BUILD_DIR [--no-cycles]
# SCRIM_BPY: the version of bpy (default: 4.5.*), which Python 3.11 can have; "none" for Debian's Blender alone.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$(cd "${1:?usage: run.sh BUILD_DIR [--no-cycles]}" && pwd)"
bpy="${SCRIM_BPY:-4.5.*}"
export SCRIM="$build/bin/scrim"
fail() {
    echo "blender/run.sh: $*" >&2
    exit 1
}
cycles=yes
[ "${2:-}" != "--no-cycles" ] || cycles=no
[ -x "$SCRIM" ] || fail "there is no $SCRIM; build first"
# Nothing of the user's settings may count.
BLENDER_USER_RESOURCES="$(mktemp -d)"
export BLENDER_USER_RESOURCES
trap 'rm -rf "$BLENDER_USER_RESOURCES"' EXIT
log="$BLENDER_USER_RESOURCES/log"
cd "$here"

plain=(mapping_test.py nodes_test.py expressions_test.py exporter_test.py engine_test.py)
# Blender tells of every step on standard output: shown only where a test fails.
tests() { # COMMAND...: runs pytest, and shows what it makes of it
    "$@" >"$log" 2>&1 || {
        cat "$log" >&2
        fail "the add-on's tests failed"
    }
    grep -E '^[1-9][0-9]* passed' "$log" || fail "no test was run"
    ! grep -q skipped "$log" || fail "no test may be skipped"
}
compare() { # COMMAND...: runs compare_test.py
    "$@" >"$log" 2>&1 || {
        grep -vE '^(Fra:|Saved|Time:)' "$log" >&2
        fail "a picture differs from Cycles'"
    }
    grep -E '^\||^compare_test' "$log"
}

in_bpy() {
    local packages="$build/bpy-${bpy%.\*}"
    if [ ! -f "$packages/complete" ]; then
        rm -rf "$packages"
        # Blender's libraries want those of a window even where there is none.
        bash "$here/../../../src/cmake/install_packages.sh" python3 python3-venv libx11-6 libxrender1 libxfixes3 \
            libxi6 libxkbcommon0 libsm6 libgl1
        # Those of the system know more than pip's own.
        [ ! -r /etc/ssl/certs/ca-certificates.crt ] || export PIP_CERT="${PIP_CERT:-/etc/ssl/certs/ca-certificates.crt}"
        /usr/bin/python3 -m venv "$packages" || fail "cannot make a virtual environment with /usr/bin/python3"
        "$packages/bin/pip" install -q "bpy==$bpy" pytest || fail "cannot install bpy $bpy: it wants Python 3.11"
        touch "$packages/complete"
    fi
    local python="$packages/bin/python"
    echo "== bpy $bpy"
    tests timeout 600 "$python" -B run_pytest.py -q -p no:cacheprovider "${plain[@]}" addon_test.py \
        noise_test.py
    # Scrim's Python module brings libraries that Blender has of its own: whoever comes first, both work.
    [ -d "$build/python" ] || fail "there is no $build/python; build with -DSCRIM_BUILD_PYTHON=ON"
    "$python" -m pip install -q "$(grep '^nanobind-backend' "$here/../../../plugins/python/requirements.txt")"
    for order in "bpy scrim" "scrim bpy"; do
        # shellcheck disable=SC2086 # two words are meant
        PYTHONPATH="$build/python" timeout 300 "$python" -B together.py $order >"$log" 2>&1 || {
            cat "$log" >&2
            fail "they do not work together: $order"
        }
        echo "together: $order"
    done
    [ "$cycles" = no ] || compare timeout 2400 "$python" -B compare_test.py
}

# By the way of add-ons before Blender 4.2, and in a window, which bpy does not have.
in_debians_blender() {
    bash "$here/../../../src/cmake/install_packages.sh" blender xvfb xauth libgl1-mesa-dri python3-numpy \
        python3-pytest python3-pil
    # Not those of the environment: scripts import them by Debian's Python.
    export BLENDER=/usr/bin/blender PYTHONPATH="$here" PYTHONDONTWRITEBYTECODE=1 LIBGL_ALWAYS_SOFTWARE=1
    local command=("$BLENDER" --factory-startup --python-use-system-env --python-exit-code 1)
    local seen="$build/blender-viewport"
    echo "== $("$BLENDER" --version | head -n 1)"
    tests timeout 900 "${command[@]}" --background --python run_pytest.py -- -q -p no:cacheprovider "${plain[@]}" \
        addon_test.py
    tests timeout 900 /usr/bin/python3 -m pytest -q -p no:cacheprovider legacy_test.py
    rm -rf "$seen" && mkdir "$seen"
    xvfb-run -a -s "-screen 0 960x640x24" timeout 900 "${command[@]}" --window-geometry 0 0 960 640 \
        --python viewport_test.py -- "$seen" >"$log" 2>&1 || {
        cat "$log" >&2
        fail "the viewport's tests failed; what was on the screen is in $seen"
    }
    grep -E '^viewport_test: [1-9][0-9]* passed, 0 failed' "$log" || fail "no test of the viewport was run"
    # The laws of light that were others before 4.0, and one that was not
    [ "$cycles" = no ] || compare timeout 1200 "${command[@]}" --background --python compare_test.py -- \
        -k 'sun|spot|area, |sphere'
}

[ "$bpy" = none ] || in_bpy
in_debians_blender
