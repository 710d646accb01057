#!/usr/bin/env bash
# Makes a folder with another architecture's libraries to build against: sysroot.sh arm64 FOLDER PACKAGE...
# The packages and what they depend on come from the distribution's archive (for Debian: it has all architectures in one
# place) and are unpacked there. Nothing is installed and apt's own lists stay as they are: some of these packages could
# not be installed beside those of the machine. Does nothing where the folder holds the same packages already.
set -euo pipefail
architecture=$1
mkdir -p "$2"
folder=$(cd "$2" && pwd)
shift 2
wanted="$architecture $*"
[ "$(cat "$folder/.packages" 2>/dev/null)" != "$wanted" ] || exit 0

state=$(mktemp -d)
trap 'rm -rf "$state"' EXIT
mkdir -p "$state/lists/partial" "$state/cache/archives/partial"
touch "$state/status"
apt() {
  apt-get -q -y -o APT::Architecture="$architecture" -o APT::Architectures::="$architecture" -o APT::Sandbox::User= \
    -o Dir::State="$state" -o Dir::State::status="$state/status" -o Dir::Cache="$state/cache" -o Debug::NoLocking=1 "$@"
}
echo "landfix: unpacking $* for $architecture into $folder"
apt update
apt install --download-only --no-install-recommends "$@"
rm -rf "$folder"
mkdir -p "$folder"
for package in "$state"/cache/archives/*.deb; do dpkg-deb -x "$package" "$folder"; done
# Absolute links mean the root of the other machine.
find "$folder" -type l -lname '/*' | while read -r link; do
  ln -sfn "$(realpath -m --relative-to="$(dirname "$link")" "$folder$(readlink "$link")")" "$link"
done
echo "$wanted" > "$folder/.packages"
