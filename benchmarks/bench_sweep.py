"""Time the sweep: with one worker, with two, and the CPU time of a trial.

Run: python benchmarks/bench_sweep.py [FILE.jsonl ...] [--rollout published] [--full]

Without files it takes the bundled examples. Every run starts with warm workers and is the same
sweep but for the seed, so that starting and importing do not count; with `--full` one whole sweep
(7 models, 3 ranges, 1 start, 1000 simulations) is timed as a user meets it, everything included.
Other work on the machine lowers the ratio: the load is printed beside it.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from importlib.resources import files
from pathlib import Path

from sloop_ppl.eval.sweep_files import SweepRequest, sweep_files
from sloop_ppl.eval.trials import Searching

MODELS = "keyword,sloop,sloop-m4,bayes"


def run(folder, descriptions, workers, searching, **changes):
    """Return the wall seconds of a sweep and its number of trials."""
    request = SweepRequest(
        descriptions, Path(folder), workers=workers, searching=searching, **changes
    )
    begun = time.perf_counter()
    done = sweep_files(request)
    return time.perf_counter() - begun, done.trials()


def pace(descriptions, workers, rollout, rounds):
    """Return trials per second of each round after one that warms the workers up."""
    rates = []
    for seed in range(rounds + 1):
        with tempfile.TemporaryDirectory() as folder:
            searching = Searching(rollout=rollout, seed=seed)
            seconds, trials = run(
                folder, descriptions, workers, searching, models=MODELS, ranges="3,4"
            )
        rates.append(len(trials) / seconds)
    return rates[1:]


def main():
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--rollout", default=None)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--full", action="store_true")
    options = parser.parse_args()
    descriptions = options.files or [Path(str(files("sloop_ppl"))) / "data" / "examples.jsonl"]
    print(f"load before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} processors")
    if options.full:
        with tempfile.TemporaryDirectory() as folder:
            seconds, trials = run(folder, descriptions, 2, Searching(rollout=options.rollout))
            mean = statistics.mean(trial.seconds for trial in trials)
        print(f"whole sweep, 2 workers: {len(trials)} trials in {seconds:.0f} s (goal 180)")
        print(f"a trial: {mean:.3f} s of wall time")
        return
    rates = {n: pace(descriptions, n, options.rollout, options.rounds) for n in (1, 2)}
    for workers, told in rates.items():
        print(f"{workers} workers: {statistics.median(told):.1f} trials a second")
    ratio = statistics.median(rates[2]) / statistics.median(rates[1])
    print(f"two workers / one: {ratio:.2f} (goal 1.7); load after: {os.getloadavg()[0]:.2f}")


if __name__ == "__main__":
    main()
