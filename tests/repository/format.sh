#!/usr/bin/env bash
# Every C++ file is as clang-format leaves it.
set -euo pipefail
command -v clang-format >/dev/null || { echo "skipped: clang-format is not installed"; exit 77; }
git ls-files '*.h' '*.cc' | xargs clang-format --dry-run -Werror
echo "format: all files as .clang-format says"
