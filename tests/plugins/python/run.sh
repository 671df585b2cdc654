#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run.sh BUILD_DIR: the tests of the Python package of a build (SCRIM_BUILD_PYTHON), in the environment beside it.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$(cd "${1:?usage: run.sh BUILD_DIR}" && pwd)"
shift
# Files side by side on all cores. What hangs shows where, and ends.
PYTHONPATH="$build/python" PYTHONDONTWRITEBYTECODE=1 timeout 1800 "$build/python-venv/bin/python" -m pytest -q \
    -n "$(nproc)" --dist loadfile -p no:cacheprovider -o faulthandler_timeout=120 "$here" "$@"
