#!/usr/bin/env bash
# Measures what is said of routes against simulated flights: the table of docs/routes.md. On real farmland with lakes
# (LANDFIX_DATA; skipped in plain sight where it is absent), and over a drawn world with woods into which a lake and even
# fields are painted, at dates that the map has not seen. Usage: evaluate.sh LANDFIX LANDFIX_DATA FOLDER [RUNS]
set -euo pipefail
landfix=$1 data=$2 out=$3 runs=${4:-50}
mkdir -p "$out"

farmland() {
  local files=("$data"/naip_nd/*.tif) dates=() file name
  for file in "${files[@]}"; do
    name=$(basename "$file" .tif) && name=${name##*_}
    dates+=(--date "$(basename "$file")=${name:0:4}-${name:4:2}-${name:6:2}")
  done
  local last=$((${#files[@]} - 1))
  "$landfix" build "${files[@]:0:last}" "${dates[@]:0:2*last}" --align --navigability 160/40,160/160 \
    -o "$out/farmland.lfpack" --force >"$out/farmland.log" 2>&1
  "$landfix" eval route --map "$out/farmland.lfpack" --scene "${files[last]}" --agl 160 --speed 20 --image-interval 2 \
    --image-size 320,240 --length-m 2500 --require 10m@95% --runs "$runs" --json="$out/farmland.json"
}

# shape NAME X Y WIDTH HEIGHT lake|field: a lake or a rectangle around a place on the world's grid, metres from its
# south-western corner.
shape() {
  local name=$1 ring
  ring=$(awk -v x="$2" -v y="$3" -v w="$4" -v h="$5" -v kind="$6" 'BEGIN {
    n = kind == "lake" ? 120 : 4
    for (i = 0; i <= n; i++) {
      t = i * 8 * atan2(1, 1) / n
      u = kind == "lake" ? cos(t) * (1 + 0.08 * sin(5 * t)) : (i % 4 < 2 ? 1 : -1)
      v = kind == "lake" ? sin(t) * (1 + 0.1 * sin(3 * t)) : ((i + 1) % 4 < 2 ? -1 : 1)
      printf "[%.6f, %.6f],", 500000 + x + w / 2 * u, 5400000 + y + h / 2 * v
    }}')
  echo '{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:32633"}}, "features": [{"type":
    "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [['"${ring%,}"']]}}]}' >"$out/$name.geojson"
}

# draw NAME K SEASON YEAR SUN: the world at a date, the k-th; crops of the even fields change their colour, the lake hardly.
draw() {
  local name=$1 k=$2 ortho=$out/$1/ortho.tif
  "$landfix" synth -o "$out/$name" --seed 33 --size-m 5000 --gsd 2 --dem-gsd 16 --relief-m 5 --season "$3" --year "$4" \
    --sun "$5" >/dev/null
  paint() { gdal_rasterize -q -b 1 -burn "$2" -b 2 -burn "$3" -b 3 -burn "$4" "$out/$1.geojson" "$ortho"; }
  paint lake $((28 + k)) $((48 + k)) $((60 + 2 * k))
  paint south $((90 + 12 * k)) $((100 + 7 * k)) $((60 + 3 * k))
  paint west $((180 - 9 * k)) $((150 - 5 * k)) 80
  paint east $((70 + 5 * k)) $((140 - 6 * k)) 60
}

mixed() {
  shape lake 2300 2600 1900 1200 lake
  shape south 3900 1300 1200 800 field; shape west 900 3900 1100 900 field; shape east 4200 3700 700 1400 field
  draw map1 1 summer 2017 150,50; draw map2 2 spring 2018 170,45; draw map3 3 autumn 2019 200,35
  draw map4 4 summer 2020 130,45
  draw fly1 5 summer 2021 190,55; draw fly2 6 autumn 2021 160,35; draw fly3 7 spring 2022 210,45
  draw fly4 8 summer 2022 120,40; draw fly5 9 spring 2021 140,40
  "$landfix" build "$out"/map?/ortho.tif --navigability 80/20,80/40,80/80 -o "$out/mixed.lfpack" --force \
    >"$out/mixed.log" 2>&1
  "$landfix" eval route --map "$out/mixed.lfpack" --scene "$out/fly1/ortho.tif" --scene "$out/fly2/ortho.tif" \
    --scene "$out/fly3/ortho.tif" --scene "$out/fly4/ortho.tif" --scene "$out/fly5/ortho.tif" --agl 80 --speed 15 \
    --image-interval 2 --image-size 320,240 --length-m 3000 --require 5m@95% --runs "$((runs / 5))" --json="$out/mixed.json"
}

if [ -d "$data/naip_nd" ]; then farmland; else echo "skipped: no $data/naip_nd (LANDFIX_DATA)"; fi
mixed
