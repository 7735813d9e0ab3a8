"""Compare the planners' rewards on the same beliefs, places and starts, and print a table.

Run: python benchmarks/search_quality.py [FILE.jsonl ...] [--model sloop-m4] [--starts 8]
         [--planners greedy,fast:1000] [--out FILE]

Without files it takes the bundled examples. Beliefs come from the gold relations; one target is
searched at a time. A planner is a name, optionally with `:sims` and `:rollout`. Starts are keyed
on description, target and number, so that all planners meet the same ones. Intervals are
bootstrapped over configurations.
"""

from __future__ import annotations

import argparse
import time
import zlib
from pathlib import Path

import numpy as np

from sloop_ppl.eval import bundled_examples, read_descriptions
from sloop_ppl.inference import infer_description
from sloop_ppl.language import Description
from sloop_ppl.maps import load_map
from sloop_ppl.rng import child
from sloop_ppl.search import SearchConfig, run_search

PLANNERS = "random,pouct:1000,greedy,fast:1000:published,fast:1000,fast:10000,fast:100000"


def beliefs_of(files, model, maps):
    """Return (key, configuration, city, belief, place) of every target with gold relations."""
    scenes = read_descriptions(files, maps) if files else bundled_examples()
    told = []
    for scene in scenes:
        city = maps(scene.map)
        said = Description(scene.text, scene.map, scene.objects, scene.relations)
        truth = {t: (p.x_m, p.y_m) for t, p in scene.targets.items()}
        posterior, _ = infer_description(said, city, model, truth=truth)
        for target, place in scene.targets.items():
            belief = np.asarray(posterior.belief(target))
            key = f"{scene.id}/{target}"
            told.append((key, scene.configuration, city, belief, (place.x_m, place.y_m)))
    return told


def trials(cases, planner, starts, settings):
    """Return discounted reward, success and seconds a step of every case and start."""
    name, *rest = planner.split(":")
    sims = int(rest[0]) if rest else 1000
    rollout = rest[1] if len(rest) > 1 else None
    config = SearchConfig(sims=sims, rollout=rollout, **settings)
    told = []
    for key, _, city, belief, place in cases:
        for start in range(starts):
            rng = child(np.random.default_rng(zlib.crc32(key.encode())), "start", start)
            begun = time.perf_counter()
            episode = run_search(
                {"T": belief}, city, {"T": place}, planner=name, config=config, rng=rng
            )
            seconds = (time.perf_counter() - begun) / episode.steps
            told.append((episode.discounted_return, float(episode.found), seconds))
    return np.array(told).reshape(len(cases), starts, 3)


def interval(values, clusters, rng, draws=2000):
    """Return the mean and its 95 % interval, bootstrapped over clusters."""
    names = sorted(set(clusters))
    sums = np.array(
        [sum(v for v, c in zip(values, clusters, strict=True) if c == n) for n in names]
    )
    counts = np.array([clusters.count(n) for n in names])
    drawn = rng.integers(len(names), size=(draws, len(names)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    return float(np.mean(values)), *np.percentile(means, [2.5, 97.5])


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--model", default="sloop-m4")
    parser.add_argument("--planners", default=PLANNERS)
    parser.add_argument("--starts", type=int, default=8)
    parser.add_argument("--range", type=float, default=3.0)
    parser.add_argument("--fov", type=float, default=90.0)
    parser.add_argument("--against", default="greedy")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    known = {}

    def maps(name):
        return known.setdefault(name, load_map(name))

    cases = beliefs_of(options.files, options.model, maps)
    clusters = [f"{case[2].name}/{case[1]}" for case in cases]
    settings = {"sensor_range_cells": options.range, "fov_deg": options.fov}
    lines = [
        (
            f"{options.model}, range {options.range:g}, fan {options.fov:g}: {len(cases)} targets "
            f"x {options.starts} starts, {len(set(clusters))} configurations"
        ),
        f"| planner | discounted reward | minus {options.against} | found | ms a step |",
        "| --- | --- | --- | --- | --- |",
    ]
    print("\n".join(lines), flush=True)
    results = {}
    planners = options.planners.split(",")
    for planner in sorted(planners, key=lambda p: p != options.against):
        told = results[planner] = trials(cases, planner, options.starts, settings)
        rng = np.random.default_rng(0)
        mean, low, high = interval(told[..., 0].mean(axis=1).tolist(), clusters, rng)
        cells = [planner, f"{mean:.0f} [{low:.0f}, {high:.0f}]"]
        paired = "-"
        if options.against in results and planner != options.against:
            gap = (told - results[options.against])[..., 0].mean(axis=1).tolist()
            mean, low, high = interval(gap, clusters, np.random.default_rng(0))
            paired = f"{mean:+.0f} [{low:+.0f}, {high:+.0f}]"
        cells += [paired, f"{told[..., 1].mean():.2f}", f"{np.median(told[..., 2]) * 1e3:.2f}"]
        lines.append("| " + " | ".join(cells) + " |")
        print(lines[-1], flush=True)
    if options.out:
        options.out.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
