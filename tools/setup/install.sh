#!/usr/bin/env bash
# Installs what landfix is built with (packages.txt, and further packages named as arguments), asking for sudo only where needed.
# Does nothing where everything is there. For Debian 12 and later and Ubuntu 22.04 and later.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

installed() { [ "$(dpkg-query -W -f='${db:Status-Abbrev}' "$1" 2>/dev/null | cut -c1-2)" = ii ]; }

if ! command -v dpkg-query >/dev/null; then
  echo "landfix: this is no Debian or Ubuntu; install the packages of $here/packages.txt by your system's means" >&2
  exit 0
fi

missing=()
for entry in $(grep -v '^#' "$here/packages.txt") "$@"; do
  found=
  for name in ${entry//|/ }; do installed "$name" && found=1 && break; done
  [ -n "$found" ] || missing+=("$entry")
done
[ ${#missing[@]} -gt 0 ] || exit 0

sudo=
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "landfix: needs root to install: ${missing[*]}" >&2; exit 1; }
  sudo=sudo
fi
echo "landfix: installing ${missing[*]}"
$sudo apt-get update -q
names=()
for entry in "${missing[@]}"; do
  chosen=${entry%%|*}
  for name in ${entry//|/ }; do
    if apt-cache show "$name" >/dev/null 2>&1; then chosen=$name; break; fi
  done
  names+=("$chosen")
done
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${names[@]}"
