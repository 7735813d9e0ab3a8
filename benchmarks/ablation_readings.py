"""Measure what it is worth to sum over readings and over referents.

Run: python benchmarks/ablation_readings.py [FILE.jsonl ...] [--maps DIR] [--quick]

Each text is parsed, and ``bayes`` infers its beliefs four times: with all readings and all places
that a mention may refer to, with the most probable reading alone, with the most probable place of
each mention alone, and with the best of both. Printed are the mean log scores in nats and the
paired differences, with 95 % intervals over configurations. Of lines with ``area_m`` the beliefs
are of that area. ``1 %`` has 1 % of the uniform belief mixed in, which bounds what one target can
cost.
Without files the bundled examples are taken, with --quick a few of them.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch

from sloop_ppl.eval import bundled_examples, read_descriptions
from sloop_ppl.eval._bootstrap import clustered_interval
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval.quality import beliefs_of, read_annotated
from sloop_ppl.models import preset

VARIANTS = {
    "all": {},
    "best reading": {"sum_readings": False},
    "best place": {"sum_grounds": False},
    "best of both": {"sum_readings": False, "sum_grounds": False},
}


def in_area(belief, grid, area_m):
    """Return a belief and the uniform one, restricted to an area and normalised."""
    xs, ys = grid.x_m[None, :], grid.y_m[:, None]
    west, south, east, north = area_m or (-np.inf, -np.inf, np.inf, np.inf)
    inside = (xs >= west) & (xs <= east) & (ys >= south) & (ys <= north)
    kept = np.where(inside, belief, 0.0)
    uniform = inside / inside.sum()
    total = kept.sum()
    return (kept / total if total > 0 else uniform), uniform


def main() -> None:
    """Print one row per variant, and one per difference."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("files", nargs="*", help="description files, .jsonl")
    options.add_argument("--maps", type=Path, help="folder of their maps")
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    given = options.parse_args()
    find = map_finder(given.maps)
    files = given.files
    descriptions = read_descriptions(files, find) if files else bundled_examples()
    if given.quick:
        descriptions = descriptions[::5]
    torch.set_num_threads(1)
    scores: dict[str, list[float]] = {name: [] for name in (*VARIANTS, "uniform")}
    clusters = []
    for annotated in descriptions:
        city, utterance = read_annotated(annotated, find(annotated.map), "parsed")
        for name, switches in VARIANTS.items():
            model = replace(preset("bayes"), **switches)
            beliefs = beliefs_of(annotated, utterance, city, model, None)
            for target, place in annotated.targets.items():
                row, column = city.grid.cell_at(place.x_m, place.y_m)
                belief, uniform = in_area(beliefs[target], city.grid, annotated.area_m)
                mixed = 0.99 * belief + 0.01 * uniform
                scores[name].append(float(np.log(mixed[row, column])))
                if name == "all":
                    clusters.append(annotated.configuration)
                    scores["uniform"].append(float(np.log(uniform[row, column])))
    rng = np.random.default_rng(0)
    print(f"{len(clusters)} targets, mean log score with 1 % of the uniform belief, nats")
    for name, values in scores.items():
        mean, (low, high) = np.mean(values), clustered_interval(values, clusters, rng=rng)
        print(f"  {name:14} {mean:7.3f} [{low:.3f}, {high:.3f}]")
    for name in list(VARIANTS)[1:]:
        less = np.array(scores["all"]) - np.array(scores[name])
        mean, (low, high) = np.mean(less), clustered_interval(less, clusters, rng=rng)
        print(f"  all - {name:14} {mean:+.3f} [{low:+.3f}, {high:+.3f}]")


if __name__ == "__main__":
    main()
