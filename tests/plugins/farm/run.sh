#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Farms, with faults: a real Slurm on this machine, and openjd-cli. A sequence whose tasks are killed, requeued, starved
# of memory and cancelled, and whose output cannot be written for a while, ends complete and bit-identical to a plain
# render of it. Needs root (Slurm's daemons), Debian's slurm-wlm and PyPI's openjd-cli, which it installs.
#   tests/plugins/farm/run.sh BUILD_DIR
# SCRIM_FARM_LOGS: a folder for all logs, which is kept.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
build="$(cd "${1:?usage: run.sh BUILD_DIR}" && pwd)"
submit="$here/../../../plugins/farm/scrim-submit"
scrim="$build/bin/scrim"
python=/usr/bin/python3
fail() {
    echo "farm/run.sh: $*" >&2
    [ ! -f "${job:-}/log/farm.log" ] || cat "$job/log/farm.log" >&2
    exit 1
}
[ -x "$scrim" ] || fail "there is no $scrim; build first"
[ "$(id -u)" -eq 0 ] || fail "Slurm's daemons want root"

echo "-- the farm's own tests"
SCRIM="$scrim" timeout 300 "$python" -B -m unittest discover -q -s "$here" -p '*_test.py' || fail "they failed"

if ! command -v slurmctld >/dev/null || ! command -v munged >/dev/null || ! command -v pgrep >/dev/null; then
    bash "$here/../../../src/cmake/install_packages.sh" slurm-wlm munge procps
fi
venv="$build/openjd-venv"
if [ ! -f "$venv/complete" ]; then
    bash "$here/../../../src/cmake/install_packages.sh" python3-venv
    [ ! -r /etc/ssl/certs/ca-certificates.crt ] || export PIP_CERT="${PIP_CERT:-/etc/ssl/certs/ca-certificates.crt}"
    rm -rf "$venv"
    "$python" -m venv "$venv"
    "$venv/bin/pip" install -q "openjd-cli==0.8.0" || fail "cannot install openjd-cli"
    touch "$venv/complete"
fi

# shellcheck source=tests/plugins/farm/slurm.sh
source "$here/slurm.sh"
work="$(mktemp -d "${TMPDIR:-/tmp}/scrim-farm-XXXXXX")"
chmod 755 "$work" # munged's socket is below
slurm_folder="$work/slurm"
finish() {
    local status=$?
    timeout 20 scancel --user=root 2>/dev/null || true
    stop_slurm
    [ -z "${SCRIM_FARM_LOGS:-}" ] || { mkdir -p "$SCRIM_FARM_LOGS"; cp -r "$work"/*.farm/log "$SCRIM_FARM_LOGS/"; }
    sleep 1
    rm -rf "$work"
    exit "$status"
}
trap finish EXIT
cd "$work"

echo "-- the shot: 12 frames, the fifth of which wants more memory than the others"
for frame in 1 2 3; do "$scrim" make noise resolution=96 seed=$frame -q -o source$frame.vdb; done
"$scrim" make noise resolution=320 seed=5 -q -o source5.vdb
for frame in $(seq 12); do ln -s source$((frame == 5 ? 5 : frame % 3 + 1)).vdb "$(printf 'smoke.%04d.vdb' "$frame")"; done
cat >shot.toml <<'END'
[camera]
position = { keys = [[1, [0.3, 0.4, 3.3]], [12, [-0.3, 0.4, 3.3]]] }
target = [0, 0, 0]
fov = 35
resolution = [320, 240]

[[volume]]
name = "plume"
file = "smoke.####.vdb"
density = { scale = 30 }

[[light]]
name = "key"
type = "distant"
direction = [1, -1.4, -0.9]
intensity = 9

[render]
antialias = 3

[output]
file = "out/plume.####.exr"
deep = "out/plume.deep.####.exr"
layers = ["light", "depth"]
preview = "out/plume.####.png"
END

# until SECONDS WHAT COMMAND...: waits for a command to succeed.
until_it() {
    local end=$((SECONDS + $1)) what="$2"
    shift 2
    until "$@" >/dev/null 2>&1; do
        [ $SECONDS -lt $end ] || fail "waited in vain for $what"
        sleep 0.2
    done
}
# field STATE_FILE NAME: of the last attempt.
field() {
    "$python" -c 'import json, sys; print(json.load(open(sys.argv[1]))["attempts"][-1].get(sys.argv[2]))' "$1" "$2"
}
state() { echo "$job/state/$1.json"; }
is_running() { [ "$(field "$(state "$1")" result)" = running ]; }
# The program itself, once it is there: the only child of the task.
program_of() { is_running "$1" && pgrep -P "$(field "$(state "$1")" pid)" scrim; }
# strike FAULT TASK...: does it to the first of these tasks whose program runs; `struck` names it.
strike() {
    local fault="$1" task pid
    shift
    for task in "$@"; do
        pid="$(program_of "$task")" || continue
        # Held, so that it cannot be done by then; whoever has its last picture is left alone.
        kill -STOP "$pid" 2>/dev/null || continue
        if [ -e "$job/tiles/${task: -1}/flat.$(printf %06d "$(cut -d- -f3 <<<"$task")").exr" ]; then
            kill -CONT "$pid"
            continue
        fi
        case "$fault" in
            program) kill -KILL "$pid" ;;
            task) kill -KILL "$(field "$(state "$task")" pid)" "$pid" ;;
            requeue) scontrol requeue "$(field "$(state "$task")" job)" ;;
            cancel) scancel "$(field "$(state "$task")" job)" ;;
            stop) kill "$(field "$(state "$task")" pid)" ;;
        esac && struck="$task"
        kill -CONT "$pid" 2>/dev/null || true
        [ "${struck:-}" != "$task" ] || return 0
    done
    return 1
}
fault() { # WHAT: happened to the task that was struck
    echo "   $(date +%T) $1: $struck, Slurm's $(field "$(state "$struck")" job)"
    scontrol --oneliner show job "$(field "$(state "$struck")" job)" |
        grep -oE '(JobId|ArrayJobId|ArrayTaskId|JobState|Reason|Restarts|ExitCode|RunTime|TRES)=[^ ]*' | tr '\n' ' ' | sed 's/^/   /'
    echo
}
idle() { [ -z "$(squeue --noheader --format=%i)" ]; }
complete() { # JOB: all is there, whole, and nothing else is
    timeout 60 "$submit" --status "$1" >status.txt || { cat status.txt >&2; fail "$1 is not complete"; }
    [ "$(find out -type f | wc -l)" -eq 36 ] || fail "there are $(find out -type f | wc -l) files: $(ls -A out)"
    [ -z "$(find "$1/tiles" -type f)" ] || fail "tiles are left: $(find "$1/tiles" -type f | head -3)"
    for frame in $(seq -f %04g 12); do
        for picture in plume.$frame plume.deep.$frame; do
            "$python" -B "$here/same_chunks.py" "plain/$picture.exr" "out/$picture.exr" || fail "a picture differs"
        done
        [ -s "out/plume.$frame.png" ] || fail "frame $frame has no preview"
    done
}

echo "-- Slurm"
start_slurm "$work/slurm" || fail "Slurm does not start"
job="$work/shot.farm"
timeout 120 "$submit" shot.toml --frames 1-12 --tiles 2x1 --on slurm --scrim "$scrim" --cpus 1 --memory 360M \
    --most-memory 2G --pause 2 | tee submitted.txt
mkdir -p out/plume.0007.exr # in the way of the picture
# What tasks were given, for a render without a farm.
mapfile -t given < <(sed -n 's/^for every task: //p' submitted.txt | tr ' ' '\n' | sed 's/^/--set\n/')
[ ${#given[@]} -ge 8 ] || fail "too little was resolved: ${given[*]}"

until_it 120 "a task to kill" strike program render-{1,2,3}-{1,2,3}-tile{0,1}
killed="$struck"
fault "SIGKILL for the program"
until_it 120 "a task to requeue" strike requeue render-{4,6}-{4,6}-tile{0,1}
requeued="$struck"
fault "scontrol requeue"
until_it 120 "a task to end" strike task render-{9,10}-{9,10}-tile{0,1}
lost="$struck"
fault "SIGKILL for the whole task"
until_it 120 "a task to cancel" strike cancel render-{11,12}-{11,12}-tile{0,1}
cancelled="$struck"
fault "scancel"
# Slurm waits two minutes before it starts a requeued job.
until_it 60 "the requeued task to be pending" scontrol update "JobId=$(field "$(state "$requeued")" job)" StartTime=now
until_it 300 "the merge of frame 7 to fail" grep -q '"retry"' "$(state merge-7-7)"
rmdir out/plume.0007.exr
until_it 600 "the end" idle

echo "-- what came of it"
grep -E 'status (33|137|143|4),|again:|given up|not complete' "$job/log/farm.log" | sed 's/^/   /' | cut -c1-200
status=0
timeout 60 "$submit" --status "$job" >status.txt || status=$?
cat status.txt
[ "$status" -eq 1 ] || fail "a task was cancelled, and --status says $status"
grep -q '11 of 12 frames are complete' status.txt || fail "not all other frames are complete"
grep -Eq "missing: frames $(cut -d- -f2 <<<"$cancelled"), tile ${cancelled: -1}: cancelled, attempt 1: " status.txt || fail "it does not say why"
grep -q 'status 33, memory' "$job/log/farm.log" || fail "no task lacked memory"
grep -q 'status 137, lost: killed by SIGKILL' "$job/log/farm.log" || fail "no task was killed"
grep -Eq '"restarts": 1' "$(state "$requeued")" || fail "no task was requeued"
grep -q '"running"' "$(state "$lost")" || fail "no task was lost"
grep -q "again: $killed with 720 MB" "$job/log/farm.log" || fail "what was killed was not tried again"
grep -q "again: $lost with 360 MB" "$job/log/farm.log" || fail "what was lost was not tried again"
grep -q 'again: render-5-5-tile0 with 720 MB' "$job/log/farm.log" || fail "no task got more memory"
grep -q 'JobState=' "$job/log/faults.log" || fail "Slurm's own words were not kept"
timeout 60 "$submit" --resume "$job"
until_it 300 "the end" idle

echo "-- the same without a farm"
timeout 600 "$scrim" render shot.toml --frames 1-12 "${given[@]}" -q -o plain/plume.####.exr \
    --deep plain/plume.deep.####.exr --preview plain/plume.####.png
complete "$job"
cat status.txt
stop_slurm

echo "-- Open Job Description"
rm -rf out
job="$work/openjd.farm"
timeout 120 "$submit" shot.toml --frames 1-12 --tiles 2x1 --chunk 3 --on openjd --scrim "$scrim" --cpus 1 --folder "$job"
openjd="$venv/bin/openjd"
timeout 60 "$openjd" check "$job/template.json" || fail "the template is wrong"
run_openjd() { timeout 600 "$openjd" run "$job/template.json" --step Check --run-dependencies; }
run_openjd >openjd.log 2>&1 &
runner=$!
until_it 120 "a task to stop" strike stop render-4-6-tile{0,1}
status=0
wait "$runner" || status=$?
[ "$status" -ne 0 ] || { cat openjd.log >&2; fail "a task was killed, and the run succeeded"; }
grep -q 'openjd_fail: cancelled (status 143)' openjd.log || { cat openjd.log >&2; fail "it does not say why"; }
timeout 60 "$submit" --status "$job" && fail "a task was killed, and all is there"
run_openjd >openjd.log 2>&1 || { cat openjd.log >&2; fail "it cannot be gone on with"; }
grep -q 'openjd_progress: ' openjd.log || fail "no progress is reported"
complete "$job"
cat status.txt
echo "farm/run.sh: all passed"
