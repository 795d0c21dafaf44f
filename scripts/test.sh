#!/usr/bin/env bash
# Sets up, builds and passes the tests. Arguments go to ctest (e.g. -R daemon).
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh build test
cmake --preset dev -DGYROBENCH_BENCHMARKS="${GYROBENCH_BENCHMARKS:-OFF}" >/dev/null
cmake --build --preset dev
ctest --preset dev --parallel "$(nproc)" "$@"
