"""Compare the planners' rates in one process, and print ratios.

Run: python benchmarks/bench_search.py [--rounds 7] [--quick]

Every round runs each contender once, in turn, so that all of them meet the same machine; the
median of the CPU times counts, and ratios are medians over rounds. --quick shows that all but
compiling anew runs: few simulations, short searches, one round.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.planning import (
    GridBelief,
    NativePouct,
    SearchConfig,
    SearchObservation,
    SearchObservationModel,
    SearchPolicyModel,
    SearchRewardModel,
    SearchSpace,
    SearchTransitionModel,
    make_planner,
    run_search,
)
from sloop_ppl.planning._pomdp import POUCT, Agent
from sloop_ppl.planning._search_kernel import NativeSearch

SIDE, LARGE = 41, 401


def bundled_agent():
    """Return pomdp-py's own multi-object search on 41 x 41 cells: one target, range 4."""
    from pomdp_py.problems.multi_object_search.agent.agent import MosAgent
    from pomdp_py.problems.multi_object_search.domain.state import RobotState
    from pomdp_py.problems.multi_object_search.models.components.sensor import Laser2DSensor

    robot = -1
    sensor = Laser2DSensor(robot, fov=90, min_range=1, max_range=4, angle_increment=5)
    pose = RobotState(robot, (SIDE // 2, SIDE // 2, 0.0), (), None)
    return MosAgent(robot, pose, {1}, (SIDE, SIDE), sensor, prior={})


def our_agent(space, seed=0):
    """Return an agent of ours in the middle of the map, with uniform beliefs."""
    tables = {name: np.ones(space.shape) for name in space.target_ids}
    robot = space.robot(space.encode(space.n_rows // 2, space.n_cols // 2, 0), looked=True)
    return Agent(
        GridBelief(space, tables, robot, rng=np.random.default_rng(seed)),
        SearchPolicyModel(space, random.Random(seed)),
        SearchTransitionModel(space),
        SearchObservationModel(space),
        SearchRewardModel(space),
    )


def space_of(side=SIDE, targets=1, **settings):
    """Return a search space of the benchmark."""
    config = SearchConfig(sensor_range_cells=4.0, **{"rollout": "published", **settings})
    return SearchSpace((side, side), tuple(f"T{i}" for i in range(targets)), config)


def bundled(sims):
    """Return a function that plans once on the bundled domain."""

    def run():
        agent = bundled_agent()
        planner = POUCT(
            max_depth=30,
            discount_factor=0.95,
            num_sims=sims,
            exploration_const=1000,
            rollout_policy=agent.policy_model,
        )
        with contextlib.redirect_stdout(io.StringIO()):
            planner.plan(agent)

    return run


def ours(name, sims, side=SIDE, targets=1):
    """Return a function that plans once on our domain, from an empty tree.

    The name is a planner's; ``fast`` has the published rollout and ``informed`` is its own default.
    """
    space = space_of(side, targets, sims=sims, rollout=None if name == "informed" else "published")
    agent = our_agent(space)
    rng = np.random.default_rng(0)
    if name == "fast":
        planner = NativePouct(NativeSearch(space), sims=sims, rng=rng)
    else:
        planner = make_planner("fast" if name == "informed" else name, space, rng=rng)

    def run():
        planner.forget()
        planner.plan(agent)

    run()
    return run


def rates(contenders, rounds):
    """Return simulations per CPU second of each contender in each round."""
    rounds_of = {name: [] for name in contenders}
    for _ in range(rounds):
        for name, (run, sims) in contenders.items():
            begun = time.process_time()
            run()
            rounds_of[name].append(sims / (time.process_time() - begun))
    return rounds_of


def planning(rounds, share=1):
    """Print rates of planning and their ratios, with the usual simulations divided by `share`."""
    few, some, many = (sims // share for sims in (100, 1000, 20_000))
    contenders = {
        "bundled": (bundled(few), few),
        "pouct": (ours("pouct", some), some),
        "fast": (ours("fast", many), many),
        f"fast, {LARGE} x {LARGE}, 3 targets": (ours("fast", many, LARGE, 3), many),
    }
    rounds_of = rates(contenders, rounds)
    for name, values in rounds_of.items():
        print(f"{name:28s} {statistics.median(values):12,.0f} simulations a CPU second")
    for a, b, goal in (("pouct", "bundled", 12), ("fast", "bundled", 1000), ("fast", "pouct", 50)):
        ratio = statistics.median(x / y for x, y in zip(rounds_of[a], rounds_of[b], strict=True))
        print(f"{a} / {b}: {ratio:,.1f} (goal {goal:,})")


def belief_update(rounds):
    """Print the time of one exact belief update on many cells."""
    space = space_of(LARGE)
    agent = our_agent(space)
    left, robot = space.actions[1], agent.belief.robot.moved(1)
    nothing = SearchObservation((-1,), 0)
    times = []
    for _ in range(rounds * 20):
        begun = time.perf_counter()
        agent.belief.updated(left, nothing, robot)
        times.append(time.perf_counter() - begun)
    line = f"{statistics.median(times) * 1e3:.3f} ms (goal 1)"
    print(f"belief update, {LARGE} x {LARGE}: {line}")


def trial(rounds, steps=200):
    """Print the time of 200 steps of a search, from searches that take long or are cut short."""
    city = CityMap("empty", Grid.square(100.0), ())
    table = np.ones((SIDE, SIDE))
    table[:, SIDE // 2 :] = 1e-6  # the target is where it is hardly expected
    for rollout in ("published", "informed"):
        config = SearchConfig(max_steps=steps, rollout=rollout)
        times = []
        for seed in range(rounds):
            begun = time.process_time()
            episode = run_search(
                {"T": table},
                city,
                {"T": (90.0, 90.0)},
                planner="fast",
                config=config,
                rng=np.random.default_rng(seed),
            )
            times.append((time.process_time() - begun) / episode.steps * 200)
        print(
            f"200 steps of fast, 1000 simulations, {rollout}: {statistics.median(times):.3f} s "
            "(goal 0.3)"
        )


FIRST = """
import time
import benchmarks.bench_search as bench
begun = time.process_time()
bench.ours("NAME", 1000)
print(time.process_time() - begun)
"""

MEMORY = """
import benchmarks.bench_search as bench
run = bench.ours("NAME", SIMS, bench.LARGE, 3)
run()
print(bench.peak_mb())
"""


def fresh(code, **environment):
    """Return what a new process prints."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        cwd=Path(__file__).parents[1],  # where `benchmarks` can be imported from
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return float(done.stdout)


def peak_mb():
    """Return the peak memory of this process alone (Linux).

    `getrusage` would count that of the process it was started from.
    """
    status = Path("/proc/self/status").read_text()
    return next(float(x.split()[1]) for x in status.splitlines() if x.startswith("VmHWM")) / 1024


def processes(rounds, quick=False):
    """Print what a new process needs: CPU time to its first plan, and memory."""
    for name in ("fast", "informed"):
        first = FIRST.replace("NAME", name)
        if not quick:
            fresh(first)  # what is compiled is kept for the next
        warm = statistics.median(fresh(first) for _ in range(min(rounds, 3)))
        print(f"first plan of {name} in a new process, cache warm: {warm:.2f} s (goal 1)")
        if not quick:  # compiling takes long
            with tempfile.TemporaryDirectory() as folder:
                Path(folder).chmod(0o555)
                cold = fresh(first, NUMBA_CACHE_DIR=folder)
            print(f"the same with a read-only, empty cache folder: {cold:.2f} s (works)")
        sims = "1_000" if quick else "100_000"
        memory = fresh(MEMORY.replace("NAME", name).replace("SIMS", sims))
        where = f"{LARGE} x {LARGE}, 3 targets"
        print(f"peak memory of {name}, {where}: {memory:.0f} MB (goal 300)", flush=True)


def main():
    """Run every part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    options = parser.parse_args()
    rounds = 1 if options.quick else options.rounds
    planning(rounds, 10 if options.quick else 1)
    belief_update(rounds)
    trial(rounds, 10 if options.quick else 200)
    processes(rounds, options.quick)
    print(f"peak memory of this process: {peak_mb():.0f} MB")


if __name__ == "__main__":
    main()
