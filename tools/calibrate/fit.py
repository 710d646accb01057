#!/usr/bin/env python3
"""Fits the probability that a match is true, and the gates, from the samples that samples.sh draws.

Usage: fit.py SAMPLES.csv.gz... > runtime/nav/calibration_table.h      (needs NumPy)

Per method a logistic regression on the gap, on its significance (gap over the spread of the scores), on that of the peak
itself, on the number of rotations and scales searched, slopes of a known sign, and on the logarithm of the peak's standard
deviation. The size of the template was tried: it
fits the samples better, and other places worse. Every file weighs the same, whatever its length; elsewhere.csv.gz, whose
images show another place than is searched, takes no part in the fit.

Above the standard gate no file has more than 1 % of false matches by orientation, if one image in twenty more shows a place
that is not in the region searched. The strict gate demands twenty times its odds.
"""
import csv
import gzip
import sys

import numpy as np

METHODS = ("gray", "edge", "contour", "orientation")
LARGEST_SIGNIFICANCE = 12
LARGEST_HEIGHT = 20
ELSEWHERE = 0.05
DECISION = 2
RIDGE = 1e-3


def read(path):
    with gzip.open(path, "rt") if path.endswith(".gz") else open(path) as file:
        return [row for row in csv.DictReader(file) if row["gap"]]


def features(rows):
    value, gap, spread, sigma, similarities = (np.array([float(r[k]) for r in rows]) for k in ("value", "gap", "spread", "sigma_px", "similarities"))
    gap, spread = np.maximum(gap, 0), np.maximum(spread, 1e-6)
    significance = np.minimum(gap / spread, LARGEST_SIGNIFICANCE)
    height = np.clip(value / spread, 0, LARGEST_HEIGHT)
    return np.stack([np.ones_like(gap), gap, significance, height, -np.log(similarities), np.log(np.maximum(sigma, 0.1))], axis=1)


def logistic(x):
    return 1 / (1 + np.exp(-np.clip(x, -30, 30)))


def probability(x, beta):
    """As nav::probability_of: where a rival is as high, a match is at best even."""
    return np.minimum(logistic(x @ beta), 1 - 0.5 * np.exp(-DECISION * x[:, 2]))


def fit(x, y, weights, not_negative):
    """Iteratively reweighted least squares; features whose slope would be negative although more is better drop out."""
    active = np.ones(x.shape[1], bool)
    while True:
        beta = np.zeros(x.shape[1])
        scale = np.maximum(np.abs(x).max(axis=0), 1e-9)
        z = (x / scale)[:, active]
        b = np.zeros(active.sum())
        for _ in range(100):
            p = logistic(z @ b)
            w = weights * np.maximum(p * (1 - p), 1e-6)
            hessian = (z * w[:, None]).T @ z + RIDGE * np.eye(len(b)) * weights.sum() * 1e-3
            step = np.linalg.solve(hessian, z.T @ (weights * (y - p)) - RIDGE * weights.sum() * 1e-3 * b)
            b += step
            if np.abs(step).max() < 1e-9:
                break
        beta[active] = b
        beta = beta / scale
        wrong = [i for i in not_negative if active[i] and beta[i] < 0]
        if not wrong:
            return beta
        active[wrong] = False


def weights_of(files):
    return np.concatenate([np.full(n, 1000.0 / n) for n in files if n])


def report(name, p, y):
    order = np.argsort(-p)
    false = np.cumsum(1 - y[order]) / np.arange(1, len(y) + 1)
    kept = np.nonzero(false <= 0.01)[0]
    edges = np.clip((p * 10).astype(int), 0, 9)
    error = sum(abs(p[edges == i].mean() - y[edges == i].mean()) * (edges == i).mean() for i in range(10) if (edges == i).any())
    print(f"{name:36s} n {len(y):6d}  true {y.mean():.3f}  accepted at 1 % false {(kept.max() + 1) / len(y) if len(kept) else 0:.3f}"
          f"  ECE {error:.3f}", file=sys.stderr)


def threshold(parts, elsewhere, allowed):
    """Lowest probability above which no file, with its share of images from elsewhere, has more false matches than allowed."""
    lowest = 0
    for part in parts:
        p, y = (np.concatenate(both) for both in zip(part, elsewhere))
        weights = np.concatenate([np.full(len(part[0]), 1 / len(part[0])), np.full(len(elsewhere[0]), ELSEWHERE / len(elsewhere[0]))])
        order = np.argsort(-p)
        false = np.cumsum((weights * (1 - y))[order]) / np.cumsum(weights[order])
        kept = np.nonzero(false <= allowed)[0]
        lowest = max(lowest, p[order][kept.max()] if len(kept) else 1)
    return lowest


def with_odds(p, factor):
    return p * factor / (p * factor + 1 - p)


def main(paths):
    data = {path.split("/")[-1].split(".")[0]: read(path) for path in paths}
    table, parts = {}, {}
    for method in METHODS:
        rows = {name: [r for r in file if r["matcher"] == method] for name, file in data.items()}
        x = {name: features(file) for name, file in rows.items() if file}
        y = {name: np.array([float(r["hit"]) for r in rows[name]]) for name in x}
        fitted = [name for name in x if name != "elsewhere"]
        table[method] = fit(np.concatenate([x[n] for n in fitted]), np.concatenate([y[n] for n in fitted]),
                            weights_of([len(y[n]) for n in fitted]), (1, 2, 3, 4))
        parts[method] = {name: (probability(x[name], table[method]), y[name]) for name in x}
        for name, (p, truth) in parts[method].items():
            report(f"{method} {name}", p, truth)
    print("// Written by tools/calibrate/fit.py; not to be edited.")
    print("#pragma once\n\nnamespace landfix::nav {\n")
    print("/// Logistic regression on (1, gap, gap / spread, value / spread, -log similarities, log sigma_px), by Method.")
    print("inline constexpr double kCalibration[4][6] = {")
    rows = ["    {" + ", ".join(f"{b:.6g}" for b in table[method]) + "}," for method in METHODS]
    for method, row in zip(METHODS, rows):
        print(f"{row:{max(map(len, rows))}s}  // {method}")
    print("};")
    print(f"inline constexpr double kLargestSignificance = {LARGEST_SIGNIFICANCE}, kLargestHeight = {LARGEST_HEIGHT};")
    by_orientation = parts["orientation"]
    standard = threshold([part for name, part in by_orientation.items() if name != "elsewhere"], by_orientation["elsewhere"], 0.01)
    print(f"inline constexpr double kStandardThreshold = {standard:.4f};")
    print(f"inline constexpr double kStrictThreshold = {with_odds(standard, 20):.5f};")
    print("\n}  // namespace landfix::nav")


if __name__ == "__main__":
    main(sys.argv[1:])
