#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a bare Debian 12 to all tests passed: installs packages, builds, runs every test.
#   tests/run.sh              release build: all tests, benchmarks built, the house rules counted, the installed package used
#   tests/run.sh --sanitize   the tests that read, parse and render, with address and undefined-behaviour sanitizers
#   tests/run.sh --threads    renders side by side under the thread sanitizer (builds oneTBB with it, too)
# Tests that need the volumes of $SCRIM_DATA (or ../shared/data) are skipped and counted where it is absent; where it is
# there, a test that skips fails the run.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
case "${1:-}" in
    "") preset=release build="$root/build" ;;
    --sanitize) preset=asan build="$root/build-asan" ;;
    --threads) exec bash "$root/tests/program/threads/run.sh" ;;
    *) echo "run.sh: unknown argument '$1'; expected --sanitize or --threads" >&2; exit 2 ;;
esac
started=$SECONDS
stage() {
    printf '== %s (%s, after %d min %02d s)\n' "$1" "$preset" $(((SECONDS - started) / 60)) $(((SECONDS - started) % 60))
}

stage packages
bash "$root/src/cmake/install_packages.sh" libgtest-dev libbenchmark-dev python3-dev python3-venv
cd "$root"
# Whole programs at a time: a process for every test (as ctest has it) takes longer to start than to run. Sanitizers slow
# brute force down most and learn least from it, since the same code runs in quicker tests (and the
# engine's in those of stability and effects). Limits of memory cannot be set where they take all that
# there is, and nothing is confined there.
if [ "$preset" = "asan" ]; then
    export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
    export SCRIM_FUZZ_RUNS=20 SCRIM_LAWS_COUNT=4
    # The others take longer than all of these: .ci/full runs them, by SCRIM_PROGRAMS.
    programs="${SCRIM_PROGRAMS:-stability unit shot fuzz plugin thread}"
    targets="--target $(printf 'scrim_%s_tests ' $programs)"
    filter='-Interrupt.*:Sizes.*:*EveryAngle*:*TenThousandSheets*:*ManySheets*:Study.*:Ways/Place*:*Mutations*random_scene*:*AgreeWithBruteForce*:*classifiedPerView*:Limits.*:Ax.Hostile*:Ax.ExpressionsThatNeverEnd*:Documents.*:SourceLoader.KeepsFilesThatTakeOver*:MultipleScattering.*PathTracer:MultipleScattering.OfA*Chandrasekhars:MultipleScattering.OfADome*:MultipleScattering.OfAnEvenGlow*:MultipleScattering.ConvergesWithTheCells:MultipleScattering.TakesFewSweeps*:MultipleScattering.OfASlabIsMilnes:*ConvergesToTheReference:*ConvergeToTheReference:*AgreesWithBruteForce*:*ShowsWhatTheReferenceShows*'
    options=""
else
    programs="error effect law analytic paper fuzz engine stability unit shot plugin invariance thread"
    targets="" # all of them
    filter='*'
    options="-DSCRIM_BUILD_TESTS=ON -DSCRIM_BUILD_BENCHMARKS=ON"
    mkdir -p "$build"
    python=no
    # The one thing that comes from PyPI. Whoever has no way there has everything else tested; SCRIM_PYPI=required fails.
    if bash plugins/python/venv.sh "$build/python-venv"; then
        python=yes options+=" -DSCRIM_BUILD_PYTHON=ON -DPython_EXECUTABLE=$build/python-venv/bin/python"
    elif [ "${SCRIM_PYPI:-}" = required ]; then
        echo "run.sh: PyPI could not be reached" >&2
        exit 1
    fi
fi
stage configuring
# shellcheck disable=SC2086 # several words are meant
bash src/cmake/configure.sh "$preset" "$build" $options
stage building
# shellcheck disable=SC2086
cmake --build "$build" $targets -- --quiet
stage testing
[ "$preset" != "release" ] || tests/tools/house/count.py
logs="$(mktemp -d)"
trap 'rm -rf "$logs"' EXIT
failed=0
# shellcheck disable=SC2016
printf '%s\n' $programs | xargs -P "$(nproc)" -I{} bash -c \
    '"$1/bin/scrim_$3_tests" --gtest_brief=1 --gtest_filter="$2" >"$4/$3" 2>&1 || touch "$4/$3.failed"; cat "$4/$3"' \
    run_one "$build" "$filter" {} "$logs" || failed=1
compgen -G "$logs/*.failed" >/dev/null && failed=1
count() { # PATTERN: sums the numbers that stand behind it, over all programs
    cat "$logs"/* | sed -nE "s/^\[  $1 *\] ([0-9]+) tests?[.,].*/\1/p" | awk '{n += $1} END {print n + 0}'
}
passed="$(count PASSED)" skipped="$(count SKIPPED)" broken="$(count FAILED)"
if [ "$skipped" -gt 0 ]; then
    echo "== $skipped tests were skipped:"
    grep -hE '^Skipped|^no .*; SCRIM_DATA' "$logs"/* | sort | uniq -c || true
    if [ -d "${SCRIM_DATA:-$root/../shared/data}" ]; then
        echo "run.sh: the test volumes are there, so no test may be skipped" >&2
        failed=1
    fi
fi
if [ "$preset" = "release" ] && [ "$failed" -eq 0 ]; then
    stage "the installed package"
    tests/program/install/check.sh "$build" || failed=1
    if [ "$python" = yes ]; then
        stage python
        tests/plugins/python/run.sh "$build" | tee "$logs/python" || failed=1
        counted() { # WORD: how many pytest's last line says
            tail -n 1 "$logs/python" | grep -oE "[0-9]+ $1" | cut -d' ' -f1 || echo 0
        }
        passed=$((passed + $(counted passed))) skipped=$((skipped + $(counted skipped)))
        broken=$((broken + $(counted failed) + $(counted error)))
    else
        echo "== the Python module was neither built nor tested: PyPI could not be reached"
    fi
fi
stage done
[ "$failed" -eq 0 ] || [ "$broken" -gt 0 ] || broken=1
echo "$passed passed, $broken failed, $skipped skipped"
exit "$failed"
