"""Measure what a command and the first answers in Python cost, against what they have to meet.

Run: python benchmarks/bench_start.py [--rounds 5] [--quick]

Each figure is the processor time of a fresh process from start to exit, with one thread, the
median of the rounds after one that is not counted; the rounds go through all of them in turn, so
that a busy hour slows all alike. Later answers are timed inside one process: the median of 20 of
inferring a sentence and summing up the posterior as `sloop infer --json` does, 41 x 41 cells.
--quick shows that the benchmark runs: one round.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

TEXT = "the green toyota is behind velvet dog and near ivy"
MAP = ("--map", "cleveland")
COMMAND = "import sys; from sloop_ppl.cli import main; main(sys.argv[1:])"
FIRST = f"""
import sloop_ppl as sloop
city = sloop.load_map("cleveland")
sloop.infer(sloop.parse({TEXT!r}, city), city)
"""
LATER = f"""
import time
import sloop_ppl as sloop
from sloop_ppl.bridge._formatting import belief_report
city = sloop.load_map("cleveland")
spent = []
for _ in range(23):
    begun = time.process_time()
    belief_report(sloop.infer({TEXT!r}, city))
    spent.append(1e3 * (time.process_time() - begun))
print(sorted(spent[3:])[10])
"""

CASES: dict[str, tuple[float | None, tuple[str, ...]]] = {
    "python": (None, ("-c", "pass")),
    "import torch": (None, ("-c", "import torch")),
    "sloop --help": (None, ("-c", COMMAND, "--help")),
    "sloop list": (0.35, ("-c", COMMAND, "list", "models")),
    "sloop map show": (None, ("-c", COMMAND, "map", "show", "cleveland")),
    "sloop parse": (0.9, ("-c", COMMAND, "parse", TEXT, *MAP)),
    "sloop infer": (2.4, ("-c", COMMAND, "infer", TEXT, *MAP)),
    "sloop infer --figure": (4.0, ("-c", COMMAND, "infer", TEXT, *MAP, "--figure", "belief.png")),
    "sloop infer --out": (None, ("-c", COMMAND, "infer", TEXT, *MAP, "--out", "belief.nc")),
    "import sloop_ppl; parse; infer": (2.2, ("-c", FIRST)),
}
"""What is measured -> seconds to stay under, if any, and Python's arguments."""

LATER_MS = 12.0


def main() -> None:
    """Print every figure, with what it has to meet."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("--quick", action="store_true", help="show that it runs, in seconds")
    given = options.parse_args()
    load = " ".join(f"{x:.1f}" for x in os.getloadavg())
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {load}")
    rounds = 0 if given.quick else given.rounds
    with tempfile.TemporaryDirectory() as folder:
        first = {name: seconds(arguments, folder) for name, (_, arguments) in CASES.items()}
        each = [
            {name: seconds(arguments, folder) for name, (_, arguments) in CASES.items()}
            for _ in range(rounds)
        ]
        later = float(python(("-c", LATER), folder))
    for name, (bar, _) in CASES.items():
        spent = median(one[name] for one in each) if each else first[name]
        show(name, spent, "s", bar)
    show("later answers with report", later, "ms", LATER_MS)


def seconds(arguments: tuple[str, ...], folder: str) -> float:
    """Return the processor time of a fresh Python, seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    python(arguments, folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def python(arguments: tuple[str, ...], folder: str) -> str:
    """Run Python in a folder and return what it prints."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=Path(folder),
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{arguments} failed: {done.stderr}")
    return done.stdout


def show(what: str, spent: float, unit: str, bar: float | None) -> None:
    """Print a row: what was measured, the time it took, and whether that is little enough."""
    verdict = "" if bar is None else f"  {bar:g} {unit}: {'met' if spent < bar else 'NOT MET'}"
    print(f"{what:32} {spent:8.2f} {unit:2}{verdict}")


if __name__ == "__main__":
    main()
