#!/usr/bin/env bash
# The main job from a bare Debian 12: sets up, builds, starts the daemon on the virtual stand, runs `bias` and
# `scale` by name with live results, shows what another process received over LCM and where the records are, and ends
# with `close_loop` on another part of the same kind with an undeclared effect: which it is, and the error before and
# after.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh build
echo "== building (build/demo)"
cmake -S . -B build/demo -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF \
  -DGYROBENCH_BENCHMARKS=OFF -DGYROBENCH_WARNINGS_AS_ERRORS=OFF -DGYROBENCH_UNITY=ON >/dev/null
cmake --build build/demo

bin=build/demo/bin
work=$(mktemp -d)
daemon=
watch=
finish() {
  status=$?
  ((status == 0)) || { echo "demo: failed; the end of the daemon's log:" && tail -n 20 "$work/daemon.log"; } >&2
  for process in $watch $daemon; do
    if kill "$process" 2>/dev/null; then wait "$process" 2>/dev/null || true; fi
  done
  rm -rf "$work"
}
trap finish EXIT

# start CONFIG: a daemon on a virtual stand, once it answers.
start() {
  export GYROBENCH_CONFIG=$1
  echo "== starting gyrobenchd --config $1"
  $bin/gyrobenchd --config "$1" 2>"$work/daemon.log" &
  daemon=$!
  for attempt in $(seq 300); do
    $bin/gyrobench status >"$work/status" 2>&1 && break
    kill -0 $daemon 2>/dev/null && ((attempt < 300)) || exit 1
    sleep 0.1
  done
  cat "$work/status"
}

start config/virtual.toml

$bin/gyrobench watch >"$work/live.txt" 2>&1 &
watch=$!
for _ in $(seq 30); do  # it is listening once it has shown a status; without multicast it never will
  grep -q STATUS "$work/live.txt" && break
  sleep 0.1
done

for procedure in bias scale; do
  echo
  echo "== gyrobench run $procedure"
  $bin/gyrobench run "$procedure"
done

echo
echo "== live, as another process received it over LCM: the last results of each kind"
if ! grep -q RESULT "$work/live.txt"; then
  echo "none: this machine has no multicast route (sudo ip route add 239.255.76.67/32 dev lo); the records are whole"
fi
for channel in BIAS_RESULT SCALE_RESULT; do
  echo "$(grep -c " $channel " "$work/live.txt" || true) of $channel"
  grep " $channel " "$work/live.txt" | tail -n 3 || true
done

echo
echo "== records, each to be looked at with: gyrobench show RUN, gyrobench analyze RUN"
$bin/gyrobench runs

echo
echo "== the loop closed: a part with something in it that no file of the analysis tells of"
kill $daemon
wait $daemon || true
start config/undeclared.toml
echo
echo "== gyrobench run close_loop"
$bin/gyrobench run close_loop -p fan=false | tee "$work/loop.txt"
run=$(grep -Eo '[0-9]{8}-[0-9]{6}-close_loop' "$work/loop.txt" | head -n 1)
echo
echo "== gyrobench trace $run: the error before and after"
$bin/gyrobench trace "$run"
