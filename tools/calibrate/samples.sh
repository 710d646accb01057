#!/usr/bin/env bash
# Draws the samples that probabilities are calibrated with. synthetic.csv.gz: drawn worlds, each in several seasons,
# years and suns; maps of one date and of two, the other dates as cameras. elsewhere.csv.gz: cameras over another world
# than the map's, so that no answer is true. pairs.csv.gz: the dated pairs of LANDFIX_DATA, where it is given. Then: fit.py FOLDER/*.csv.gz > runtime/nav/calibration_table.h
# Usage: samples.sh LANDFIX FOLDER FIRST_SEED WORLDS [LANDFIX_DATA]
set -euo pipefail
landfix=$1 folder=$2 first=$3 worlds=$4 data=${5:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

draw() { "$landfix" synth -o "$work/$1" --seed "$2" --size-m 4000 --gsd 2 --dem-gsd 4 --season "$3" --year "$4" --sun "$5" "${@:6}" >/dev/null; }

# evaluate OUT MAP CAMERA...: small templates, so that not everything succeeds.
evaluate() {
  local out=$work/$1 map=$2; shift 2
  local cameras=(); for name in "$@"; do cameras+=(--camera "$work/$name/ortho.tif"); done
  for size in "64 100" "96 160" "160 240"; do
    read -r template search <<<"$size"
    for pose in "0 0 60" "3 0.03 30"; do  # known and searched
      read -r rotate scale samples <<<"$pose"
      "$landfix" eval register --map "$work/$map.lfpack" "${cameras[@]}" --template-m "$template" --search-m "$search" \
        --rotate-deg "$rotate" --scale "$scale" --hit-m 7.5 --samples "$samples" --seeds 1 --matcher all \
        --samples-csv "$work/part.csv" >/dev/null
      if [ -s "$out" ]; then tail -n +2 "$work/part.csv" >>"$out"; else cp "$work/part.csv" "$out"; fi
    done
  done
}

# pack IN OUT: what the fit needs, and no more; the same bytes for the same samples.
pack() {
  python3 - "$1" "$2" <<'PYTHON'
import csv, gzip, io, sys
keep = ["matcher", "hit", "value", "gap", "spread", "sigma_px", "similarities"]
with open(sys.argv[1]) as source, open(sys.argv[2], "wb") as target:
    text = io.StringIO()
    writer = csv.DictWriter(text, keep, lineterminator="\n")
    writer.writeheader()
    for row in csv.DictReader(source):
        if row["matcher"] != "auto" and row["gap"]:
            writer.writerow({name: row[name] for name in keep})
    target.write(gzip.compress(text.getvalue().encode(), 9, mtime=0))
PYTHON
}

for ((seed = first; seed < first + worlds; ++seed)); do
  draw summer "$seed" summer 2016 150,45 --nir
  draw spring "$seed" spring 2018 200,30 --nir
  draw autumn "$seed" autumn 2020 235,25
  draw winter "$seed" winter 2021 170,18 --snow
  draw another $((seed + 1000)) autumn 2020 235,25
  "$landfix" build "$work/summer/ortho.tif" -o "$work/one.lfpack" --force >/dev/null 2>&1
  "$landfix" build "$work/summer/ortho.tif" "$work/spring/ortho.tif" -o "$work/two.lfpack" --force >/dev/null 2>&1
  evaluate synthetic.csv one spring autumn winter
  evaluate synthetic.csv two autumn winter
  evaluate elsewhere.csv one another
  evaluate elsewhere.csv two another
done
pack "$work/synthetic.csv" "$folder/synthetic.csv.gz"
pack "$work/elsewhere.csv" "$folder/elsewhere.csv.gz"
if [ -n "$data" ]; then
  "$landfix" eval pairs --a "$data/dated_pairs/A" --b "$data/dated_pairs/B" --gsd-m 2 --matcher all \
    --samples-csv "$work/pairs.csv" >/dev/null
  pack "$work/pairs.csv" "$folder/pairs.csv.gz"
fi
