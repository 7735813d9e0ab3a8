"""Measure inference against the figures it has to meet, as ratios within one run.

Run: python benchmarks/bench_inference.py [--rounds 30] [--quick]

The input: three frame relations on the bundled Cleveland map, "behind Velvet Dog, left of Ivy, in
front of Rumor", under the model ``bayes``. The reference is one function of bare torch that does
the same sums and no more: every part of every frame in one table, in closed form, no Pyro. One
thread. Contenders take turns, one run each a round; times are medians of the rounds and, in
brackets, the least. Processor time is what has to meet a limit: a busy machine lengthens the wall
time more. Memory is the growth of the process's peak (Linux), in a process of its own. --quick
shows that the benchmark runs: few rounds, a small batch, few draws.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import sloop_ppl as sloop
from sloop_ppl.inference import Importance, infer_batch, infer_description
from sloop_ppl.language import Description, SpatialRelation, TargetObject
from sloop_ppl.maps import CityMap
from sloop_ppl.maps.city import FIELDS
from sloop_ppl.models import ObservationModel, ground_description, preset

SAID = (("behind", "VelvetDog"), ("left", "Ivy"), ("front", "Rumor"))
CAR = "GreenToyota"


def main() -> None:
    """Print every figure, with what it has to meet."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=30)
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    options.add_argument("--large", action="store_true", help="only 401 x 401, printed as JSON")
    given = options.parse_args()
    rounds = 2 if given.quick else given.rounds
    torch.set_num_threads(1)
    if given.large:
        print(json.dumps(measure_large(given.rounds)))
        return
    load = " ".join(f"{x:.1f}" for x in os.getloadavg())
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {load}, torch {torch.__version__}")
    print(f"{f'ms, median (least) of {rounds} rounds':44} {'processor':>16} {'wall':>16}  limit")
    city = sloop.load_map("cleveland")
    bench_one(city, rounds)
    bench_batch(city, max(2, rounds // 5), 20 if given.quick else 200)
    bench_large(max(1, rounds // 4))
    if given.quick:
        bench_agreement(city, 1, {1_000: 0.06})
    else:
        bench_agreement(city, 5, {1_000: 0.06, 10_000: 0.02})


def description(city: CityMap) -> Description:
    """Return the input of every benchmark."""
    relations = tuple(SpatialRelation(CAR, word, (ground,)) for word, ground in SAID)
    return Description("", city.name, (TargetObject(CAR),), relations)


def bench_one(city: CityMap, rounds: int) -> None:
    """Compare the exact engine on 41 x 41 cells with the reference."""
    engine, reference = contenders(city)
    apart = 0.5 * np.abs(engine().reshape(-1) - reference().numpy()).sum()
    if not apart < 1e-9:
        raise SystemExit(
            f"Bare torch is {apart:.1e} in total variation from the engine; it no longer computes "
            "what `bayes` does, so mend `bare_torch`"
        )
    took = interleaved({"engine": engine, "reference": reference}, rounds)
    show("exact, 41 x 41, 3 frame relations", took["engine"], 5)
    show("bare torch", took["reference"])
    times = took["engine"] / took["reference"]
    least = took["engine"].min(1) / took["reference"].min(1)
    cells = [f"{f'{a:.2f} ({b:.2f})':>16}" for a, b in zip(np.median(times, 1), least, strict=True)]
    print(f"{'exact / bare torch':44} {' '.join(cells)}  {limit_text(np.median(times[0]), 3)}")
    print(f"total variation between exact and bare torch: {apart:.1e}")


def contenders(city: CityMap) -> tuple[Callable[[], Any], Callable[[], Tensor]]:
    """Return what computes the belief in the car's cell: the exact engine, and the reference."""
    said = description(city)
    model = preset("bayes")
    inputs = ReferenceInputs.of(city, said, model)
    return (
        lambda: infer_description(said, city)[0].belief(CAR),
        lambda: bare_torch(inputs, model),
    )


@dataclass(frozen=True)
class ReferenceInputs:
    """What the reference computes from, for R relations, S cells and all P parts of R fronts.

    Parameters
    ----------
    bearing_rad
        Direction of each cell from the ground less the relation's offset, radians, shape (R, S).
    off_m
        Distance of each cell from the ground, metres, shape (R, S).
    defined
        Where there is a direction, shape (R, S).
    width_m
        Width of the fall-off with distance, metres, shape (R, 1).
    whose
        Relation of each part, shape (P,).
    mean_rad, kappa
        Mean direction and concentration of each part, shape (P, 1).
    share
        Weight of each part in the front of its relation, else 0, shape (R, P).
    lapse
        Probability that a front is anywhere, shape (R, 1).
    """

    bearing_rad: Tensor
    off_m: Tensor
    defined: Tensor
    width_m: Tensor
    whose: Tensor
    mean_rad: Tensor
    kappa: Tensor
    share: Tensor
    lapse: Tensor

    @classmethod
    def of(cls, city: CityMap, said: Description, model: ObservationModel) -> ReferenceInputs:
        """Look up distances and bearings, and predict the fronts."""
        terms = ground_description(said, city, model)[CAR]
        likelihood: Any = model.likelihood
        widths = [
            likelihood.directed_street_m if term.is_line else likelihood.directed_m
            for term in terms
        ]
        frame_priors = [model.frame_prior(term) for term in terms]
        parts = [
            (i, part) for i, frame_prior in enumerate(frame_priors) for part in frame_prior.parts
        ]
        share = torch.zeros(len(terms), len(parts), dtype=torch.float64)
        for p, (i, part) in enumerate(parts):
            share[i, p] = part.weight
        return cls(
            bearing_rad=torch.stack([term.outward_rad - term.offset_rad for term in terms]),
            off_m=torch.stack([term.off_m for term in terms]),
            defined=torch.stack([term.has_direction for term in terms]),
            width_m=_column(widths),
            whose=torch.tensor([i for i, _ in parts]),
            mean_rad=_column([part.mean_rad for _, part in parts]),
            kappa=_column([part.kappa for _, part in parts]),
            share=share,
            lapse=_column([frame_prior.lapse for frame_prior in frame_priors]),
        )


def _column(numbers: list[float]) -> Tensor:
    return torch.tensor(numbers, dtype=torch.float64)[:, None]


@torch.inference_mode()
def bare_torch(inputs: ReferenceInputs, model: ObservationModel) -> Tensor:
    """Return the belief that frame relations alone give under ``bayes``, shape (S,).

    Notes
    -----
    Of the two components only the product applies: without frame relations nothing is left for
    the other. A von Mises part of concentration c gives I_0(R) / I_0(c) exp(-kappa) with
    R^2 = kappa^2 + c^2 + 2 kappa c cos x, all parts in one table without padding. With i0e for
    I_0 the exponent R - c - kappa lies between -2 min(kappa, c) and 0, so parts are summed as
    they are; phrases are multiplied as logarithms.
    """
    likelihood: Any = model.likelihood
    kappa = torch.tensor(likelihood.kappa_frame, dtype=torch.float64)
    x = inputs.bearing_rad[inputs.whose] - inputs.mean_rad
    both = (kappa**2 + inputs.kappa**2 + 2 * kappa * inputs.kappa * torch.cos(x)).sqrt()
    parts = torch.special.i0e(both) * torch.exp(both - inputs.kappa - kappa)
    anywhere = torch.special.i0e(kappa)
    angular = (inputs.share / torch.special.i0e(inputs.kappa).T) @ parts + inputs.lapse * anywhere
    angular = torch.where(inputs.defined, angular, anywhere).log()
    tail = likelihood.tail
    radial = -0.5 * (tail + 1) * torch.log1p(inputs.off_m**2 / (tail * inputs.width_m**2))
    meant = torch.log_softmax(angular + radial, -1)
    idle = torch.tensor(math.log(model.lapse / meant.shape[-1]), dtype=torch.float64)
    phrases = torch.logaddexp(meant + math.log1p(-model.lapse), idle)
    return torch.softmax(phrases.sum(0) / len(phrases) ** model.temper, -1)


def bench_batch(city: CityMap, rounds: int, count: int) -> None:
    """Infer from many descriptions of three relations, in one padded call and one by one."""
    grounds = [m.id for m in city.landmarks if m.name][:40]
    words = ("front", "behind", "left", "right", "near", "north", "at", "southwest")
    many = []
    for i in range(count):
        relations = tuple(
            SpatialRelation(
                CAR, words[(i + 3 * j) % 8], (grounds[(7 * i + 11 * j) % len(grounds)],)
            )
            for j in range(3)
        )
        many.append(Description("", city.name, (TargetObject(CAR),), relations))
    some = many[:20]
    took = interleaved(
        {
            "batch": lambda: infer_batch(many, city),
            "singly": lambda: [infer_description(said, city)[0].belief(CAR) for said in some],
        },
        rounds,
    )
    show(f"{count} descriptions in one batch, each", took["batch"] / count, 2)
    show("descriptions one at a time, each", took["singly"] / len(some))


def bench_large(rounds: int) -> None:
    """Report time and memory on 401 x 401 cells, measured in a process of its own."""
    command = [sys.executable, __file__, "--large", "--rounds", str(rounds)]
    printed = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    found = json.loads(printed)
    show("exact, 401 x 401", np.array(found["engine"]), 60)
    show("bare torch, 401 x 401", np.array(found["reference"]))
    print(
        f"memory of exact, 401 x 401: {found['mb']:.0f} MB, limit {limit_text(found['mb'], 120)}; "
        f"first description of these grounds: {found['first']:.0f} ms processor"
    )


def measure_large(rounds: int) -> dict[str, Any]:
    """Return the times of one inference on 401 x 401 cells and how far memory's peak grows in six.

    The last number is the processor time when the map's distances and bearings are not there yet.
    """
    city = sloop.load_map("cleveland", cell_m=0.5)
    small = sloop.load_map("cleveland")
    said = description(city)
    infer_description(said, small)[0].belief(CAR)
    for term in ground_description(said, city, preset("bayes"))[CAR]:
        _ = term.distance_m, term.bearing_rad  # these belong to the map, which keeps them
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew
    before = _peak_mb()
    for _ in range(6):  # what one leaves behind may stand in the way of the next
        infer_description(said, city)[0].belief(CAR)
    mb = _peak_mb() - before
    engine, reference = contenders(city)
    took = interleaved({"engine": engine, "reference": reference}, rounds)
    FIELDS.clear()
    started = time.process_time()
    infer_description(said, city)
    first = 1e3 * (time.process_time() - started)
    return {**{name: times.tolist() for name, times in took.items()}, "mb": mb, "first": first}


def _peak_mb() -> float:
    status = Path("/proc/self/status").read_text()
    return next(float(x.split()[1]) for x in status.splitlines() if x.startswith("VmHWM")) / 1024


def bench_agreement(city: CityMap, seeds: int, limits: Mapping[int, float]) -> None:
    """Print how far the engines are from exact; of importance, by number of draws."""
    said = description(city)
    compared = sloop.inference.compare(
        said, city, engines=("exact", "enumerate"), rng=np.random.default_rng(0)
    )
    print(compared.to_markdown())
    right = infer_description(said, city)[0].belief(CAR)
    for draws, limit in limits.items():
        apart = []
        for seed in range(seeds):
            rough, _ = infer_description(
                said, city, engine=Importance(draws=draws), rng=np.random.default_rng(seed)
            )
            apart.append(0.5 * np.abs(rough.belief(CAR) - right).sum())
        print(
            f"importance, {draws} draws: total variation {max(apart):.4f} in the worst of {seeds} "
            f"seeds, limit {limit_text(max(apart), limit)}"
        )


def interleaved(
    contenders: Mapping[str, Callable[[], Any]], rounds: int
) -> dict[str, NDArray[np.float64]]:
    """Return processor and wall milliseconds of each contender in each round, shape (2, rounds).

    Each runs once beforehand, and then once a round, in turn.
    """
    for run in contenders.values():
        run()
    took: dict[str, list[tuple[float, float]]] = {name: [] for name in contenders}
    for _ in range(rounds):
        for name, run in contenders.items():
            spent, started = time.process_time(), time.perf_counter()
            run()
            took[name].append((time.process_time() - spent, time.perf_counter() - started))
    return {name: 1e3 * np.array(times).T for name, times in took.items()}


def show(what: str, took: NDArray[np.float64], limit: float | None = None) -> None:
    """Print processor and wall times, medians and least, and whether the first meets a limit."""
    medians = np.median(took, 1)
    cells = [f"{f'{m:.2f} ({t:.2f})':>16}" for m, t in zip(medians, took.min(1), strict=True)]
    met = "" if limit is None else f"  {limit_text(medians[0], limit)}"
    print(f"{what:44} {' '.join(cells)}{met}")


def limit_text(figure: float, limit: float) -> str:
    """Return a limit and whether a figure, which may be as much, meets it."""
    return f"{limit:g}: {'met' if figure <= limit else 'NOT MET'}"


if __name__ == "__main__":
    main()
