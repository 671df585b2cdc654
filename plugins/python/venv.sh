#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# venv.sh FOLDER: makes an environment of Debian's Python with everything that building and testing the module needs, from
# PyPI, in versions that are known to work. It does nothing if the environment exists.
set -euo pipefail
folder="$1"
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
cmp -s "$here/requirements.txt" "$folder/requirements.txt" && "$folder/bin/python" -c "import nanobind" 2>/dev/null && exit 0
rm -rf "$folder"
/usr/bin/python3 -m venv "$folder"
"$folder/bin/pip" install --quiet --disable-pip-version-check -r "$here/requirements.txt"
cp "$here/requirements.txt" "$folder/"
