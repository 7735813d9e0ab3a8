"""Time the sweep: with one worker, with two, and the wall time of a trial.

Run: python benchmarks/bench_sweep.py [FILE.jsonl ...] [--rollout published] [--full] [--quick]

Without files it takes the bundled examples. Every run starts with warm workers and is the same
sweep but for the seed, so that starting and importing do not count, and one worker and two take
turns; with `--full` one whole sweep (7 models, 3 ranges, 1 start, 1000 simulations) is timed as a
user meets it, everything included. Other work on the machine lowers the ratio: the load is printed
beside it. `--quick` shows that both run: two descriptions, one model, one range, few simulations.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

from sloop_ppl.eval._sweep_files import SweepRequest, sweep_files
from sloop_ppl.eval.trials import Searching

EXAMPLES = Path(str(files("sloop_ppl"))) / "data" / "examples.jsonl"
PART = {"models": "keyword,sloop,sloop-m4,bayes", "ranges": "3,4"}


def run(descriptions, workers, searching, **changes):
    """Return the wall seconds of a sweep into a new folder and its trials."""
    with tempfile.TemporaryDirectory() as folder:
        request = SweepRequest(
            descriptions, Path(folder), workers=workers, searching=searching, **changes
        )
        begun = time.perf_counter()
        done = sweep_files(request)
        return time.perf_counter() - begun, done.trials()


def pace(descriptions, rounds, searching, **changes):
    """Print trials per second with one worker and two, and their ratio."""
    rates = {1: [], 2: []}
    for seed in range(rounds + 1):
        for workers, measured in rates.items():
            seeded = replace(searching, seed=seed)
            seconds, trials = run(descriptions, workers, seeded, **changes)
            measured.append(len(trials) / seconds)
    medians = {
        n: statistics.median(measured[1:]) for n, measured in rates.items()
    }  # warm after the first
    for workers, rate in medians.items():
        print(f"{workers} workers: {rate:.1f} trials a second")
    ratio = medians[2] / medians[1]
    print(f"two workers / one: {ratio:.2f} (goal 1.7); load after: {os.getloadavg()[0]:.2f}")


def whole(descriptions, searching, **changes):
    """Print how long a sweep takes as a user meets it."""
    seconds, trials = run(descriptions, 2, searching, **changes)
    mean = statistics.mean(trial.seconds for trial in trials)
    print(f"whole sweep, 2 workers: {len(trials)} trials in {seconds:.0f} s (goal 180)")
    print(f"a trial: {mean:.3f} s of wall time")


def quick_round():
    """Run both measurements once on little."""
    little = {"models": "keyword", "ranges": "3"}
    with tempfile.TemporaryDirectory() as folder:
        few = Path(folder) / "few.jsonl"
        lines = EXAMPLES.read_text(encoding="utf-8").splitlines(keepends=True)
        few.write_text("".join(lines[:2]), encoding="utf-8")
        whole([few], Searching(sims=20), **little)
        pace([few], 1, Searching(sims=20), **little)


def main():
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--rollout", default=None)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    options = parser.parse_args()
    descriptions = options.files or [EXAMPLES]
    print(f"load before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} processors")
    if options.quick:
        quick_round()
    elif options.full:
        whole(descriptions, Searching(rollout=options.rollout))
    else:
        pace(descriptions, options.rounds, Searching(rollout=options.rollout), **PART)


if __name__ == "__main__":
    main()
