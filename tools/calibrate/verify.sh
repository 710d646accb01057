#!/usr/bin/env bash
# Puts the gates to the test on drawn worlds that played no part in their calibration: map in summer, camera in another
# season and year. Prints samples, hits, accepted and false fixes of both gates with one-sided 95 % bounds.
# Usage: verify.sh LANDFIX FIRST_SEED WORLDS [SAMPLES_PER_WORLD]
set -euo pipefail
landfix=$1 first=$2 worlds=$3 samples=${4:-500}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
seasons=("spring 2018 200,30" "autumn 2020 235,25" "winter 2021 170,18" "summer 2019 240,40")
for ((i = 0; i < worlds; ++i)); do
  seed=$((first + i)) template=$((80 + 32 * (i % 3)))
  read -r season year sun <<<"${seasons[i % 4]}"
  "$landfix" synth -o "$work/map" --seed "$seed" --size-m 4000 --gsd 2 --dem-gsd 4 --season summer --year 2016 --nir >/dev/null
  "$landfix" synth -o "$work/camera" --seed "$seed" --size-m 4000 --gsd 2 --dem-gsd 4 --season "$season" --year "$year" --sun "$sun" >/dev/null
  "$landfix" build "$work/map/ortho.tif" --layers gray --layers orientation -o "$work/map.lfpack" --force >/dev/null 2>&1
  "$landfix" eval register --map "$work/map.lfpack" --camera "$work/camera/ortho.tif" --template-m "$template" --search-m 200 \
    --hit-m 7.5 --samples "$samples" --seeds 1 --matcher auto --samples-csv "$work/$i.csv" --json >"$work/$i.json" 2>/dev/null
done
python3 - "$work" <<'PYTHON'
import csv, glob, json, math, sys

def upper(false, total):
    """One-sided 95 % bound of a share (Clopper and Pearson), by bisection."""
    low, high = false / max(total, 1), 1.0
    for _ in range(60):
        middle = (low + high) / 2
        tail = sum(math.exp(math.lgamma(total + 1) - math.lgamma(k + 1) - math.lgamma(total - k + 1) + k * math.log(middle) +
                            (total - k) * math.log1p(-middle)) for k in range(false + 1))
        low, high = (middle, high) if tail > 0.05 else (low, middle)
    return high

rows = [row for path in glob.glob(sys.argv[1] + "/*.csv") for row in csv.DictReader(open(path))]
print(f"{len(rows)} samples, {100 * sum(row['hit'] == '1' for row in rows) / len(rows):.1f} % hits")
gates = json.load(open(glob.glob(sys.argv[1] + "/*.json")[0]))["matchers"][0]["cameras"][0]["gate"]
for name, gate in gates.items():
    kept = [row for row in rows if row["probability"] and float(row["probability"]) >= gate["threshold"]]
    false = sum(row["hit"] != "1" for row in kept)
    print(f"{name}: accepted {100 * len(kept) / len(rows):.1f} %, false {false} of {len(kept)}, at most "
          f"{100 * upper(false, len(kept)):.3f} %")
PYTHON
