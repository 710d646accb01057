#!/usr/bin/env python3
"""Prints what evaluate.sh measured as Markdown tables. Usage: evaluation.py FOLDER"""
import json
import os
import sys

TEXTURES = ["entropy", "standard_deviation", "edge_density", "fisher_information"]


def estimate(e, digits=3):
    if e["value"] is None:
        return "–"
    low, high = e["interval_95"]
    return f"{e['value']:.{digits}f}" + ("" if low is None else f" ({low:.{digits}f}–{high:.{digits}f})")


def pooled(folder, name):
    with open(os.path.join(folder, name + ".json")) as file:
        return {m["matcher"]: m for m in json.load(file)["matchers"]}


def main(folder):
    print("| map, matcher | places | true | AUC | ECE | in 95 % ellipse | Spearman | rms stated / actual |\n" + "|---" * 8 + "|")
    for name, text in (("dates4", "4 dates"), ("dates3", "3 dates"), ("dates1", "1 date"), ("dates1.unknown", "1 date, age not known")):
        for matcher, m in pooled(folder, name).items():
            f = m["pooled"]
            rms = f["rms_error_m"]
            print(f"| {text}, {matcher} | {f['samples']} | {100 * f['true_fixes'] / f['samples']:.1f} % | "
                  f"{estimate(f['auc'])} | {estimate(f['expected_calibration_error'])} | {estimate(f['in_95pct_ellipse'])} | "
                  f"{estimate(f['rank_correlation'], 2)} | {rms['expected']:.2f} / {rms['actual']:.2f} m |")
    print("\n| AUC on the same places | 4 dates | 3 dates | 1 date |\n|---|---|---|---|")
    all_dates = [pooled(folder, f"dates{n}")["orientation"]["pooled"] for n in (4, 3, 1)]
    print("| **navigability** | " + " | ".join(estimate(f["auc"]) for f in all_dates) + " |")
    for name in TEXTURES:
        print(f"| {name.replace('_', ' ')} | " + " | ".join(estimate(f["auc_of"][name]) for f in all_dates) + " |")
    print("\n| stated, 4 dates | places | mean stated | true fixes |\n|---|---|---|---|")
    for b in all_dates[0]["calibration"]:
        if b["count"]:
            print(f"| {b['from']:.1f}–{b['to']:.1f} | {b['count']} | {b['predicted']:.3f} | {b['observed']:.3f} |")
    print("\n| camera, 4 dates | AUC | ECE | in 95 % ellipse |\n|---|---|---|---|")
    for c in pooled(folder, "dates4")["orientation"]["cameras"]:
        print(f"| {c['camera']} | {estimate(c['auc'])} | {estimate(c['expected_calibration_error'])} | {estimate(c['in_95pct_ellipse'])} |")


main(sys.argv[1])
