"""Fit the weights of the confidence of a phrase, and say how well it holds on unseen data sets.

Run it as ``python tests/tools/fit_confidence.py FILE.jsonl... [--maps DIR] [--annotations GOLD]``.
Each file is a data set: the figures are cross-fitted, every file in turn left out (files of several
maps by the city of the map). ``--write`` puts the weights fitted on all into the package.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from sloop_ppl.eval._calibration import calibration
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval._parse_counts import ReadLine
from sloop_ppl.eval.descriptions import read_descriptions
from sloop_ppl.language import _confidence
from sloop_ppl.language.rules import STEPS, begin

WEIGHTS = Path(__file__).resolve().parents[2] / "sloop_ppl" / "data" / "confidence.json"
RIDGE = 1.0  # precision of a normal prior on each weight: weights beyond 2 or so need evidence


def fit(x, y, weights):
    """Return intercept and weights of a ridge logistic regression; the intercept is free."""

    def loss(beta):
        score = beta[0] + x @ beta[1:]
        return np.sum(weights * (np.logaddexp(0, score) - y * score)) + RIDGE / 2 * np.sum(
            beta[1:] ** 2
        )

    def slope(beta):
        error = weights * (1 / (1 + np.exp(-(beta[0] + x @ beta[1:]))) - y)
        return np.concatenate([[error.sum()], x.T @ error + RIDGE * beta[1:]])

    start = np.zeros(x.shape[1] + 1)
    return minimize(loss, start, jac=slope, method="L-BFGS-B").x


def read(files, maps, annotations):
    """Return features, whether each relation was read right, its description and data set."""
    rows, right, lines, sets = [], [], [], []
    find = map_finder(maps)
    cities = {}
    for path in files:
        for one in read_descriptions([path], find, annotations):
            if not one.has_gold:
                continue
            city = cities.get(one.map) or cities.setdefault(one.map, find(one.map))
            state = begin(one.text, city, one.objects or None)
            for step in STEPS.values():
                step(state)
            said = state.description
            everything = max(said.all_readings(), key=lambda h: len(h.relations)).relations
            said = type(said)(said.text, said.map, said.targets, everything)
            line = ReadLine(one, one.gold, said.placed(one.hearer))
            wrong = {s for w in line.matched("polarity").wrong for s in w.sources}
            kept = line.read.relations
            order = {(r.figure, r.relation, r.grounds, r.negated): k for k, r in enumerate(kept)}
            for relation, features in zip(everything, state.features, strict=True):
                k = order.get(
                    (relation.figure, relation.relation, relation.grounds, relation.negated)
                )
                if k is None:
                    continue
                rows.append(features)
                right.append(k not in wrong)
                lines.append(f"{path}:{one.id}")
                sets.append(
                    one.map
                    if "/" not in one.map and len(one.map) < 20 and "rvs" not in one.map
                    else str(path)
                )
    return np.array(rows), np.array(right, float), lines, np.array(sets)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+")
    parser.add_argument("--maps")
    parser.add_argument("--more", nargs="*", default=[], help="files on other maps: FILE@MAPS@GOLD")
    parser.add_argument("--annotations")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    none = 0.0, (0.0,) * len(_confidence.FEATURES)  # the kept weights may be of other features
    _confidence._weights = lambda: none
    x, y, lines, sets = read(given.files, given.maps, given.annotations)
    for more in given.more:
        path, maps, gold = more.split("@")
        more_x, more_y, more_lines, more_sets = read([path], maps, gold or None)
        x, y = np.concatenate([x, more_x]), np.concatenate([y, more_y])
        lines, sets = lines + more_lines, np.concatenate([sets, more_sets])
    ones = np.ones(len(y))
    held_out = np.zeros(len(y))
    for name in np.unique(sets):
        out = sets == name
        beta = fit(x[~out], y[~out], ones[~out])
        held_out[out] = 1 / (1 + np.exp(-(beta[0] + x[out] @ beta[1:])))
        print(f"{name}: n {out.sum()}, right {y[out].mean():.3f}, told {held_out[out].mean():.3f}")
    found = calibration(list(held_out), list(y > 0), lines, rng=np.random.default_rng(0))
    print(json.dumps(found.to_json(), indent=1))
    beta = fit(x, y, ones)
    named = dict(zip(_confidence.FEATURES, (round(float(b), 4) for b in beta[1:]), strict=True))
    print(json.dumps(named, indent=1))
    if given.write:
        about = (
            "Weights of the logistic regression for the confidence of a phrase; "
            "see fit_confidence.py."
        )
        data = {
            "about": about,
            "n": len(y),
            "intercept": round(float(beta[0]), 4),
            "weights": named,
        }
        WEIGHTS.write_text(json.dumps(data, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
