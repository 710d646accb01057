#!/bin/sh
# Makes share/landmarks.model: procedural worlds of all seasons, suns and reliefs, and labelled chips of four places.
#   LANDFIX_DATA=... tools/landmarks/train_landmarks.sh build/release/tools/landfix/landfix [OUTPUT]
# LANDFIX_DATA: folder with labels/, hura_il/, portugal_odm/ and meilen_ch/; the labels over the latter are beside this
# script. The same program, data and machine give the same bytes. About a minute of one core.
set -eu
landfix=$1
output=${2:-share/landmarks.model}
: "${LANDFIX_DATA:?the folder with labels/, hura_il/, portugal_odm/ and meilen_ch/}"
labels=$(dirname "$0")/labels
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

worlds=
draw() {  # NAME OPTIONS...
  name=$1
  shift
  "$landfix" synth -o "$work/$name" --size-m 1000 "$@" > /dev/null
  worlds="$worlds --synthetic $work/$name"
}
draw w1 --seed 11 --season summer
draw w2 --seed 12 --season spring --sun 120,35
draw w3 --seed 13 --season autumn --year 2022 --sun 235,25
draw w4 --seed 14 --season summer --year 2019 --sun 210,55
draw w5 --seed 15 --season winter --year 2021 --sun 180,20
draw w6 --seed 16 --season summer --relief-m 80
draw w7 --seed 17 --season spring --year 2018 --sun 250,40
draw w8 --seed 18 --season autumn --year 2017 --sun 110,25
draw w9 --seed 19 --season summer --year 2023 --sun 150,60
draw w10 --seed 20 --season winter --snow --sun 170,18
draw w11 --seed 21 --season summer --year 2016 --sun 100,30
draw w12 --seed 22 --season spring --year 2020 --sun 180,45
# shellcheck disable=SC2086  # one option per world
"$landfix" train $worlds \
  --chips "$LANDFIX_DATA/labels/hura/chips.csv=$LANDFIX_DATA/hura_il/hura_0.5m_13km2.tif" \
  --chips "$LANDFIX_DATA/labels/portugal/chips.csv=$LANDFIX_DATA/portugal_odm/portugal_ortho_6cm.tif" \
  --chips "$labels/zurich.csv=$LANDFIX_DATA/meilen_ch/zurich_swissimage_0.5m.tif" \
  --chips "$labels/meilen.csv=$LANDFIX_DATA/meilen_ch/meilen_swissimage_0.5m.tif" \
  -o "$output"
