#!/bin/sh
# Makes share/roads.model: what roads look like, learnt from 13 procedural worlds in all seasons, with varied roads, and
# from eight windows of real imagery in LANDFIX_DATA in which the roads were drawn by eye (hura_roads.geojson, all farther
# than 150 m from the areas that the evaluation looks at). Takes a quarter of an hour of one core.
#   LANDFIX_DATA=... tools/landmarks/train_roads.sh build/release/tools/landfix/landfix [OUTPUT]
# The same program, data and machine give the same bytes.
set -eu
landfix=$1
output=${2:-share/roads.model}
: "${LANDFIX_DATA:?the folder with hura_il/}"
here=$(dirname "$0")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

worlds=
draw() {  # SEED OPTIONS...
  seed=$1
  shift
  "$landfix" synth -o "$work/$seed" --seed "$seed" --size-m 1500 --varied-roads "$@" >/dev/null
  worlds="$worlds $work/$seed"
}
draw 101 --season summer
draw 102 --season autumn --year 2022 --sun 235,25
draw 103 --season winter --year 2021 --sun 180,20
draw 104 --season winter --snow --sun 170,18
draw 105 --season spring --year 2018 --sun 120,35 --relief-m 80
draw 106 --season summer --year 2019 --sun 210,55
draw 107 --season autumn --year 2017 --sun 110,25
draw 108 --season spring --year 2023 --sun 250,40
draw 109 --season summer --year 2016 --sun 140,60
draw 110 --season winter --year 2015 --sun 200,25
# Two roads of two carriageways each.
draw 306 --season autumn --year 2019 --sun 230,28
draw 320 --season spring --year 2020 --sun 150,45
draw 338 --season winter --year 2014 --sun 165,24
# shellcheck disable=SC2086  # one argument per world
"$landfix" train-roads $worlds --variations 6 \
  --drawn "$LANDFIX_DATA/hura_il/hura_0.5m_13km2.tif=$here/hura_roads.geojson" -o "$output"
