#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# install_packages.sh [PACKAGE...]: installs the Debian packages that Scrim needs (packages.txt), and those named, if
# any is missing. A second call takes no time.
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
[ "$(id -u)" -eq 0 ] || sudo="sudo"
echo "== installing: ${missing[*]}"
$sudo apt-get update -qq
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
