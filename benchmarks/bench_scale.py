"""Measure large maps and many descriptions: a search, inference, a county, and sentences a second.

Run: python benchmarks/bench_scale.py [planner|inference|county|many ...] [--quick]

Every part runs in a process of its own, which prints its peak of memory (Linux). Times are those
of the processor, one thread, but for the descriptions a second, which are by the clock: divide by
the processors that were free. The county is made by code, as there is no extract of one: 20 km x
20 km at 5 m, 100 streets at right angles and 40,000 buildings. --quick shows that all parts run, on
small maps.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
if str(ROOT / "tests") not in sys.path:
    sys.path.insert(0, str(ROOT / "tests"))  # for the county that is made by code


def main() -> None:
    """Run the parts that are asked for."""
    parts: dict[str, Callable[[bool], None]] = {
        "planner": planner,
        "inference": inference,
        "county": county,
        "many": many,
    }
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("parts", nargs="*", help=f"of {', '.join(parts)}; all when none is named")
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    options.add_argument("--here", action="store_true", help="in this process")
    given = options.parse_args()
    for name in given.parts or parts:
        if name not in parts:
            options.error(f"there is no part {name}")
        if given.here:
            parts[name](given.quick)
            goal = 1500 if name == "county" else 1200
            print(f"peak memory of {name}: {peak_mb():.0f} MB (goal {goal})")
            continue
        quick = ["--quick"] if given.quick else []
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        command = [sys.executable, __file__, name, "--here", *quick]
        if subprocess.run(command, env=environment, check=False).returncode:
            raise SystemExit(f"part {name} fails")


def peak_mb() -> float:
    """Return the peak memory of this process alone (Linux)."""
    status = Path("/proc/self/status").read_text()
    return next(float(x.split()[1]) for x in status.splitlines() if x.startswith("VmHWM")) / 1024


def took(run: Callable[[], Any]) -> tuple[float, Any]:
    """Return processor seconds and what is returned."""
    begun = time.process_time()
    result = run()
    return time.process_time() - begun, result


def planner(quick: bool) -> None:
    """Search 1001 x 1001 cells with the default planner."""
    from sloop_ppl.maps import CityMap, Grid
    from sloop_ppl.planning import GridBelief, SearchConfig, SearchSpace, run_search, warm_up
    from sloop_ppl.planning.path_search import RunningPathSearch

    side = 101 if quick else 1001
    city = CityMap("empty", Grid.square((side - 1) * 2.5), ())
    warm_up()
    for targets in (1, 3):
        ids = tuple(f"T{i}" for i in range(targets))
        space = SearchSpace(city.grid.shape, ids, SearchConfig())
        rng = np.random.default_rng(0)
        tables = {name: peaked(side, rng) for name in ids}
        robot = space.robot(space.encode(side // 2, side // 2, 0), looked=True)
        agent: Any = SimpleNamespace(belief=GridBelief(space, tables, robot, rng=rng), history=())
        setup, running = took(lambda space=space: RunningPathSearch(space))
        first, _ = took(lambda running=running, agent=agent: running.plan(agent))
        what = f"{side} x {side}, {targets} targets"
        print(f"set-up of fast, {what}: {setup * 1e3:.0f} ms (goal 300)")
        print(f"first plan of fast, {what}: {first * 1e3:.0f} ms (goal 150)")
        ends: list[float] = []
        far = dict.fromkeys(ids, (-city.grid.east_m, 0.0))

        def note(_: object, ends: list[float] = ends) -> None:
            ends.append(time.process_time())
            if len(ends) == 40:
                raise KeyboardInterrupt

        begun = time.process_time()
        with suppress(KeyboardInterrupt):  # enough
            run_search(tables, city, far, start=(0.0, 0.0), rng=rng, on_step=note)
        steps = np.diff(ends) * 1e3
        print(f"search to the first step, {what}: {(ends[0] - begun) * 1e3:.0f} ms")
        if len(steps):
            print(f"a step of a search, {what}: {np.median(steps):.1f} ms (goal 20)")


def peaked(side: int, rng: np.random.Generator) -> np.ndarray:
    """Return a belief with a peak somewhere and something everywhere."""
    (row, col), at = rng.uniform(0, side, 2), np.arange(side)
    peak = np.exp(-(((at[:, None] - row) ** 2 + (at - col) ** 2) / (2 * 8.0**2)))
    return peak + 1e-2 / side**2


PHRASES = {
    "3 frame relations": (("behind", "Hall7"), ("left", "Hall8"), ("front", "Hall9")),
    "near a building": (("near", "Hall11"),),
    "along a street": (("on", "3Street"), ("north", "Hall12")),
    "a corner of two streets": (("on", "2Street"), ("near", "4Avenue")),
    "between two buildings": (("between", "Hall13", "Hall14"),),
}


def described(city: Any, name: str) -> Any:
    """Return a description of the benchmark."""
    from sloop_ppl.language import Description, SpatialRelation, TargetObject

    relations = tuple(SpatialRelation("Car", word, tuple(at)) for word, *at in PHRASES[name])
    return Description("", city.name, (TargetObject("Car"),), relations)


def inference(quick: bool) -> None:
    """Infer on 1001 x 1001 cells: on all of them, and from coarse to fine."""
    import torch
    from support.made_county import made_county

    from sloop_ppl.inference import infer_description, infer_refined

    torch.set_num_threads(1)
    half = 1200 if quick else 2500
    small = made_county(100, 16, spacing_m=60)
    infer_description(described(small, "3 frame relations"), small)  # what loads only once
    city = made_county(half, 300 if quick else 3000)
    said = described(city, "3 frame relations")
    what = "{} x {}".format(*city.grid.shape)

    def whole() -> Any:
        return infer_description(said, city)[0].belief("Car")

    first, belief = took(whole)
    again = min(took(whole)[0] for _ in range(3))
    print(f"exact, {what}, 3 frame relations: {again * 1e3:.0f} ms (goal 250)")
    print(f"the same, the first time these places are mentioned: {first * 1e3:.0f} ms")
    for name in PHRASES:
        description = described(city, name)
        seconds, refined = took(lambda d=description: infer_refined(d, city))
        if name != "3 frame relations":
            belief = infer_description(description, city)[0].belief("Car")
        apart = 0.5 * np.abs(refined.belief("Car") - belief).sum()
        print(
            f"coarse to fine, {what}, {name}: {seconds * 1e3:.0f} ms, {refined.grid.size} blocks, "
            f"total variation {apart:.4f} (goal 0.01)"
        )


def county(quick: bool) -> None:
    """Answer sentences on 20 km x 20 km, each with what it is the first to mention."""
    import torch
    from support.made_county import made_county

    from sloop_ppl.inference import infer_description, infer_refined

    torch.set_num_threads(1)
    small = made_county(100, 16, spacing_m=60)
    infer_description(described(small, "3 frame relations"), small)  # what loads only once
    city = made_county(*((1500, 500) if quick else (10_000, 40_000)))
    for name in PHRASES:
        said = described(city, name)
        seconds, refined = took(lambda said=said: infer_refined(said, city))
        spread, belief = took(lambda refined=refined: refined.belief("Car"))
        print(
            f"county of {city.grid.size:,} cells, {name}: {seconds:.2f} s (goal 3), and "
            f"{spread:.2f} s for the table of {belief.size:,} cells; {refined.grid.size:,} blocks, "
            f"{refined.unresolved:.4f} unresolved"
        )


def many(quick: bool) -> None:
    """Read and infer from many texts of the published kind, in one process and in two."""
    import sloop_ppl as sloop
    from sloop_ppl.eval import bundled_examples

    pairs = [(example.text, example.map) for example in bundled_examples()]
    count = 64 if quick else 4000
    pairs = (pairs * (count // len(pairs) + 1))[:count]
    for workers in (1, 2):
        for _ in sloop.infer_many(pairs[: 64 * workers], workers=workers):
            pass  # processes and maps are there
        begun, cpu = time.perf_counter(), time.process_time()
        faults = sum(said.fault is not None for said in sloop.infer_many(pairs, workers=workers))
        seconds = time.perf_counter() - begun
        print(
            f"infer_many, {count} published texts, reading included, {workers} workers: "
            f"{count / seconds:.0f} a second by the clock (goal 300 with 2), "
            f"{faults} not understood, {time.process_time() - cpu:.1f} s of this process"
        )


if __name__ == "__main__":
    main()
