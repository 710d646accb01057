#!/usr/bin/env bash
# The runs on real imagery of docs/real-imagery.md. Usage: real_imagery.sh LANDFIX DATA_FOLDER OUTPUT_FOLDER
set -euo pipefail
landfix=$(realpath "$1")
data=$2
out=$3
if [ ! -d "$data/hura_il" ]; then
  echo "SKIPPED: no imagery at $data; set LANDFIX_DATA to the folder that holds hura_il, naip_nd and the others"
  exit 0
fi
data=$(realpath "$data")
mkdir -p "$out"
cd "$out"
step() { printf '\n== %s\n' "$*"; }
build() { "$landfix" build --force "$@"; }

step "hura_il: 13 km2, no heights (about 400 m above the ellipsoid there)"
build "$data/hura_il/hura_0.5m_13km2.tif" --plane-height 400 --georegistration-error 0.5 -o hura.lfpack

step "naip_nd: the map of 2009, of all dates, and of all but that of the camera"
naip=$data/naip_nd/m_4709963_se_14_1
build ${naip}_20090818.tif --date ${naip}_20090818.tif=2009-08-18 --plane-height 540 --georegistration-error 2.5 -o naip_2009.lfpack
build ${naip}_20090818.tif ${naip}_20100629.tif ${naip}_20140720.tif ${naip}_20160816.tif ${naip}_20180716.tif \
  --date ${naip}_20090818.tif=2009-08-18 --date ${naip}_20100629.tif=2010-06-29 --date ${naip}_20140720.tif=2014-07-20 \
  --date ${naip}_20160816.tif=2016-08-16 --date ${naip}_20180716.tif=2018-07-16 --plane-height 540 --georegistration-error 2.5 -o naip.lfpack
build ${naip}_20090818.tif ${naip}_20100629.tif ${naip}_20160816.tif ${naip}_20180716.tif \
  --date ${naip}_20090818.tif=2009-08-18 --date ${naip}_20100629.tif=2010-06-29 --date ${naip}_20160816.tif=2016-08-16 \
  --date ${naip}_20180716.tif=2018-07-16 --plane-height 540 --georegistration-error 2.5 -o naip_without_2014.lfpack

step "portugal_odm, meilen_ch, tahoe_us, brighton_beach_us"
# These surface models state no vertical datum; ellipsoidal is what OpenDroneMap and the drone's log give, the others are near enough here.
build "$data/portugal_odm/portugal_ortho_6cm.tif" --dem "$data/portugal_odm/portugal_dsm_25cm.tif" --dem-datum ellipsoid -o portugal.lfpack
build "$data/meilen_ch/meilen_swissimage_0.5m.tif" --dem "$data/meilen_ch/meilen_dtm_1m.tif" --dem-datum egm96 -o meilen.lfpack
build "$data/meilen_ch/zurich_swissimage_0.5m.tif" --plane-height 450 -o zurich.lfpack
build "$data/tahoe_us/tahoe_highrez.tif" --dem "$data/tahoe_us/tahoe_lidar_bareearth.tif" --dem-datum egm96 \
  --bands "$data/tahoe_us/tahoe_highrez.tif=nir,red,green" -o tahoe.lfpack
build "$data/brighton_beach_us/brighton_ortho.tif" --dem "$data/brighton_beach_us/brighton_dsm.tif" --dem-datum egm96 -o brighton.lfpack
for pack in *.lfpack; do "$landfix" verify --deep "$pack"; done

step "hura_il from 60 m: the camera sees the 0.26 m file, which lies about 1.5 m off the map; the shift is measured and taken out"
"$landfix" fly --map hura.lfpack --scene "$data/hura_il/hura_0.25m_2km2.tif" --scene-nodata 0 \
  --center 34.9286,31.2962 --scene-plane 400 --measure-shift --loop 1000 --agl 60 --runs 5 --frames 6 -o hura_60m
step "hura_il from 305 m"
"$landfix" fly --map hura.lfpack --scene "$data/hura_il/hura_0.25m_2km2.tif" --scene-nodata 0 \
  --center 34.9286,31.2962 --scene-plane 400 --measure-shift --loop 1000 --agl 305 --attitude-noise-deg 1 --attitude-bias-deg 0 --runs 5 -o hura_305m
step "naip_nd from 1500 m: the map of 2009 or of four dates, the camera on a day of 2014"
for map in naip_2009 naip_without_2014; do
  "$landfix" fly --map $map.lfpack --scene ${naip}_20140720.tif --scene-plane 540 --racetrack 6000 --agl 1500 --speed 40 --turn-radius 300 \
    --runs 5 -o ${map}_1500m
done
step "The same flights by gray values alone"
"$landfix" fly --map hura.lfpack --scene "$data/hura_il/hura_0.25m_2km2.tif" --scene-nodata 0 --matcher gray \
  --center 34.9286,31.2962 --scene-plane 400 --measure-shift --loop 1000 --agl 60 --runs 5 -o hura_60m_gray
for map in naip_2009 naip_without_2014; do
  "$landfix" fly --map $map.lfpack --scene ${naip}_20140720.tif --scene-plane 540 --racetrack 6000 --agl 1500 --speed 40 --turn-radius 300 \
    --runs 5 --matcher gray -o ${map}_1500m_gray
done
step "hura_il from 60 m, the compass 3 degrees off"
"$landfix" fly --map hura.lfpack --scene "$data/hura_il/hura_0.25m_2km2.tif" --scene-nodata 0 \
  --center 34.9286,31.2962 --scene-plane 400 --measure-shift --loop 1000 --agl 60 --heading-bias-deg 3 --runs 5 -o hura_60m_heading
echo
echo "Results in $PWD: packs, and a folder with tracks.png and summary.json for each flight"
