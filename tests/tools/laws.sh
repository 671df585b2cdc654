#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# laws.sh SEED COUNT [BUILD]: draws COUNT scenes from SEED on, and checks three laws of tests/truth/laws in each.
# Prints what was checked, which frequent pairs of keys and kinds no scene had, and what breaks a law, as plain as it
# can be.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
if [ $# -lt 2 ]; then
    echo "laws.sh: expected SEED COUNT [BUILD]" >&2
    exit 2
fi
SCRIM_LAWS_SEED="$1" SCRIM_LAWS_COUNT="$2" "${3:-$root/build}/bin/scrim_law_tests" --gtest_brief=1 \
    --gtest_filter='DrawnScenes.ObeyTheirLaws'
