"""Kill a sweep's workers and its driver ten times at random moments, and compare with a whole one.

Run as a program with a folder to work in. Drivers are forked, so that what takes long to import is
imported once; workers are processes of their own, as users have them.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import sys
import time
from pathlib import Path

import psutil

from sloop_ppl.eval import _sweep_files as module
from sloop_ppl.eval._run_folder import read_run
from sloop_ppl.eval.trials import Searching
from tests.support.small_sweeps import LINES, request, table_of, write_lines

SLOW = Searching(planner="fast", sims=2000, rollout="published", max_steps=120)
KILLS = ["worker", "worker", "worker", "driver of workers", *["driver"] * 6]


def asked(folder: Path, out: str, workers: int):
    return request(
        folder, out=folder / out, models="uniform,keyword,sloop", ranges="3,4,5", starts=2,
        searching=SLOW, workers=workers,
    )  # fmt: skip


def fork_driver(folder: Path, workers: int) -> int:
    """Start a driver; it ends with code 0 once the sweep is whole."""
    pid = os.fork()
    if pid:
        return pid
    try:
        module.sweep_files(asked(folder, "killed", workers))
    except BaseException as error:
        sys.stderr.write(f"driver: {error!r}\n")
        os._exit(1)
    os._exit(0)


def lines_in(folder: Path) -> int:
    return sum(part.read_bytes().count(b"\n") for part in folder.glob("parts/*.jsonl"))


def wait_for_lines(folder: Path, more: int, driver: int) -> None:
    """Wait until some more trials are on disk; the driver must not end before."""
    wanted = lines_in(folder) + more
    end = time.monotonic() + 120
    while lines_in(folder) < wanted:
        if time.monotonic() > end or os.waitpid(driver, os.WNOHANG)[0]:
            raise SystemExit(f"no {more} more trials before the driver ended, or in two minutes")
        time.sleep(0.01)


def a_worker(driver: int, rng: random.Random) -> psutil.Process:
    """Return one of the driver's workers; just after a kill there may be none for a moment."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        found = []
        for child in psutil.Process(driver).children(recursive=True):
            with contextlib.suppress(psutil.Error):  # it ended just now
                if any("popen_loky" in word for word in child.cmdline()):
                    found.append(child)
        if found:
            return rng.choice(found)
        time.sleep(0.02)
    raise SystemExit("no worker for a minute")


def main(folder: Path) -> None:
    module.git_state = lambda: None  # someone may commit meanwhile
    rng = random.Random(0)
    write_lines(folder / "said.jsonl", *LINES)
    run = folder / "killed"
    driver, workers, kept = None, 2, []
    for victim in KILLS:
        if victim == "driver":
            workers = 1
        if driver is None:
            driver = fork_driver(folder, workers)
        wait_for_lines(run, rng.randint(1, 3), driver)
        time.sleep(rng.uniform(0, 0.1))
        if victim == "worker":
            a_worker(driver, rng).kill()
            kept.append(lines_in(run))
            continue
        orphans = psutil.Process(driver).children(recursive=True)
        os.kill(driver, signal.SIGKILL)
        os.waitpid(driver, 0)
        for orphan in orphans:
            orphan.kill()
        kept.append(lines_in(run))
        driver = None
    driver = fork_driver(folder, 1)
    _, status = os.waitpid(driver, 0)
    whole = module.sweep_files(asked(folder, "whole", 1))
    told = {
        "status": status,
        "kept": kept,
        "trials": len(whole.trials()),
        "same": table_of(read_run(run)) == table_of(whole),
    }
    sys.stdout.write(json.dumps(told) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
