#!/usr/bin/env bash
# Builds packs of large images and fails where that takes more memory or time than it may.
#   memory.sh LANDFIX [FOLDER]
# 1. 65,536 x 65,536 pixels with heights: gray, overview and height in 1 GiB.
# 2. 22,167 x 25,100 pixels at 0.3 m: landmarks and roads in 2 GiB and 5 minutes on 2 cores.
# The images are VRTs that repeat drawn worlds. Needs about 20 GB of disk, freed at the end.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
landfix=${1:?usage: memory.sh LANDFIX [FOLDER]}
folder=${2:-build/memory}

mkdir -p "$folder"
trap 'rm -rf "$folder/map.lfpack" "$folder/map.lfpack.build"' EXIT

# measure NAME MEGAPIXELS LIMIT_MIB LIMIT_S ARGUMENTS...: peak resident memory as the kernel counted it for the finished build (Linux gives KiB).
measure() {
  /usr/bin/python3 - "$@" <<'PYTHON'
import resource, subprocess, sys, time
name, megapixels, limit_mib, limit_s, command = sys.argv[1], float(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]), sys.argv[5:]
start = time.monotonic()
subprocess.run(command, check=True)
seconds = time.monotonic() - start
peak_mib = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
met = peak_mib <= limit_mib and seconds <= limit_s
print(f"{name}: {megapixels:.0f} Mpx in {seconds:.0f} s ({megapixels / seconds:.1f} Mpx/s; limit {limit_s:.0f} s), "
      f"peak resident memory {peak_mib:.0f} MiB, limit {limit_mib} MiB: {'met' if met else 'missed'}")
sys.exit(not met)
PYTHON
}

# No multiples of the tile size: equal tiles would be made only once.
[ -f "$folder/world/dsm.tif" ] || "$landfix" synth -o "$folder/world" --size-m 3100 --gsd 1 --dem-gsd 2
"$here/repeat.py" "$folder/world/ortho.tif" 65536 65536 "$folder/rgb.vrt"
"$here/repeat.py" "$folder/world/dsm.tif" 32768 32768 "$folder/heights.vrt"
[ -f "$folder/town/ortho.tif" ] || "$landfix" synth -o "$folder/town" --seed 3 --size-m 1530 --gsd 0.3
"$here/repeat.py" "$folder/town/ortho.tif" 22167 25100 "$folder/town.vrt"

failed=0
measure "landmarks and roads" 556.4 2048 300 \
  "$landfix" build "$folder/town.vrt" --layers landmarks,roads --force -o "$folder/map.lfpack" || failed=1
measure "gray, overview, height" 4295 1024 3600 \
  "$landfix" build "$folder/rgb.vrt" --dem "$folder/heights.vrt" --dem-datum ellipsoid \
  --layers gray,overview,height --force -o "$folder/map.lfpack" || failed=1
exit $failed
