#!/bin/sh
# Makes share/objects.model: what buildings, fields, trees, water and paved areas look like, learnt from procedural worlds
# of all seasons and suns, from three squares in which every building is known, and from labelled chips of two places.
#   LANDFIX_DATA=... tools/landmarks/train_objects.sh build/release/tools/landfix/landfix [OUTPUT [HELD_OUT]]
# HELD_OUT: the number of a square (1 to 3) to leave out with all chips within 80 m of it; that is how docs/landmarks.md
# judges the method on it. The same program, data and machine give the same bytes. A quarter of an hour of one core.
set -eu
landfix=$1
output=${2:-share/objects.model}
held_out=${3:-0}
: "${LANDFIX_DATA:?the folder with labels/, hura_il/ and portugal_odm/}"
hura=$LANDFIX_DATA/hura_il/hura_0.5m_13km2.tif
labels=$LANDFIX_DATA/labels
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

set --
draw() {  # SEED SIZE OPTIONS...
  seed=$1
  size=$2
  shift 2
  "$landfix" synth -o "$work/$seed" --seed "$seed" --size-m "$size" "$@" >/dev/null
}
draw 101 1500 --season summer
draw 102 1500 --season autumn --year 2022 --sun 235,25
draw 103 1500 --season winter --year 2021 --sun 180,20
draw 104 1500 --season winter --snow --sun 170,18
draw 105 1500 --season spring --year 2018 --sun 120,35 --relief-m 80
draw 106 1500 --season summer --year 2019 --sun 210,55
draw 107 1500 --season autumn --year 2017 --sun 110,25
draw 108 1500 --season spring --year 2023 --sun 250,40
draw 13 1200 --season autumn  # the smaller ones have villages
draw 14 1200 --season summer
draw 15 1200 --season winter
draw 18 1200 --season autumn
draw 19 1200 --season summer
draw 22 1200 --season spring
for seed in 101 102 103 104 105 106 107 108 13 14 15 18 19 22; do
  set -- "$@" "$work/$seed"
done
for area in 1 2 3; do
  if [ "$area" = "$held_out" ]; then
    set -- "$@" --away-from "$hura" "$labels/hura/area_${area}_extent.geojson"
  else
    set -- "$@" --area "$hura" "$labels/hura/area_$area.geojson" "$labels/hura/area_${area}_extent.geojson"
  fi
done
"$landfix" train-objects "$@" --chips "$hura" "$labels/hura/chips.csv" \
  --chips "$LANDFIX_DATA/portugal_odm/portugal_ortho_6cm.tif" "$labels/portugal/chips.csv" --variations 1 -o "$output"
