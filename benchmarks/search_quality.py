"""Compare the planners' rewards on the same beliefs, places and starts, and print a table.

Run: python benchmarks/search_quality.py [FILE.jsonl ...] [--model sloop-m4] [--starts 8]
         [--planners greedy,fast:1000,fast:100000@2] [--out FILE] [--quick]

Without files it takes the bundled examples. Beliefs come from the gold relations; one target is
searched at a time, or with --together all targets of a description. A planner is a name,
optionally with `:sims`, `:rollout` and `@starts`, which is how many of the starts it takes.
Starts are keyed on description, target and number, so that all planners meet the same ones.
With --imagined the targets are where the beliefs draw them: what planning is worth when the
belief is right; with --slip moves may slip. Intervals are bootstrapped over configurations. Every
row is printed, and written, as soon as it is known. --quick shows that the comparison runs: few
targets, one start and few simulations of every planner.
"""

from __future__ import annotations

import argparse
import os
import time
import zlib
from pathlib import Path

import numpy as np

from sloop_ppl.eval import bundled_examples, read_descriptions
from sloop_ppl.inference import infer_description
from sloop_ppl.language import Description
from sloop_ppl.maps import load_map
from sloop_ppl.planning import SearchConfig, run_search
from sloop_ppl.rng import child

PLANNERS = (
    "greedy,random,pouct:1000@1,fast:1000:published,fast:10000:published@2,"
    "fast:1000,fast:10000,fast:100000@2"
)
QUICK = "greedy,random,pouct:10,fast:10:published@1,fast:10"


def beliefs_of(files, model, maps):
    """Return (key, configuration, city, {target: belief}, {target: place}) of every description."""
    descriptions = read_descriptions(files, maps) if files else bundled_examples()
    cases = []
    for annotated in descriptions:
        city = maps(annotated.map)
        said = Description(annotated.text, annotated.map, annotated.objects, annotated.relations)
        places = {t: (p.x_m, p.y_m) for t, p in annotated.targets.items()}
        posterior, _ = infer_description(said, city, model, truth=places)
        beliefs = {target: np.asarray(posterior.belief(target)) for target in places}
        cases.append((annotated.id, annotated.configuration, city, beliefs, places))
    return cases


def one_by_one(descriptions):
    """Return every target as a case of its own."""
    return [
        (f"{key}/{target}", configuration, city, {target: belief}, {target: places[target]})
        for key, configuration, city, beliefs, places in descriptions
        for target, belief in beliefs.items()
    ]


def drawn(beliefs, city, rng):
    """Return a place for each target, drawn from its belief at cells whose middle is on the map."""
    grid, places = city.grid, {}
    inside = np.array([[grid.contains(x, y) for x in grid.x_m] for y in grid.y_m]).ravel()
    for target, belief in beliefs.items():
        weights = belief.ravel() * inside
        cell = int(rng.choice(len(weights), p=weights / weights.sum()))
        places[target] = grid.centre_of(*divmod(cell, grid.n_cols))
    return places


def trials(cases, planner, starts, settings, imagined):
    """Return discounted reward, success and CPU seconds a step of every case and start."""
    name, *rest = planner.split(":")
    sims = int(rest[0]) if rest else 1000
    rollout = rest[1] if len(rest) > 1 else None
    config = SearchConfig(sims=sims, rollout=rollout, **settings)
    results = []
    for key, _, city, beliefs, places in cases:
        for start in range(starts):
            seed = np.random.default_rng(zlib.crc32(key.encode()))
            rng = child(seed, "start", start)
            where = drawn(beliefs, city, child(seed, "place", start)) if imagined else places
            begun = time.process_time()
            episode = run_search(beliefs, city, where, planner=name, config=config, rng=rng)
            seconds = (time.process_time() - begun) / episode.steps
            results.append((episode.discounted_return, float(episode.found), seconds))
    return np.array(results).reshape(len(cases), starts, 3)


def interval(values, clusters, draws=2000):
    """Return the mean and its 95 % interval, bootstrapped over clusters."""
    rng = np.random.default_rng(0)
    names = sorted(set(clusters))
    sums = np.array(
        [sum(v for v, c in zip(values, clusters, strict=True) if c == n) for n in names]
    )
    counts = np.array([clusters.count(n) for n in names])
    drawn = rng.integers(len(names), size=(draws, len(names)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    return float(np.mean(values)), *np.percentile(means, [2.5, 97.5])


def row(planner, results, base, clusters):
    """Return a row of the table: the reward, and what is gained on the other's same starts."""
    mean, low, high = interval(results[..., 0].mean(axis=1).tolist(), clusters)
    paired = ""
    if base is not None:
        gap = (results - base[:, : results.shape[1]])[..., 0].mean(axis=1).tolist()
        paired = "{:+.0f} [{:+.0f}, {:+.0f}]".format(*interval(gap, clusters))
    cells = (
        planner,
        str(results.shape[1]),
        f"{mean:.0f} [{low:.0f}, {high:.0f}]",
        paired,
        f"{results[..., 1].mean():.2f}",
        f"{np.median(results[..., 2]) * 1e3:.2g}",
    )
    return "| " + " | ".join(cells) + " |"


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--model", default="sloop-m4")
    parser.add_argument("--planners", default=PLANNERS)
    parser.add_argument("--starts", type=int, default=8)
    parser.add_argument("--range", type=float, default=3.0)
    parser.add_argument("--fov", type=float, default=90.0)
    parser.add_argument("--slip", type=float, default=0.0, help="rate of each kind of slip")
    parser.add_argument("--against", default="greedy")
    parser.add_argument("--together", action="store_true")
    parser.add_argument("--imagined", action="store_true")
    parser.add_argument("--every", type=int, default=1, help="take every n-th case alone")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    options = parser.parse_args()
    if options.quick:
        options.planners, options.starts, options.every = QUICK, 1, 32
    known = {}

    def maps(name):
        return known.setdefault(name, load_map(name))

    def say(line):
        print(line, flush=True)
        if options.out:
            with options.out.open("a", encoding="utf-8") as file:
                file.write(line + "\n")

    descriptions = beliefs_of(options.files, options.model, maps)
    cases = (descriptions if options.together else one_by_one(descriptions))[:: options.every]
    clusters = [f"{case[2].name}/{case[1]}" for case in cases]
    slips = dict.fromkeys(("stay_rate", "overshoot_rate", "overturn_rate"), options.slip)
    settings = {"sensor_range_cells": options.range, "fov_deg": options.fov, **slips}
    say(
        f"{options.model}, range {options.range:g}, fan {options.fov:g}: {len(cases)} "
        f"{'descriptions' if options.together else 'targets'}, "
        f"{len(set(clusters))} configurations"
        f"{', places drawn from the beliefs' if options.imagined else ''}"
        f"{f', slips {options.slip:g}' if options.slip else ''}; "
        f"{os.cpu_count()} cores, shared with other work"
    )
    say(
        f"| planner | starts | discounted reward | minus {options.against} | found "
        "| CPU ms a step |"
    )
    say("| --- | --- | --- | --- | --- | --- |")
    base = None
    planners = options.planners.split(",")
    for planner in sorted(planners, key=lambda p: p != options.against):
        name, _, starts = planner.partition("@")
        results = trials(cases, name, int(starts or options.starts), settings, options.imagined)
        say(row(name, results, base, clusters))
        if name == options.against:
            base = results


if __name__ == "__main__":
    main()
