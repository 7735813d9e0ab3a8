"""Measure predicting building fronts against the figures it has to meet.

Run: python benchmarks/bench_frames.py [MAP] [--predictor ego-ctx] [--rounds 15] [--quick]

MAP is an OpenStreetMap extract (.osm, .osm.pbf) or a map file (.geojson), of which up to 1,000
buildings are predicted at once; without it 1,000 of the bundled maps are, some several times. One
prediction is timed building by building on a bundled map and on MAP. Each is made anew, nothing of
it kept from before but the index of its map, whose making the first prediction of a map includes.
The reference is the bare network on the same pictures, drawn beforehand and not turned. One
thread; times are the least of the rounds, of the wall and of the processor, which a busy machine
lengthens less; for one prediction the mean over buildings, with the longest in brackets.
--quick shows that the benchmark runs: few buildings, one round.
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Callable
from itertools import cycle, islice
from pathlib import Path

import numpy as np
import torch

from sloop_ppl.maps import CityMap, bundled_maps, load_map
from sloop_ppl.maps.osm import import_osm
from sloop_ppl.models.frames import (
    TrainedFrames,
    choices_of,
    load_weights,
    padded_choices,
    pictures_of,
    predict_frames,
    shipped_weights,
)

MANY = 1000
SINGLES = 40


def main() -> None:
    """Print every figure, with what it has to meet."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("map", nargs="?", type=Path, help="an extract or a map file")
    options.add_argument("--predictor", default="ego-ctx", choices=("ego-ctx", "ctx", "ego"))
    options.add_argument("--rounds", type=int, default=15)
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    given = options.parse_args()
    rounds, singles, many = (1, 4, 10) if given.quick else (given.rounds, SINGLES, MANY)
    torch.set_num_threads(1)
    load = " ".join(f"{x:.1f}" for x in os.getloadavg())
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {load}, torch {torch.__version__}")
    trained = load_weights(shipped_weights(given.predictor))
    print(f"{'ms':44} {'wall':>15} {'processor':>15} {'network alone':>14} {'ratio':>6}  limit")
    bundled = [load_map(name) for name in bundled_maps()]
    bench_one(trained, bundled[1], singles, rounds)
    if given.map is None:
        bench_many(trained, [(city, many // len(bundled)) for city in bundled], rounds)
        return
    city = read_map(given.map)
    bench_one(trained, city, singles, rounds)
    bench_many(trained, [(city, min(many, len(city.of_kind("building"))))], rounds)


def read_map(path: Path) -> CityMap:
    """Return a map file, or all of an extract."""
    if path.suffix == ".geojson":
        return load_map(path)
    return import_osm(path, everything=True)[0]


def bench_one(trained: TrainedFrames, city: CityMap, count: int, rounds: int) -> None:
    """Predict buildings one by one, after the first of a map that was just read."""
    ids = [building.id for building in city.of_kind("building")][:count]
    fresh = [city.with_grid(city.grid) for _ in range(3)]
    firsts = [timed(lambda a=one: predict_frames(trained, a, ids[:1]))[0] for one in fresh]
    whole = least([lambda i=i: predict_frames(trained, city, [i]) for i in ids], rounds)
    alone = least([bare(trained, city, [i]) for i in ids], rounds)
    show(f"one of {city.name}", whole, alone, 2.0)
    print(f"{f'  the first of {city.name}':44} {min(firsts):15.2f}")


def bench_many(trained: TrainedFrames, some: list[tuple[CityMap, int]], rounds: int) -> None:
    """Predict many buildings at once, on each map so many."""
    lots = [
        (city, list(islice(cycle(b.id for b in city.of_kind("building")), count)))
        for city, count in some
    ]
    forward = [bare(trained, city, ids) for city, ids in lots]
    whole = least([lambda: [predict_frames(trained, city, ids) for city, ids in lots]], rounds)
    alone = least([lambda: [work() for work in forward]], rounds)
    where = lots[0][0].name if len(lots) == 1 else f"{len(lots)} bundled maps"
    show(f"{sum(len(ids) for _, ids in lots)} of {where}", whole, alone, 500.0)


def bare(trained: TrainedFrames, city: CityMap, ids: list[str]) -> Callable[[], object]:
    """Return the work of the network alone, in batches that stay in the processor's cache."""
    pictures = pictures_of(city, ids, trained.network.shape.view)
    tables = [torch.from_numpy(a) for a in (pictures, *padded_choices(choices_of(city, ids)))]
    batches = list(zip(*(table.split(128) for table in tables), strict=True))

    def forward() -> object:
        with torch.inference_mode():
            return [trained.network(*batch) for batch in batches]

    return forward


def least(works: list[Callable[[], object]], rounds: int) -> np.ndarray:
    """Return the least wall and processor time of each work, milliseconds, shape (2, W)."""
    times = [[timed(work) for work in works] for _ in range(rounds)]
    return np.min(times, axis=0).T


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Return the wall and processor time of some work, milliseconds."""
    wall, processor = time.perf_counter(), time.process_time()
    work()
    return 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor)


def show(what: str, whole: np.ndarray, alone: np.ndarray, limit: float) -> None:
    """Print a row: the mean over works and, where there are several, the longest."""
    mean, reference = whole.mean(1), alone.mean(1)
    longest = [f" ({t:.2f})" if whole.shape[1] > 1 else "" for t in whole.max(1)]
    cells = [f"{f'{t:.2f}{more}':>15}" for t, more in zip(mean, longest, strict=True)]
    met = "met" if mean[0] < limit else "NOT MET"
    ratio = mean[1] / reference[1]
    print(f"{what:44} {' '.join(cells)} {reference[1]:14.2f} {ratio:6.1f}  {limit:g}: {met}")


if __name__ == "__main__":
    main()
