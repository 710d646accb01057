#!/usr/bin/env bash
# Builds a pack of a 4-gigapixel image and fails where that takes more than 1 GiB of memory.
#   memory.sh LANDFIX [SIDE_PX [FOLDER]]
# The image is a VRT that repeats a drawn world, with heights. Needs about 20 GB of disk, freed at the end.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
landfix=${1:?usage: memory.sh LANDFIX [SIDE_PX [FOLDER]]}
side_px=${2:-65536}
folder=${3:-build/memory}
limit_mib=1024

mkdir -p "$folder"
trap 'rm -rf "$folder/map.lfpack" "$folder/map.lfpack.build"' EXIT
# No multiple of the tile size: equal tiles would be made only once.
[ -f "$folder/world/dsm.tif" ] || "$landfix" synth -o "$folder/world" --size-m 3100 --gsd 1 --dem-gsd 2
"$here/repeat.py" "$folder/world/ortho.tif" "$side_px" "$side_px" "$folder/rgb.vrt"
"$here/repeat.py" "$folder/world/dsm.tif" $((side_px / 2)) $((side_px / 2)) "$folder/heights.vrt"

# Peak resident memory as the kernel counted it for the finished build; Linux gives KiB.
/usr/bin/python3 - "$limit_mib" "$side_px" \
  "$landfix" build "$folder/rgb.vrt" --dem "$folder/heights.vrt" --dem-datum ellipsoid \
  --layers gray,overview,height --force -o "$folder/map.lfpack" <<'PYTHON'
import resource, subprocess, sys, time
limit_mib, side_px, command = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
start = time.monotonic()
subprocess.run(command, check=True)
seconds = time.monotonic() - start
peak_mib = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
gigapixels = side_px**2 / 1e9
print(f"{gigapixels:.2f} gigapixels in {seconds:.0f} s ({1000 * gigapixels / seconds:.1f} Mpx/s), "
      f"peak resident memory {peak_mib:.0f} MiB, limit {limit_mib} MiB: {'met' if peak_mib <= limit_mib else 'missed'}")
sys.exit(peak_mib > limit_mib)
PYTHON
