#!/usr/bin/env bash
# What runs in threads under the thread sanitizer, and what reads files that others wrote under the address and
# undefined-behaviour sanitizers. Builds only what these tests need, and the daemon but once. The target `sanitizers`
# builds and runs everything.
set -euo pipefail
cd "$(dirname "$0")/../.."

log=$(mktemp)
trap 'rm -f "$log"' EXIT

# Rooms that calculate take most of the time of compiling. The sanitizers look at what surrounds them, and of themselves
# at those that work in threads, hold what all threads read, or read files: trace, gls, effects and artefact. The others
# have the flags of the development build (scripts/test.sh), so that its objects come from ccache; reports have no lines
# for want of -g. Of an inline function that both kinds have the linker keeps one, so that something may be missed here:
# the target `sanitizers` leaves nothing out.
calculations="kinematics;commission;presentation;export"
for room in signal state estimators sensor plan hold; do
  calculations+=";calibration/$room"
done

slice() {
  local preset=$1
  shift
  cmake --preset "$preset" -DGYROBENCH_SANITIZE_NOT="$calculations" -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O2 >/dev/null
  if ! cmake --build --preset "$preset" --target "$@" >"$log" 2>&1; then
    tail -n 40 "$log"
    exit 1
  fi
  ctest --preset "$preset" --parallel "$(nproc)" --no-tests=error -R "^($(IFS='|'; echo "$*"))\$"
}
slice tsan daemon_test drivers_gyro_unit_test talk_mutation_test
slice asan recording_test config_test
