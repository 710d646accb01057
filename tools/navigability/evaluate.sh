#!/usr/bin/env bash
# How well a map foretells where images of a date that it was not made of will be found: the tables of docs/evaluation.md.
# Each date of naip_nd is the camera over maps of four, three and one of the others, view 160 m, ±160 m, true within 15 m.
# 20 minutes on two cores. Usage: evaluate.sh LANDFIX LANDFIX_DATA FOLDER [SAMPLES]
set -euo pipefail
landfix=$1 data=$2/naip_nd out=$3 samples=${4:-500}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
[ -d "$data" ] || { echo "skipped: $data is not there" >&2; exit 0; }
mkdir -p "$out"
files=("$data"/*.tif)

date_of() { local name; name=$(basename "$1" .tif); name=${name##*_}; echo "${name:0:4}-${name:4:2}-${name:6:2}"; }

# The pack of the images with these numbers, built if it is not there; prints its path.
map_of() {
  local pack="$out/map$(IFS=_; echo "$*").lfpack" images=() dates=() i
  for i in "$@"; do
    images+=("${files[i]}")
    dates+=(--date "$(basename "${files[i]}")=$(date_of "${files[i]}")")
  done
  [ -e "$pack" ] || "$landfix" build "${images[@]}" "${dates[@]}" --navigability 160/160 \
    --layers gray,edge,contour,orientation -o "$pack" >/dev/null 2>"$out/build.log" || { cat "$out/build.log" >&2; exit 1; }
  echo "$pack"
}

# NAME DATES OPTIONS...: every camera over every map of so many other dates.
compare() {
  local name=$1 dates=$2 camera bits pairs=() chosen i
  shift 2
  for camera in "${!files[@]}"; do
    for ((bits = 0; bits < 1 << ${#files[@]}; ++bits)); do
      chosen=()
      for i in "${!files[@]}"; do ((bits >> i & 1)) && chosen+=("$i"); done
      [ "${#chosen[@]}" = "$dates" ] && ((!(bits >> camera & 1))) || continue
      pairs+=(--map "$(map_of "${chosen[@]}")" --camera "${files[camera]}")
    done
  done
  "$landfix" eval navigability "${pairs[@]}" --samples "$samples" --matcher orientation --matcher auto "$@" \
    --json="$out/$name.json" >"$out/$name.txt" 2>/dev/null
}

compare dates4 4
compare dates1 1
compare dates1.unknown 1 --camera-date unknown
compare dates3 3
python3 "$here/evaluation.py" "$out"
