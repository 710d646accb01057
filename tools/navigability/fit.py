#!/usr/bin/env python3
"""Fits the chance of a true fix at a place to the samples that landfix_navigability_samples draws, or tests it.

Usage: fit.py SAMPLES.csv[.gz]... > builder/navigability/model_table.h      (needs NumPy)
       fit.py --test SAMPLES.csv[.gz]...        figures of the probabilities that the samples carry
       fit.py --pack OUT.csv.gz SAMPLES.csv...  what the fit needs and no more; the same bytes for the same samples

Logistic regressions on the evidence of each matcher, one for places that several dates show, one for a single date.
Slopes whose sign is known keep it or drop out. Every world weighs the same.
"""
import csv
import gzip
import io
import sys

import numpy as np

LEAST_STRUCTURE = 0.03  # so much may be noise
RIDGE = 50 / 1e4  # per sample's weight of one, on standardised features
KEPT = "method ground dates template_px least_logit mean_logit structure crest background hit".split()
METHODS = "gray edge contour orientation".split()  # as nav::Method counts them
DRAWN = "orientation"  # for which views of other days are drawn where there is one date
SIGNS = {"several": (1, 1, 1, -1, 1, -1), "views": (1, -1, 1, 1, -1), "one": (1, -1, 1, 1)}


def rows_of(paths):
    rows = []
    for path in paths:
        with gzip.open(path, "rt") if path.endswith(".gz") else open(path) as file:
            rows += [row for row in csv.DictReader(file) if int(row["dates"]) > 0]
    return rows


def read(paths, also=()):
    rows = rows_of(paths)
    table = {name: np.array([float(row[name]) for row in rows]) for name in (*KEPT[2:], *also)}
    table |= {name: np.array([row[name] for row in rows]) for name in KEPT[:2]}
    return table


def pack(out, paths):
    text = io.StringIO()
    writer = csv.DictWriter(text, KEPT, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows_of(paths))
    with open(out, "wb") as file:
        file.write(gzip.compress(text.getvalue().encode(), 9, mtime=0))


def features(t, kind):
    size, structure = np.log(t["template_px"] / 40), np.log(t["structure"] + LEAST_STRUCTURE)
    if kind == "one":
        return np.stack([t["structure"], t["background"], t["crest"], size], axis=1)
    if kind == "views":
        return np.stack([structure, t["background"], t["mean_logit"], size, t["mean_logit"] * size], axis=1)
    dates = np.maximum(t["dates"], 2)
    return np.stack([t["least_logit"], t["mean_logit"], structure, t["background"], size, 1 / (dates * (dates - 1))], axis=1)


def logistic(x):
    return 1 / (1 + np.exp(-np.clip(x, -30, 30)))


def fit(x, y, weights, signs):
    """Iteratively reweighted least squares; (intercept, slopes)."""
    signs, active = np.array(signs), np.ones(x.shape[1], bool)
    mean, spread = np.average(x, axis=0, weights=weights), np.maximum(x.std(axis=0), 1e-9)
    while True:
        z = np.column_stack([np.ones(len(x)), ((x - mean) / spread)[:, active]])
        ridge = RIDGE * weights.sum() / max(weights.sum() / 1e4, 1) * np.diag([0] + [1] * active.sum())
        b = np.zeros(z.shape[1])
        for _ in range(100):
            p = logistic(z @ b)
            hessian = (z * (weights * np.maximum(p * (1 - p), 1e-6))[:, None]).T @ z + ridge
            step = np.linalg.solve(hessian, z.T @ (weights * (y - p)) - ridge @ b)
            b += step
            if np.abs(step).max() < 1e-9:
                break
        slopes = np.zeros(x.shape[1])
        slopes[active] = b[1:] / spread[active]
        wrong = slopes * signs < 0
        if not wrong.any():
            return np.concatenate([[b[0] - slopes @ mean], slopes])
        active &= ~wrong


def auc(p, y):
    order = np.argsort(p, kind="stable")
    rank = np.empty(len(p))
    _, first, inverse, count = np.unique(p[order], return_index=True, return_inverse=True, return_counts=True)
    rank[order] = (first + (count + 1) / 2)[inverse]
    true = y > 0.5
    n1, n0 = true.sum(), (~true).sum()
    return (rank[true].sum() - n1 * (n1 + 1) / 2) / (n1 * n0) if n1 and n0 else float("nan")


def calibration_error(p, y):
    bins = np.clip((p * 10).astype(int), 0, 9)
    return sum(abs(p[bins == i].mean() - y[bins == i].mean()) * (bins == i).mean() for i in range(10) if (bins == i).any())


def report(name, p, t):
    y = t["hit"]
    if len(y) == 0:
        return
    print(f"{name:48s} n {len(y):6d}  true {y.mean():.3f}  stated {p.mean():.3f}  AUC {auc(p, y):.3f}  ECE {calibration_error(p, y):.3f}",
          file=sys.stderr)


def part(t, which):
    return {name: values[which] for name, values in t.items()}


def report_all(p, t):
    for n in np.unique(t["dates"]):
        for side in np.unique(t["template_px"]):
            which = (t["dates"] == n) & (t["template_px"] == side)
            report(f"{t['method'][0]}, {n:.0f} dates, template {side:.0f} px", p[which], part(t, which))


def fit_method(t, method):
    """Rows for several dates, and for one or for views drawn of it."""
    rows = {}
    for kind, which in (("several", t["dates"] > 1), ("views" if method == DRAWN else "one", t["dates"] == 1)):
        some = part(t, which & (t["method"] == method))
        x, y = features(some, kind), some["hit"]
        _, group, count = np.unique(some["ground"], return_inverse=True, return_counts=True)
        rows[kind] = fit(x, y, 1e4 / len(count) / count[group], SIGNS[kind])
        report_all(logistic(rows[kind][0] + x @ rows[kind][1:]), some)
    return rows


def numbers(row):
    return "{" + ", ".join(f"{b:.6g}" for b in row) + "}"


def print_rows(name, rows):
    lines = ",\n".join(f"    {numbers(row)}" for row in rows)
    print(f"inline constexpr double {name}[{len(rows)}][{len(rows[0])}] = {{\n{lines}}};")


def main(args):
    if args[0] == "--test":
        t = read(args[1:], also=("probability",))
        for method in [*METHODS, "auto"]:
            some = part(t, t["method"] == method)
            if len(some["hit"]):
                report_all(some["probability"], some)
        return
    if args[0] == "--pack":
        return pack(args[1], args[2:])
    t = read(args)
    rows = {method: fit_method(t, method) for method in METHODS}
    print("// Written by tools/navigability/fit.py; not to be edited.\n#pragma once\n\nnamespace landfix::navigability {\n")
    print("/// Logistic regression on (1, least logit, mean logit, log (structure + kLeastStructure), background,")
    print("/// log template / 40 px, 1 / (n (n - 1))), n dates; rows by nav::Method.")
    print(f"inline constexpr double kLeastStructure = {LEAST_STRUCTURE};")
    print_rows("kSeveralDates", [rows[method]["several"] for method in METHODS])
    print("/// Where there is one date: on (1, structure, background, crest, log template / 40 px).")
    print_rows("kOneDate", [rows[method]["one"] for method in METHODS if method != DRAWN])
    print("/// By drawn views, of orientation: on (1, log (structure + kLeastStructure), background, mean logit, log template / 40")
    print("/// px, mean logit times that).")
    print(f"inline constexpr double kDrawnViews[{len(rows[DRAWN]['views'])}] = {numbers(rows[DRAWN]['views'])};")
    print("\n}  // namespace landfix::navigability")


if __name__ == "__main__":
    main(sys.argv[1:])
