#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs Debian's packages (src/cmake/packages.sh) in a fresh Debian 12 with nothing else in it, uses what each of them is
# for, asks lintian, and removes them again. Needs root and mmdebstrap.
#   tests/program/packages/run.sh FOLDER            with the .deb files
# SCRIM_BARE_ROOT: a folder for the root, which is kept (default: a temporary one, removed at the end).
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
packages="$(cd "${1:?usage: run.sh FOLDER}" && pwd)"
if [ -z "${SCRIM_IN_ROOT:-}" ]; then
    # Outside: a clone in a fresh root, with the packages in it, where this script goes on.
    base="${SCRIM_BARE_ROOT:-$(mktemp -d "${TMPDIR:-/var/tmp}/scrim-packages-XXXXXX")}"
    clean() {
        local status=$?
        [ -n "${SCRIM_BARE_ROOT:-}" ] || grep -q " $base/" /proc/mounts || rm -rf --one-file-system "$base"
        exit "$status"
    }
    trap clean EXIT
    mkdir -p "$base"
    SCRIM_BARE_ROOT="$base" "$here/../../bare/run.sh" true
    rm -rf "$base/debian/packages"
    cp -r "$packages" "$base/debian/packages"
    SCRIM_BARE_ROOT="$base" "$here/../../bare/run.sh" "SCRIM_IN_ROOT=yes tests/program/packages/run.sh /packages"
    exit
fi

fail() { echo "packages/run.sh: $*" >&2; exit 1; }
install() { DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/tmp/log 2>&1 || { cat /tmp/log >&2; fail "cannot install $*"; }; }
size() { echo "   $(dpkg-query -W | wc -l) packages, $(du -smx / 2>/dev/null | cut -f1) MB"; }
deb() { echo "$packages"/"$1"_*.deb; }
apt-get update -qq
cd /tmp

echo "-- program and library"
install "$(deb libscrim0)" "$(deb scrim)"
size
! dpkg-query -W 2>/dev/null | grep -E '^[a-z0-9.+-]*-dev[: \t]' || fail "packages to build with were installed"
! dpkg-query -W 2>/dev/null | grep -q '^libopenimageio' || fail "the program brings OpenImageIO along"
scrim --version | grep -q '^scrim [0-9]' || fail "scrim --version"
scrim make noise resolution=32 -q -o smoke.vdb || fail "no volume source"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >tetrahedron.obj
scrim make mesh file=tetrahedron.obj resolution=16 -q -o mesh.vdb || fail "no meshes"
scrim render smoke.vdb -q --res 96x54 --verify 200 -o smoke.exr >verify.log 2>&1 || { cat verify.log; fail "no picture"; }
[ -s smoke.exr ] || fail "the picture is empty"
/usr/libexec/scrim/scrim-load --check >check.log || { cat check.log; fail "what reads files is not confined"; }
if scrim render smoke.vdb -q --res 96x54 -o again.exr --preview again.png 2>preview.log; then fail "a preview without its package"; fi
grep -q scrim-pictures preview.log || fail "the message names no package: $(cat preview.log)"
for page in man1/scrim.1 man1/scrim-render.1 man1/scrim-merge.1 man1/scrim-submit.1 man5/scrim-scene.5; do
    zcat "/usr/share/man/$page.gz" | grep -q '^\.SH SEE ALSO' || fail "$page"
done
completed="$(bash -c '. /usr/share/bash-completion/completions/scrim; COMP_WORDS=(scrim re) COMP_CWORD=1; _scrim; echo "${COMPREPLY[*]}"')"
[ "$completed" = render ] || fail "completion: $completed"
[ -s /usr/share/doc/scrim/examples/scenes/layers.toml ] || fail "no examples"
if command -v readelf cmake c++ >/dev/null; then fail "this root is not bare"; fi

echo "-- pictures"
install "$(deb scrim-pictures)"
size
scrim render smoke.vdb -q --res 96x54 -o again.exr --preview again.png || fail "no preview"
[ -s again.png ] || fail "the preview is empty"

echo "-- expressions"
if scrim info smoke.vdb --ax 'f@density *= 2;' >/dev/null 2>ax.log; then fail "an expression without its package"; fi
grep -q 'install the package scrim-ax' ax.log || fail "the message names no package: $(cat ax.log)"
install "$(deb scrim-ax)"
size
scrim make ax file=smoke.vdb code='f@density *= 2; f@heat = f@density;' -q -o twice.vdb || fail "no expression"
scrim info twice.vdb | grep -q "grid 'heat'" || fail "the expression made no grid"

echo "-- farm"
scrim-submit smoke.vdb --frames 1-2 --on openjd -o 'tile.####.exr' --res 32x32 >farm.log 2>&1 || { cat farm.log; fail "scrim-submit"; }
[ -n "$(find smoke.farm -name 'template*')" ] || fail "no job: $(ls -R smoke.farm)"

echo "-- Python"
install "$(deb python3-scrim)"
size
python3 - <<'PYTHON' || fail "the module does not render"
import numpy, scrim

frame = scrim.open("smoke.vdb", resolution=(96, 54)).render(verify=100)
assert frame.image[:, :, 3].max() > 0.1 and frame.error < 0.02, frame.error
assert scrim.Field(numpy.ones((8, 8, 8))) is not None and scrim.__version__
PYTHON
python3 -m scrim --version | grep -q '^scrim' || fail "python3 -m scrim"

echo "-- programs of one's own"
install "$(deb libscrim-dev)" g++ cmake ninja-build
cp -r /usr/share/doc/scrim/examples/cpp /usr/share/doc/scrim/examples/source .
cmake -S cpp -B own -G Ninja -DCMAKE_BUILD_TYPE=Release >own.log && cmake --build own >>own.log || { cat own.log; fail "the examples do not build"; }
./own/own_field ball.exr | grep -q 'light.key' || fail "own_field"
mkdir -p sources
cc -std=c99 -shared -fPIC -o sources/scrim_source_ball.so source/ball.c -lm || fail "the example source does not compile"
SCRIM_PLUGIN_PATH=sources scrim make ball radius=2 density=5 resolution=32 -q -o ball.vdb || fail "the example source does not run"

echo "-- lintian"
while read -r binary; do
    ! readelf -d "$binary" 2>/dev/null | grep -E 'RUNPATH|RPATH' || fail "$binary has a path of its own"
done < <(dpkg -L libscrim0 scrim scrim-pictures python3-scrim | grep -E '\.so|/bin/scrim$|scrim-load$')
install lintian
lintian --allow-root --fail-on error --tag-display-limit 0 "$packages"/*.deb || fail "lintian has errors"

echo "-- and away"
apt-get purge -y -qq libscrim0 >/tmp/log 2>&1 || { cat /tmp/log >&2; fail "they cannot be removed"; }
left="$(find /usr /etc /var/lib -name '*scrim*' -not -path '/var/lib/apt/*' 2>/dev/null || true)"
[ -z "$left" ] || fail "left behind: $left"
echo "-- the packages work"
