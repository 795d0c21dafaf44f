#!/usr/bin/env bash
# Every C++ file is as clang-format leaves it. It leaves comments alone, so that displayed equations and
# tables keep their lines; that these end at column 100 is checked here.
set -euo pipefail
command -v clang-format >/dev/null || { echo "skipped: clang-format is not installed"; exit 77; }
# Git lists a file that was deleted until that is staged.
{ git ls-files '*.h' '*.cc'; git ls-files --deleted '*.h' '*.cc'; } | sort | uniq -u |
  xargs clang-format --dry-run -Werror
if git grep -nE '^ *//.{99,}' -- '*.h' '*.cc' | grep -E ':[0-9]+:.{101,}'; then
  echo "format: these lines of comments end beyond column 100: break them by hand"
  exit 1
fi
echo "format: all files as .clang-format says"
