#!/bin/sh
# The tables of docs/landmarks.md: landmarks, roads and labelled places on worlds and images, by the models in the program.
#   LANDFIX_DATA=... tools/landmarks/evaluate.sh build/release/tools/landfix/landfix [FOLDER for the worlds]
# No model has seen the worlds, nor the windows of `hura` whose buildings are labelled in labels/; areas 1 to 3 and the chips
# of `hura` and `portugal` are among what the models learnt from (train_objects.sh can hold an area out).
set -eu
landfix=$1
work=${2:-build/landmarks}
mkdir -p "$work"

draw() {  # NAME OPTIONS...
  name=$1
  shift
  [ -e "$work/$name/water.geojson" ] || "$landfix" synth -o "$work/$name" --size-m 1500 "$@" >/dev/null
  printf '\n== %s: %s\n' "$name" "$*"
}
judge() {  # NAME
  "$landfix" eval landmarks --image "$work/$1/ortho.tif" --truth "$work/$1/buildings.geojson" --distance-m 3 |
    grep -E '^(within +3|confidence 0\.[357])'
  "$landfix" eval roads --image "$work/$1/ortho.tif" --truth "$work/$1/roads.geojson" --intersections "$work/$1/intersections.geojson"
}
draw summer501 --seed 501 --season summer && judge summer501
draw winter501 --seed 501 --season winter --year 2018 --sun 170,22 && judge winter501
draw autumn502 --seed 502 --season autumn --year 2021 --sun 220,30 && judge autumn502
draw spring503 --seed 503 --season spring --sun 130,40 && judge spring503
draw summer511 --seed 511 --season summer --varied-roads && judge summer511
draw winter511 --seed 511 --season winter --year 2018 --sun 170,22 --varied-roads && judge winter511
draw autumn512 --seed 512 --season autumn --year 2021 --sun 220,30 --varied-roads && judge autumn512

for pair in "summer501 winter501" "summer511 winter511"; do
  printf '\n== %s: found again\n' "$pair"
  "$landfix" eval landmarks --image "$work/${pair% *}/ortho.tif" --again "$work/${pair#* }/ortho.tif" --distance-m 5
done

[ -n "${LANDFIX_DATA:-}" ] && [ -d "$LANDFIX_DATA/labels" ] || { echo "LANDFIX_DATA names no folder with labels: the rest is left out"; exit 0; }
labels=$LANDFIX_DATA/labels
hura=$LANDFIX_DATA/hura_il/hura_0.5m_13km2.tif
for area in 1 2 3; do
  printf '\n== hura, area %s\n' "$area"
  "$landfix" eval landmarks --image "$hura" --points "$labels/hura/area_$area.geojson" --extent "$labels/hura/area_${area}_extent.geojson" |
    grep -E '^(within +6|confidence 0\.[357]|intersection)'
done
for window in 1 2 3 4; do
  known=$(dirname "$0")/labels/hura_buildings_$window.geojson
  printf '\n== hura, window %s\n' "$window"
  "$landfix" eval landmarks --image "$hura" --points "$known" --extent "$known" | grep -E '^(within +6|confidence 0\.[357])'
done
printf '\n== chips\n'
"$landfix" eval landmarks --image "$hura" --chips "$labels/hura/chips.csv"
"$landfix" eval landmarks --image "$LANDFIX_DATA/portugal_odm/portugal_ortho_6cm.tif" --chips "$labels/portugal/chips.csv"
