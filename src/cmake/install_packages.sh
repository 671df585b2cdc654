#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# install_packages.sh [PACKAGE...]: installs the Debian packages that Scrim needs (packages.txt) and the named ones,
# unless all are present. It needs root or sudo only if some are missing.
set -euo pipefail
list="$(dirname "${BASH_SOURCE[0]}")/packages.txt"
mapfile -t packages < <(grep -v '^#' "$list"; printf '%s\n' "$@")

missing=()
for package in "${packages[@]}"; do
    [ -z "$package" ] && continue
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

sudo=""
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        echo "These packages are missing, and only root can install them (there is no sudo here):" >&2
        echo "    apt-get install --no-install-recommends ${missing[*]}" >&2
        exit 1
    fi
    sudo="sudo"
fi
echo "== installing: ${missing[*]}"
$sudo apt-get update -qq
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
