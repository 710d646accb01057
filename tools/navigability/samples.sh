#!/usr/bin/env bash
# Draws the samples that the chance of a fix is fitted to: worlds of five seasons and years, views of 16 to 40 pixels, so
# that not everything succeeds, searched over ±40 and ±80 pixels. Fewer for the matchers that are not asked first. An
# hour on one core. Then: fit.py FOLDER/drawn.csv.gz > builder/navigability/model_table.h
# Usage: samples.sh LANDFIX_NAVIGABILITY_SAMPLES FOLDER
set -euo pipefail
program=$1 folder=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" -o "$work/1.csv" --first 601 --worlds 4 --search-px 40 --spacing-px 120
"$program" -o "$work/2.csv" --first 611 --worlds 5 --search-px 40 --spacing-px 160
"$program" -o "$work/3.csv" --first 619 --worlds 2 --search-px 80 --spacing-px 160
for method in gray edge contour; do
  "$program" -o "$work/4_$method.csv" --method $method --first 601 --worlds 3 --search-px 40 --spacing-px 240
  "$program" -o "$work/5_$method.csv" --method $method --first 605 --worlds 3 --search-px 40 --spacing-px 160
  "$program" -o "$work/6_$method.csv" --method $method --first 619 --worlds 1 --search-px 80 --spacing-px 280
done
/usr/bin/python3 "$(dirname "$0")/fit.py" --pack "$folder/drawn.csv.gz" "$work"/*.csv
