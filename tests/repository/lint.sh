#!/usr/bin/env bash
# cppcheck over the C++, shellcheck over the scripts.
set -euo pipefail
command -v cppcheck >/dev/null || { echo "skipped: cppcheck is not installed"; exit 77; }
command -v shellcheck >/dev/null || { echo "skipped: shellcheck is not installed"; exit 77; }
{ git ls-files '*.sh'; echo .ci/run; } | xargs shellcheck
git ls-files 'base/*.cc' 'config/*.cc' 'drivers/*.cc' 'kinematics/*.cc' 'calibration/*.cc' 'recording/*.cc' \
  'procedures/*.cc' 'stand/*.cc' 'daemon/*.cc' 'cli/*.cc' 'export/*.cc' 'presentation/*.cc' |
  xargs cppcheck --quiet --language=c++ --std=c++20 -I . -j 2 \
    --enable=warning,performance,portability --inline-suppr --error-exitcode=1 \
    --suppressions-list=tests/repository/cppcheck-suppressions.txt
echo "lint: nothing found"
