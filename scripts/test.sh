#!/usr/bin/env bash
# Sets up, builds and passes the tests. Arguments go to ctest (e.g. -R daemon).
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh build test
# Another clone or a second run compiles only what is new.
export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR="${CCACHE_BASEDIR:-$PWD}"
# Without debug information: passing tests do not need it, and it costs a twentieth of the time.
cmake --preset dev -DGYROBENCH_BENCHMARKS="${GYROBENCH_BENCHMARKS:-OFF}" -DGYROBENCH_UNITY="${GYROBENCH_UNITY:-ON}" \
  -DGYROBENCH_SANITIZERS_SLICE="${GYROBENCH_SANITIZERS_SLICE:-OFF}" -DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O2 >/dev/null
cmake --build --preset dev
# One more than there are processors: the tests of silent devices wait.
ctest --preset dev --parallel "$(($(nproc) + 1))" "$@"
