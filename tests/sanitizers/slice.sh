#!/usr/bin/env bash
# What runs in threads under the thread sanitizer, and what reads files that others wrote under the address and
# undefined-behaviour sanitizers. Builds only what these tests need, and the daemon but once, as that takes half an hour
# of processor time. The target `sanitizers` builds and runs everything.
set -euo pipefail
cd "$(dirname "$0")/../.."

log=$(mktemp)
trap 'rm -f "$log"' EXIT

slice() {
  local preset=$1
  shift
  cmake --preset "$preset" >/dev/null
  if ! cmake --build --preset "$preset" --target "$@" >"$log" 2>&1; then
    tail -n 40 "$log"
    exit 1
  fi
  ctest --preset "$preset" --parallel "$(nproc)" --no-tests=error -R "^($(IFS='|'; echo "$*"))\$"
}
slice tsan daemon_test drivers_gyro_unit_test interval_gls_test talk_mutation_test
slice asan recording_test config_test
