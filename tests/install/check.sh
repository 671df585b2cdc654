#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs a finished build into an empty folder, and uses it from there: builds and runs the project beside this
# script, runs the installed program, and has it find its volume sources. Nothing but that folder may be needed.
#   tests/install/check.sh BUILD_DIR
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$(cd "${1:?usage: check.sh BUILD_DIR}" && pwd)"
work="$(mktemp -d "${TMPDIR:-/tmp}/scrim-install-XXXXXX")"
trap 'rm -rf "$work"' EXIT
unset LD_LIBRARY_PATH CMAKE_PREFIX_PATH
for variable in $(compgen -e SCRIM_ || true); do unset "$variable"; done

fail() {
    echo "check.sh: $*" >&2
    exit 1
}
# quietly WHAT COMMAND...: runs it, and shows its output only where it fails.
quietly() {
    local what="$1"
    shift
    "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "$what"; }
}

echo "-- installing $build"
quietly "cmake --install failed" cmake --install "$build" --prefix "$work/first"
# An installation may be moved: whatever holds the path it was made for would break here.
prefix="$work/moved"
mv "$work/first" "$prefix"
config="$(find "$prefix" -name scrimConfig.cmake)"
[ -n "$config" ] || fail "no scrimConfig.cmake was installed"

echo "-- building a project that uses it"
quietly "the project does not configure" cmake -S "$here" -B "$work/consumer" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror"
grep -q "^scrim_DIR:PATH=$prefix/" "$work/consumer/CMakeCache.txt" || fail "the project found another scrim"
quietly "the project does not build" cmake --build "$work/consumer"

echo "-- running it"
libraries="$(ldd "$work/consumer/consumer")"
grep -q "libscrim.* => $prefix/" <<<"$libraries" || fail "the project runs with another library: $libraries"
"$work/consumer/consumer" "$work/fog.exr" || fail "the project's picture is wrong"
[ -s "$work/fog.exr" ] || fail "the project wrote no picture"

echo "-- running the installed program"
scrim="$prefix/bin/scrim"
libraries="$(ldd "$scrim")"
grep -q "libscrim.* => $prefix/" <<<"$libraries" || fail "the program runs with another library: $libraries"
version="$("$scrim" --version)"
grep -Eq '^scrim [0-9]+\.[0-9]+\.[0-9]+$' <<<"$version" || fail "unexpected --version: $version"
cd "$work"
"$scrim" make noise resolution=16 -o noise.vdb || fail "the program does not run an installed volume source"
[ -s noise.vdb ] || fail "the program wrote no volume"
"$scrim" info noise.vdb >/dev/null || fail "the program cannot read its own volume"

# And it was the installed source that ran, not one of the build's.
source="$(find "$prefix" -name 'scrim_source_noise.so')"
[ -n "$source" ] || fail "no volume source was installed"
mv "$source" "$work/elsewhere"
if "$scrim" make noise resolution=16 -o other.vdb >"$work/absent.log" 2>&1; then
    fail "the program takes its volume sources from outside of the installation"
fi
[ ! -e other.vdb ] || fail "the program wrote a volume without a source"

echo "-- the installation works"
