"""Measure inference against the figures it has to meet, as ratios within one run.

Run: python benchmarks/bench_inference.py [--rounds 30]

The input: three frame relations on the bundled Cleveland map, "behind Velvet Dog, left of Ivy, in
front of Rumor", under the model ``bayes``. The reference is one function of bare torch that does
the same sums: log space, frames in closed form, no Pyro. One thread; times are the least of the
rounds, of the wall and of the processor, which a busy machine lengthens less. Memory is the growth
of the process's peak (Linux), in a process of its own.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from scipy.special import ive

import sloop_ppl as sloop
from sloop_ppl.inference import ENGINES, importance, infer_description
from sloop_ppl.inference.batch import infer_batch
from sloop_ppl.language import Description, SpatialRelation, TargetObject
from sloop_ppl.maps import CityMap
from sloop_ppl.maps.city import FIELDS
from sloop_ppl.models import ground_description, preset

SAID = (("behind", "VelvetDog"), ("left", "Ivy"), ("front", "Rumor"))
CAR = "GreenToyota"
_ORDERS = np.array([1, *range(2, 50, 2)])


def main() -> None:
    """Print every figure, with what it has to meet."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=30)
    options.add_argument("--large", action="store_true", help="only 401 x 401, printed as numbers")
    given = options.parse_args()
    torch.set_num_threads(1)
    if given.large:
        print(*measure_large(given.rounds))
        return
    load = " ".join(f"{x:.1f}" for x in os.getloadavg())
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {load}, torch {torch.__version__}")
    city = sloop.load_map("cleveland")
    bench_one(city, given.rounds)
    bench_batch(city, max(3, given.rounds // 10))
    large = [sys.executable, __file__, "--large", "--rounds", "5"]
    wall, cpu, mib, first = subprocess.run(
        large, capture_output=True, text=True, check=True
    ).stdout.split()
    print(
        f"401 x 401: {wall} ms wall, {cpu} ms processor (150), {mib} MB (200); {first} ms "
        "processor for the first description of these grounds"
    )
    bench_agreement(city)


def description(city: CityMap) -> Description:
    """Return the input of every benchmark."""
    relations = tuple(SpatialRelation(CAR, word, (ground,)) for word, ground in SAID)
    return Description("", city.name, (TargetObject(CAR),), relations)


def bench_one(city: CityMap, rounds: int) -> None:
    """Compare the exact engine on 41 x 41 cells with the reference."""
    said = description(city)

    def engine() -> Any:
        return infer_description(said, city)[0].belief(CAR)

    tables = _tables(city, said)

    def reference() -> Any:
        return bare_torch(*tables)

    apart = 0.5 * np.abs(engine().reshape(-1) - reference().numpy()).sum()
    first, second = least(engine, rounds), least(reference, rounds)
    print(
        f"41 x 41, 3 frame relations: exact {first[0]:.1f} ms wall, {first[1]:.1f} ms processor "
        f"(10); bare torch {second[0]:.2f} and {second[1]:.2f} ms; ratio {first[0] / second[0]:.1f}"
        f" and {first[1] / second[1]:.1f} (6); total variation {apart:.1e}"
    )


def _tables(city: CityMap, said: Description) -> tuple[Any, ...]:
    """Return what the reference is told of the map: bearings, distances, widths, frames."""
    model = preset("bayes")
    terms = ground_description(said, city, model)[CAR]
    prior: Any = model.frame_prior
    bearing = torch.stack([t.bearing_rad - t.offset_rad for t in terms])
    distance = torch.stack([t.distance_m for t in terms])
    width = torch.tensor([[min(20.0, max(5.0, t.extent_m))] for t in terms]).double()
    middle = torch.stack([t.at_centroid for t in terms])
    frames = [prior(term) for term in terms]
    parts = max(len(frame.parts) for frame in frames)
    numbers = torch.zeros(3, len(terms), parts, 1).double()
    for i, frame in enumerate(frames):
        for j, part in enumerate(frame.parts):
            numbers[:, i, j, 0] = torch.tensor([part.mean_rad, part.kappa, part.weight])
    lapse = torch.tensor([[frame.lapse] for frame in frames]).double()
    weights = torch.tensor([part.weight for part in model.components]).double()
    return bearing, distance, width, middle, numbers, lapse, weights


def bare_torch(
    bearing: torch.Tensor,
    distance: torch.Tensor,
    width: torch.Tensor,
    middle: torch.Tensor,
    frames: torch.Tensor,
    lapse: torch.Tensor,
    weights: torch.Tensor,
) -> torch.Tensor:
    """Return the belief under ``bayes`` in one vectorised log-space function, shape (S,)."""
    mean, kappa, share = frames
    x = bearing[:, None] - mean
    ratios = torch.from_numpy(
        ive(_ORDERS, kappa.numpy()[..., None]) / ive(0, kappa.numpy()[..., None])
    ).unbind(-1)
    factor = 1 / math.pi + ratios[0] * torch.cos(x) / 2
    for m in range(1, 25):
        sign = 1 if m % 2 else -1
        factor = factor + sign * 2 / math.pi * ratios[m] * torch.cos(2 * m * x) / (4 * m * m - 1)
    factor = (share * factor.clamp_min(1e-9)).sum(1) + lapse / math.pi
    factor = torch.where(middle, 1 / math.pi, factor)

    def normal(log_p: torch.Tensor) -> torch.Tensor:
        return log_p - torch.logsumexp(log_p, -1, keepdim=True)

    product = normal(normal(factor.log() - distance**2 / (2 * width**2)).sum(0))
    at = torch.logsumexp(normal(-(distance**2) / 50), 0) - math.log(len(distance))
    near = torch.logsumexp(normal(-(distance**2) / 450), 0) - math.log(len(distance))
    kept = weights[[0, 2, 3]]  # without frame words nothing is left: that component is skipped
    return torch.softmax(
        torch.logsumexp(torch.stack([product, at, near]) + kept.log()[:, None], 0), -1
    )


def bench_batch(city: CityMap, rounds: int) -> None:
    """Infer from 200 descriptions of three relations in one padded call."""
    grounds = [m.id for m in city.landmarks if m.name][:40]
    words = ("front", "behind", "left", "right", "near", "north", "at", "southwest")
    many = []
    for i in range(200):
        relations = tuple(
            SpatialRelation(
                CAR, words[(i + 3 * j) % 8], (grounds[(7 * i + 11 * j) % len(grounds)],)
            )
            for j in range(3)
        )
        many.append(Description("", city.name, (TargetObject(CAR),), relations))
    wall, cpu = least(lambda: infer_batch(many, city), rounds)
    one, _ = least(lambda: [infer_description(said, city) for said in many[:20]], rounds)
    print(
        f"200 descriptions in one batch: {wall / 200:.2f} ms each, {cpu / 200:.2f} ms processor "
        f"(2.5); one at a time {one / 20:.2f} ms"
    )


def measure_large(rounds: int) -> tuple[str, ...]:
    """Return wall and processor milliseconds and MB of one inference on 401 x 401 cells.

    The last number is the processor time when the map's distances and bearings are not there yet.
    """
    city = sloop.load_map("cleveland", cell_m=0.5)
    said = description(city)
    small = sloop.load_map("cleveland")
    infer_description(said, small)[0].belief(CAR)
    ground_fields = ground_description(said, city, preset("bayes"))[CAR]
    for term in ground_fields:  # distances and bearings belong to the map, which keeps them
        _ = term.distance_m, term.bearing_rad
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew
    before = _peak_mib()
    wall, cpu = least(lambda: infer_description(said, city)[0].belief(CAR), rounds)
    mib = _peak_mib() - before
    FIELDS.clear()
    started = time.process_time()
    infer_description(said, city)
    first = 1e3 * (time.process_time() - started)
    return f"{wall:.0f}", f"{cpu:.0f}", f"{mib:.0f}", f"{first:.0f}"


def _peak_mib() -> float:
    status = Path("/proc/self/status").read_text()
    return next(float(x.split()[1]) for x in status.splitlines() if x.startswith("VmHWM")) / 1024


def bench_agreement(city: CityMap) -> None:
    """Print how far the engines are from exact."""
    said = description(city)
    told = sloop.inference.compare(
        said, city, engines=("exact", "enumerate"), rng=np.random.default_rng(0)
    )
    print(told.to_markdown())
    right = infer_description(said, city)[0].belief(CAR)
    for draws, limit in ((1_000, 0.06), (10_000, 0.02)):
        name = f"importance-{draws}"
        ENGINES.add(name, partial(importance, draws=draws))
        apart = []
        for seed in range(5):
            rough, _ = infer_description(said, city, engine=name, rng=np.random.default_rng(seed))
            apart.append(0.5 * np.abs(rough.belief(CAR) - right).sum())
        print(f"importance, {draws} draws: total variation at most {max(apart):.4f} ({limit})")


def least(run: Callable[[], Any], rounds: int) -> tuple[float, float]:
    """Return the least wall and processor time of one run, milliseconds, after a warm-up."""
    run()
    wall, cpu = [], []
    for _ in range(rounds):
        started, spent = time.perf_counter(), time.process_time()
        run()
        cpu.append(time.process_time() - spent)
        wall.append(time.perf_counter() - started)
    return min(wall) * 1e3, min(cpu) * 1e3


if __name__ == "__main__":
    main()
