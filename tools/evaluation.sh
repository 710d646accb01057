#!/usr/bin/env bash
# Measures registration on real imagery: the tables of docs/evaluation.md. LANDFIX_DATA is laid out as its README says;
# what is absent is skipped, in plain sight. Usage: evaluation.sh LANDFIX LANDFIX_DATA FOLDER [SAMPLES] [SEEDS]
set -euo pipefail
landfix=$1 data=$2 out=$3 samples=${4:-1000} seeds=${5:-5}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "$out"

naip() {
  local files=("$data"/naip_nd/*.tif) camera other
  date_of() { local name; name=$(basename "$1" .tif); name=${name##*_}; echo "${name:0:4}-${name:4:2}-${name:6:2}"; }
  build() {  # pack, then images
    local pack=$1 dates=() image; shift
    for image in "$@"; do dates+=(--date "$(basename "$image")=$(date_of "$image")"); done
    "$landfix" build "$@" "${dates[@]}" -o "$pack" --force >/dev/null 2>&1
  }
  register() {  # name, pack, camera, template, search, further options
    local name=$1 pack=$2 camera=$3 template=$4 search=$5; shift 5
    "$landfix" eval register --map "$pack" --camera "$camera" --template-m "$template" --search-m "$search" --hit-m 15 \
      --samples "$samples" --seeds "$seeds" "$@" --json="$out/$name.$(date_of "$camera").json" >/dev/null 2>&1
  }
  for camera in "${files[@]}"; do
    local others=()
    for other in "${files[@]}"; do [ "$other" = "$camera" ] || others+=("$other"); done
    build "$out/others.lfpack" "${others[@]}"
    for size in "320 320" "240 160" "160 160"; do
      read -r template search <<<"$size"
      register "naip.$template" "$out/others.lfpack" "$camera" "$template" "$search" --matcher orientation \
        --picture "$out/naip.$template.$(date_of "$camera").png"
      seeds=1 register "naip.$template.others" "$out/others.lfpack" "$camera" "$template" "$search" \
        --matcher auto --matcher gray --matcher edge --matcher contour
    done
    for size in "320 320" "160 160"; do
      read -r template search <<<"$size"
      seeds=1 register "naip.$template.turned" "$out/others.lfpack" "$camera" "$template" "$search" --rotate-deg 3 --scale 0.03 \
        --matcher orientation
    done
    if [ "$camera" != "${files[0]}" ]; then
      [ -e "$out/first.lfpack" ] || build "$out/first.lfpack" "${files[0]}"
      register naip.320.alone "$out/first.lfpack" "$camera" 320 320 --matcher orientation
    fi
  done
}

pairs() {
  "$landfix" eval pairs --a "$data/dated_pairs/A" --b "$data/dated_pairs/B" --gsd-m 2 --matcher all --json="$out/pairs.json" >/dev/null 2>&1
}

photos() {
  local ortho dsm
  ortho=$(ls "$data"/brighton_beach_us/*ortho*.tif | head -1) dsm=$(ls "$data"/brighton_beach_us/*dsm*.tif | head -1)
  "$landfix" build "$ortho" -o "$out/brighton.lfpack" --force >/dev/null 2>&1
  "$landfix" eval photos --map "$out/brighton.lfpack" "$data"/brighton_beach_us/photos*/* --picture "$out/photos.png" \
    --json="$out/photos.json" >/dev/null 2>&1
}

rm -f "$out"/*.json
for part in naip_nd:naip dated_pairs:pairs brighton_beach_us:photos; do
  if [ -d "$data/${part%%:*}" ]; then "${part##*:}"; else echo "skipped: $data/${part%%:*} is not there" >&2; fi
done
python3 "$here/evaluation.py" "$out"
