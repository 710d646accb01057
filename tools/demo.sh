#!/usr/bin/env bash
# The main job end to end: a world is drawn, mapped, signed and flown over without GNSS. Usage: demo.sh LANDFIX OUTPUT_FOLDER
set -euo pipefail
landfix=$(realpath "$1")
out=$2
rm -rf "$out"
mkdir -p "$out"
cd "$out"
step() { printf '\n== %s\n' "$*"; }

step "Three views of one place: the map of the morning, and flights under the sun of noon and of the evening"
"$landfix" synth --seed 7 --size-m 1600 --gsd 0.25 --season summer --year 2020 --sun 150,50 -o summer
"$landfix" synth --seed 7 --size-m 1600 --gsd 0.25 --season summer --year 2020 --sun 190,45 -o noon
"$landfix" synth --seed 7 --size-m 1600 --gsd 0.25 --season summer --year 2020 --sun 235,45 -o evening

step "The map pack"
"$landfix" build summer/ortho.tif --dem summer/dtm.tif -o area.lfpack
"$landfix" info area.lfpack

step "Signed, so that the aircraft takes no other map"
"$landfix" keygen mission
"$landfix" sign area.lfpack --key mission.key
"$landfix" verify --deep area.lfpack --key mission.pub

step "What the aircraft would ask"
middle=$("$landfix" info area.lfpack --json | python3 -c '
import json, sys
b = json.load(sys.stdin)["bounds"]
print("%.1f,%.1f" % ((b["west_m"] + b["east_m"]) / 2, (b["south_m"] + b["north_m"]) / 2))')
"$landfix" query area.lfpack --grid "$middle" --sigma 40 -o region.png
"$landfix" query area.lfpack --grid "$middle" --sigma 265 --layer overview -o overview.png
"$landfix" query area.lfpack --grid "$middle" --sigma 265 --layer height --gsd 2 -o heights.png

step "What is down there, found in the image: landmarks and roads, for the aircraft, for QGIS and for the eye"
"$landfix" query area.lfpack --grid "$middle" --sigma 265 --layer overview --draw landmarks,roads -o landmarks.png
"$landfix" export area.lfpack --layer landmarks -o landmarks.gpkg
"$landfix" export area.lfpack --layer roads -o roads.gpkg

step "Where it can be navigated by: three dates of the place, each registered with the others, in views of 40 m at 1 m per pixel"
"$landfix" synth --seed 7 --size-m 1600 --gsd 1 --season autumn --year 2018 --sun 220,30 -o autumn
"$landfix" synth --seed 7 --size-m 1600 --gsd 1 --season spring --year 2019 --sun 130,40 -o spring
"$landfix" build summer/ortho.tif autumn/ortho.tif spring/ortho.tif --gsd 1 --layers gray,orientation,overview --navigability 40/80 \
  -o dates.lfpack
"$landfix" export navigability dates.lfpack -o navigability.png
"$landfix" export navigability dates.lfpack -o navigability.gpkg

step "60 m above ground: a loop of 1 km without GNSS, 2.5 % drift, camera attitude 0.5 degrees off and 0.3 degrees tilted"
"$landfix" fly --map area.lfpack --scene noon/ortho.tif --scene-dem noon/dsm.tif --loop 1000 --agl 60 --frames 6 -o flight_60m

step "The same in the evening, the sun moved by 85 degrees: by gray values alone, and by what auto chooses"
for matcher in gray auto; do
  "$landfix" fly --map area.lfpack --scene evening/ortho.tif --scene-dem evening/dsm.tif --loop 1000 --agl 60 --runs 3 --matcher $matcher \
    -o flight_evening_$matcher
done

step "The compass 3 degrees off: the heading is measured too"
"$landfix" fly --map area.lfpack --scene noon/ortho.tif --scene-dem noon/dsm.tif --loop 1000 --agl 60 --heading-bias-deg 3 -o flight_heading

step "305 m above ground, camera attitude 1 degree off"
"$landfix" fly --map area.lfpack --scene noon/ortho.tif --scene-dem noon/dsm.tif --loop 1000 --agl 305 \
  --attitude-noise-deg 1 --attitude-bias-deg 0 -o flight_305m

cat <<END

Results in $PWD:
  area.lfpack                 the map pack, signed; mission.pub is the key to trust
  overview.png, heights.png   what is in it
  landmarks.png               buildings, fields, trees, roads and intersections over the map
  landmarks.gpkg, roads.gpkg  the same for QGIS, styles included
  navigability.png            where a small view is found again in another year, and where not; .gpkg: with reasons, for QGIS
  region.png                  the pixels inside an uncertainty of 40 m
  flight_60m/tracks.png       truth, estimate with 3-sigma ellipses, and dead reckoning over the map
  flight_60m/frames/          what the camera saw
  flight_evening_*/           the sun elsewhere: gray values against orientation
  flight_heading/track.csv    rotation_deg: what the image says about the heading
  flight_305m/tracks.png      the same from 305 m
  flight_*/summary.json       the numbers
END
