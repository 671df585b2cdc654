#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs a finished build into an empty folder, and uses it from there: compiles its headers, builds and runs
# examples/cpp, runs the installed program, and has it find its volume sources. Nothing but that folder may be needed.
#   tests/program/install/check.sh BUILD_DIR
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

# A path of anybody's but its own, or an empty one (the current folder), and it would load libraries from there.
echo "-- where it looks for libraries"
readelf -d "$prefix/bin/scrim" >/dev/null || fail "readelf cannot read the program"
while read -r binary; do
    path="$(readelf -d "$binary" | sed -nE 's/.*\((RUNPATH|RPATH)\).*\[(.*)\]/\2/p')"
    if [ "$binary" = "$prefix/bin/scrim" ]; then
        [[ "$path" == '$ORIGIN/'* && "$path" != *:* ]] || fail "$binary looks for libraries in '$path'"
    else
        [ -z "$path" ] || fail "$binary looks for libraries in '$path'"
    fi
done < <(find "$prefix/bin" "$prefix/libexec" "$(dirname "$(find "$prefix" -name 'libscrim.so')")" -type f \( -perm -u+x -o -name '*.so*' \))

echo "-- the installed headers, each alone"
cxx="${CXX:-c++}"
headers=0
while read -r header; do
    headers=$((headers + 1))
    quietly "$header does not compile alone" "$cxx" -std=c++20 -Wall -Wextra -Wpedantic -Werror -I "$prefix/include" \
        -x c++ -include "$header" -fsyntax-only /dev/null
    # Of other libraries it may need GLM only. Folders of the compiler and of the C library are no libraries.
    others="$("$cxx" -std=c++20 -I "$prefix/include" -x c++ -include "$header" -M /dev/null | tr -s ' \\' '\n' |
        grep -E '^/usr/(local/)?include/[^/]+/' |
        grep -Ev '^/usr/include/(c\+\+|glm|linux|asm|asm-generic|bits|sys|gnu|[a-z0-9_]+-linux-gnu)/' || true)"
    [ -z "$others" ] || fail "$header needs more than GLM: $others"
done < <(cd "$prefix/include" && find scrim -name '*.h' | sort)
echo "   $headers headers"
# A sixth of all at most: a folder that is forgotten, or one that is installed as a whole, shows here.
[ "$headers" -ge 20 ] && [ "$headers" -le 45 ] || fail "$headers headers are installed, expected 20 to 45"

echo "-- building the examples, which use it"
quietly "the examples do not configure" cmake -S "$here/../../../examples/cpp" -B "$work/examples" -G Ninja \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Wpedantic -Werror"
grep -q "^scrim_DIR:PATH=$prefix/" "$work/examples/CMakeCache.txt" || fail "the examples found another scrim"
quietly "the examples do not build" cmake --build "$work/examples"

echo "-- running them"
# not_black PICTURE: it has light in red, and covers something.
not_black() {
    local most
    most="$(oiiotool --stats "$1" | sed -nE 's/^ *Stats Max: +//p')"
    awk -v most="$most" 'BEGIN { split(most, v, " "); exit !(v[1] > 0.01 && v[4] > 0.01) }' || fail "$1 is black: $most"
}
libraries="$(ldd "$work/examples/own_field")"
grep -q "libscrim.* => $prefix/" <<<"$libraries" || fail "the examples run with another library: $libraries"
"$work/examples/scene_file" "$here/../../../examples/scenes/layers.toml" "$work/scene.exr" \
    'camera.resolution=[96, 54]' || fail "scene_file does not run"
not_black "$work/scene.exr"
"$prefix/bin/scrim" make noise resolution=32 -q -o "$work/smoke.vdb" || fail "the program makes no volume"
"$work/examples/lit_asset" "$work/smoke.vdb" "$work/asset.exr" || fail "lit_asset does not run"
not_black "$work/asset.exr"
key="$("$work/examples/own_field" "$work/ball.exr")" || fail "own_field does not run"
grep -Eq '^brightest of light.key: 0\.[0-9]*[1-9]' <<<"$key" || fail "own_field has no layer of its key light: $key"
not_black "$work/ball.exr"
header="$(iinfo -v "$work/ball.exr")"
grep -q 'light.rim.R' <<<"$header" || fail "own_field wrote no layer of its rim light: $header"

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
"$scrim" render noise.vdb -q --res 32x32 -o noise.exr --preview noise.png || fail "the program writes no preview"
[ -s noise.png ] || fail "the preview is empty"
loader="$(find "$prefix" -name scrim-load)"
[ -n "$loader" ] || fail "the program that reads volumes was not installed"
mv "$loader" "$work/loader"
if "$scrim" info noise.vdb >/dev/null 2>"$work/loader.log"; then fail "volumes are read by a program from elsewhere"; fi
grep -q "cannot start '.*scrim-load' to read volumes" "$work/loader.log" || fail "no reason: $(cat "$work/loader.log")"
mv "$work/loader" "$loader"
check="$("$loader" --check)" || fail "children of the installed program are not confined: $check"
grep -q '^with volume sources loaded (mesh, noise, primitives, scan)$' <<<"$check" || grep -q '^no filter' <<<"$check" ||
    fail "it does not find the installed volume sources: $check"

echo "-- the installed scripts for farms"
"$prefix/bin/scrim-submit" noise.vdb --frames 1-2 --on openjd --scrim "$scrim" --res 32x32 -o 'tile.####.exr' >farm.log 2>&1 ||
    { cat farm.log >&2; fail "scrim-submit does not run"; }
[ -s noise.farm/template.json ] || fail "scrim-submit made no job: $(cat farm.log)"

echo "-- a volume source of someone else's, made with the installed header alone"
mkdir "$work/own"
cp "$here/../../../examples/source/ball.c" "$work/own"
quietly "the example source does not compile" "${CC:-cc}" -std=c99 -pedantic -Wall -Wextra -Werror -shared -fPIC \
    -fvisibility=hidden -I "$prefix/include" -o "$work/own/scrim_source_ball.so" "$work/own/ball.c" -lm
export SCRIM_PLUGIN_PATH="$work/own"
list="$("$scrim" make --list)"
grep -q '^ball: a soft ball$' <<<"$list" || fail "the program does not list the example source: $list"
"$scrim" make ball radius=2 density=5 resolution=32 -o ball.vdb || fail "the program does not run the example source"
info="$("$scrim" info ball.vdb)" || fail "the program cannot read the example's volume"
grep -Eq "voxel size +\[0\.125, 0\.125, 0\.125\]" <<<"$info" || fail "the example's volume is wrong: $info"
grep -Eq "bounds +\[-16, -16, -16\] to \[15, 15, 15\]" <<<"$info" || fail "the example's volume is wrong: $info"
if "$scrim" make ball radius=-2 -o wrong.vdb >"$work/wrong.log" 2>&1; then fail "the example takes any radius"; fi
grep -q "source 'ball': parameter 'radius' is -2, expected 1e-06 to 1000000" "$work/wrong.log" ||
    fail "the example's parameters are refused without a reason: $(cat "$work/wrong.log")"
unset SCRIM_PLUGIN_PATH

echo "-- the installed volume sources"
"$scrim" make primitives shapes='box size=2,2,2; torus radius=2 tube=0.3' resolution=32 -o shapes.vdb ||
    fail "primitives does not run"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >tetrahedron.obj
"$scrim" make mesh file=tetrahedron.obj resolution=32 -o mesh.vdb || fail "mesh does not run"
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\nabcdefgh' >scan.nrrd
"$scrim" make scan file=scan.nrrd -o scan.vdb || fail "scan does not run"
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: scan.raw\n' >scan.nhdr
printf 'abcdefgh' >scan.raw
"$scrim" make scan file=scan.nhdr -o apart.vdb || fail "scan does not find the samples of a header"

# And it was the installed source that ran, not one of the build's.
source="$(find "$prefix" -name 'scrim_source_noise.so')"
[ -n "$source" ] || fail "no volume source was installed"
mv "$source" "$work/elsewhere"
if "$scrim" make noise resolution=16 -o other.vdb >"$work/absent.log" 2>&1; then
    fail "the program takes its volume sources from outside of the installation"
fi
[ ! -e other.vdb ] || fail "the program wrote a volume without a source"

echo "-- the installation works"
