#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs commands of this checkout in a fresh Debian 12 that has nothing but its smallest set of packages, so that a
# package that is missing from our lists fails here and not at a newcomer's. Needs root and mmdebstrap (which it
# installs), and a minute for the root itself.
#   tests/bare/run.sh                      the README's two commands, one after the other, then the first as a user
#   tests/bare/run.sh COMMAND...           these instead, each a line for bash in the clone; 'user: COMMAND' runs as an
#                                          ordinary user, who then owns the clone; 'fresh: COMMAND' runs in a new clone
# SCRIM_BARE_ROOT: a folder for the root, which is kept (default: a temporary one, removed at the end).
# What is tried is the last commit: a file that was never committed is missing here as it is everywhere else.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
suite=bookworm
commands=("$@")
[ ${#commands[@]} -gt 0 ] ||
    commands=("examples/quickstart.sh" "tests/run.sh" "examples/quickstart.sh" "user: examples/quickstart.sh")

fail() {
    echo "bare/run.sh: $*" >&2
    exit 1
}
[ "$(id -u)" -eq 0 ] || fail "only root can make a root file system and change into it"
if ! command -v mmdebstrap >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends mmdebstrap >/dev/null
fi

base="${SCRIM_BARE_ROOT:-$(mktemp -d "${TMPDIR:-/var/tmp}/scrim-bare-XXXXXX")}"
root="$base/debian"
mounted=()
clean() {
    local status=$? folder
    for folder in "${mounted[@]}"; do umount -l "$folder" 2>/dev/null || true; done
    # Never remove what is still mounted: /dev would be the machine's own.
    if [ -z "${SCRIM_BARE_ROOT:-}" ] && ! grep -q " $root/" /proc/mounts; then rm -rf --one-file-system "$base"; fi
    exit "$status"
}
trap clean EXIT
started=$SECONDS
minutes() { printf '%d min %02d s' $((($1) / 60)) $((($1) % 60)); }

echo "== bare: making Debian ($suite, minbase) in $root"
mkdir -p "$base"
# The machine's own way to Debian's packages, whatever it is: a mirror, a proxy.
sources=()
for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.sources /etc/apt/sources.list.d/*.list; do
    [ -s "$file" ] && grep -qi debian "$file" && sources+=("$file")
done
fetching=()
for file in $(grep -ls '^ *Acquire' /etc/apt/apt.conf /etc/apt/apt.conf.d/*); do fetching+=("--aptopt=$file"); done
log="$base/mmdebstrap.log"
if [ ! -d "$root" ]; then
    mmdebstrap --quiet --variant=minbase "${fetching[@]}" \
        "$suite" "$root" "${sources[@]}" >"$log" 2>&1 || { sed 's#//[^/@ ]*@#//***@#g' "$log" >&2; fail "mmdebstrap failed"; }
fi
echo "== bare: $(minutes $((SECONDS - started))), $(chroot "$root" dpkg-query -W | wc -l) packages, $(du -sm "$root" | cut -f1) MB"

# The host's resolver and certificates; nothing of them is printed or packaged.
for file in /etc/resolv.conf /etc/hosts; do [ -r "$file" ] && cp -L "$file" "$root$file"; done
for file in proc dev; do
    mountpoint -q "$root/$file" && continue
    if [ "$file" = proc ]; then mount -t proc proc "$root/proc"; else mount --rbind /dev "$root/dev" && mount --make-rslave "$root/dev"; fi
    mounted=("$root/$file" "${mounted[@]}")
done
# And the machine's own way to PyPI.
setting() { # KEY: of pip, from the environment or its files
    local variable="PIP_$(tr 'a-z-' 'A-Z_' <<<"$1")"
    printf '%s' "${!variable:-$(python3 -m pip config get "global.$1" 2>/dev/null || true)}"
}
{
    echo "[global]"
    certificates="$(setting cert)"
    if [ -r "$certificates" ]; then
        cp -L "$certificates" "$root/etc/certificates-of-pip.pem"
        echo "cert = /etc/certificates-of-pip.pem"
    fi
    for key in index-url extra-index-url trusted-host proxy timeout; do
        value="$(setting "$key")"
        [ -z "$value" ] || echo "$key = $value"
    done
} >"$root/etc/pip.conf"
chroot "$root" id artist >/dev/null 2>&1 || chroot "$root" useradd --create-home artist

work=/work
clone() {
    rm -rf "$root$work/scrim"
    mkdir -p "$root$work"
    git -c safe.directory='*' clone --quiet --no-hardlinks "$here" "$root$work/scrim"
}
clone
# Beside the clone, as beside this checkout. Copied: a bind mount would have to be undone.
data="${SCRIM_DATA:-$here/../shared/data}"
if [ -d "$data" ] && [ ! -d "$root$work/shared/data" ]; then
    mkdir -p "$root$work/shared"
    cp -rL "$data" "$root$work/shared/data"
fi

for command in "${commands[@]}"; do
    user=root
    case "$command" in
        "user: "*) user=artist command="${command#user: }"; chroot "$root" chown -R artist "$work/scrim" ;;
        "fresh: "*) command="${command#fresh: }"; clone ;;
    esac
    echo "== bare: $command (as $user)"
    began=$SECONDS
    # A clean environment: what the machine has set must not help.
    chroot "$root" setpriv --reuid "$user" --regid "$user" --init-groups env -i HOME="/home/$user" \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 ${CI:+CI="$CI"} \
        bash -c "cd $work/scrim && $command" </dev/null || fail "'$command' (as $user) failed after $(minutes $((SECONDS - began)))"
    echo "== bare: $command took $(minutes $((SECONDS - began)))"
done
echo "== bare: $(chroot "$root" dpkg-query -W | wc -l) packages, $(du -smx "$root" | cut -f1) MB; $(minutes $((SECONDS - started))) in all"
