#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Prints every benchmark table: stages, costs, and Scrim beside its peers. Needs a build (tests/run.sh); takes some
# minutes. Further assets may be named: tests/tools/bench/run.sh smoke1.vdb
set -euo pipefail
bin="${SCRIM_BUILD:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)/build}/bin"
"$bin/scrim_stages" --benchmark_counters_tabular=true
"$bin/scrim_costs" noise:350 "$@"
"$bin/scrim_effects" --pixels 200 noise:350 "$@"
"$bin/scrim_compare" noise:350 "$@"
