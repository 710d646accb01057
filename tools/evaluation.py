#!/usr/bin/env python3
"""Prints what evaluation.sh measured as Markdown tables. Usage: evaluation.py FOLDER"""
import glob
import json
import os
import sys


def percent(x, digits=1):
    return "–" if x is None else f"{100 * x:.{digits}f}"


def row(camera):
    """Hits, oracle accept rate by probability and by gap, accept and false-fix rate of the gates, ECE, ellipse, ms."""
    oracle, gate = camera["oracle"], camera["gate"]
    return [camera["hit_rate"], oracle["by_probability"]["at_1pct_false"]["accept_rate"],
            oracle["by_gap"]["at_1pct_false"]["accept_rate"], gate["standard"]["accept_rate"], gate["standard"]["false_rate"],
            gate["strict"]["accept_rate"], gate["strict"]["false_rate"], camera["expected_calibration_error"],
            camera["hits_in_95pct_ellipse"]]


TITLES = ["hits", "oracle, probability", "oracle, gap", "standard: accepted", "false", "strict: accepted", "false", "ECE",
          "in 95 % ellipse"]


def register(folder, name, title):
    files = sorted(glob.glob(os.path.join(folder, name + ".2*.json")))
    files += sorted(glob.glob(os.path.join(folder, name + ".others.2*.json")))
    if not files:
        return
    cameras = {}
    for path in files:
        date = path.split(".")[-2]
        with open(path) as file:
            for matcher in json.load(file)["matchers"]:
                camera = matcher["cameras"][0]
                cameras.setdefault(matcher["matcher"], {})[date] = camera
    print(f"\n{title}\n\n| matcher, camera | " + " | ".join(TITLES) + " |\n|---|" + "---|" * len(TITLES))
    for matcher, by_date in cameras.items():
        rows = [row(camera) for camera in by_date.values()]
        if matcher == "orientation":
            for date, values in zip(by_date, rows):
                print(f"| {matcher}, {date} | " + " | ".join(percent(v) for v in values) + " |")
        known = [[v for v in column if v is not None] for column in zip(*rows)]
        print(f"| {matcher}, mean | " + " | ".join(percent(sum(c) / len(c)) if c else "–" for c in known) + " |")


def pairs(folder):
    path = os.path.join(folder, "pairs.json")
    if not os.path.exists(path):
        return
    with open(path) as file:
        matchers = json.load(file)["matchers"]
    print("\ndated_pairs, 128 px searched over the whole image, both ways\n\n| matcher | hits | oracle, probability | standard: accepted "
          "| false |\n|---|---|---|---|---|")
    for matcher in matchers:
        v = row(matcher["pooled"])
        print(f"| {matcher['matcher']} | {percent(v[0])} | {percent(v[1])} | {percent(v[3])} | {percent(v[4])} |")


def photos(folder):
    path = os.path.join(folder, "photos.json")
    if not os.path.exists(path):
        return
    with open(path) as file:
        report = json.load(file)
    print("\nbrighton_beach_us\n\n| photo | on the map | status | matcher | probability | east, north of its tag, m |\n|---|---|---|---|---|---|")
    for photo in report["photos"]:
        offset = photo.get("offset_from_tag_m")
        place = f"{offset['east']:.1f}, {offset['north']:.1f}" if offset else "–"
        print(f"| {photo['name']} | {percent(photo.get('share_on_map'), 0)} % | {photo['status']} | {photo.get('matcher') or '–'} "
              f"| {percent(photo.get('probability'))} | {place if photo['fix'] else '–'} |")


def main(folder):
    register(folder, "naip.320", "naip_nd, template 320 m, ±320 m, map from the four other dates")
    register(folder, "naip.240", "naip_nd, 240 m, ±160 m")
    register(folder, "naip.160", "naip_nd, 160 m, ±160 m")
    register(folder, "naip.320.turned", "naip_nd, 320 m, ±320 m, heading in error by 3°, scale by 3 %")
    register(folder, "naip.160.turned", "naip_nd, 160 m, ±160 m, heading in error by 3°, scale by 3 %")
    register(folder, "naip.320.alone", "naip_nd, 320 m, ±320 m, map from 2009 alone")
    pairs(folder)
    photos(folder)


if __name__ == "__main__":
    main(sys.argv[1])
