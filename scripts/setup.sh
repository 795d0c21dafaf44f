#!/usr/bin/env bash
# Installs the Debian packages of packages.txt that are missing. Silent and quick when none is.
# Usage: scripts/setup.sh [build|test|bench]...   (default: build)
set -euo pipefail
cd "$(dirname "$0")/.."

groups=${*:-build}
wanted=()
while read -r package package_groups; do
  for group in $groups; do
    if [[ " $package_groups " == *" $group "* ]]; then
      wanted+=("$package")
      break
    fi
  done
done < <(grep -vE '^(#|$)' packages.txt)

# A virtual package counts when something that is installed provides it.
have=" $(dpkg-query -W -f '${db:Status-Status} ${Package} ${Provides}\n' 2>/dev/null |
  sed -n 's/^installed //p' | tr -d ',' | tr '\n' ' ') "
missing=()
for package in "${wanted[@]}"; do
  [[ $have == *" $package "* ]] || missing+=("$package")
done
((${#missing[@]} == 0)) && exit 0

as_root=(env DEBIAN_FRONTEND=noninteractive)
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "setup: these packages are missing: ${missing[*]}" >&2
    echo "setup: neither root nor sudo here; as root: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo DEBIAN_FRONTEND=noninteractive)
fi
echo "setup: installing ${#missing[@]} Debian packages: ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
