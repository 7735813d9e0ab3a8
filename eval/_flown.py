"""Searches of the same targets on the grid, with rays, and with the camera, kept in a folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import joblib

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl._journal import Journal
from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.eval._backends import BACKENDS
from sloop_ppl.eval._driver_watch import Driver
from sloop_ppl.eval._flown_trial import ARMS, Arm, FlownTarget, FlownTrial, trials_of
from sloop_ppl.eval._manifest import changes
from sloop_ppl.eval._worker_process import one_thread
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.maps import CityMap
from sloop_ppl.outputs import check_output_folder
from sloop_ppl.simulation import measured_rates

__all__ = ["fly_trials", "read_flown"]

_TRIALS, _SETTINGS = "trials.jsonl", "settings.json"


def fly_trials(
    descriptions: Sequence[AnnotatedDescription],
    find_map: Callable[[str], CityMap],
    out: Path,
    *,
    targets: int = 40,
    seeds: int = 2,
    arms: Sequence[Arm] = ARMS,
    sims: int = 500,
    max_steps: int = 120,
    workers: int | None = None,
    notify: Callable[[str], None],
) -> list[FlownTrial]:
    """Run trials, or go on with those that a stopped run has left.

    Parameters
    ----------
    descriptions
        Described targets, with gold relations.
    find_map
        Name of a map -> the map.
    out
        Folder of the run; trials are written there as they are done.
    targets
        How many of the described targets are searched for, at most: those of all maps in turn, but
        for those that have no room near their annotated cell, or of which nothing is said.
    seeds
        How often each, with other starts and other places within the cell.
    arms
        What each is run with.
    sims, max_steps
        Of each search.
    workers
        How many processes, > 0; as many as there are processors when None. Results do not depend
        on it.
    notify
        Called with a line of progress for each target left out and after each trial.

    Raises
    ------
    InputError
        When the folder has trials of other settings, or a line of it is no trial.
    """
    workers = joblib.cpu_count() if workers is None else workers
    if workers < 1:
        raise InputError(f"The number of workers is {workers}; expected at least 1")
    folder = check_output_folder(out)
    path = folder / _TRIALS
    _check_settings(
        folder,
        {"sims": sims, "max_steps": max_steps, "rates": asdict(measured_rates("camera"))},
    )
    journal, done = Journal(path), {t.key: t for t in read_flown(path)}
    chosen = _chosen(descriptions, find_map, targets, seeds, notify)
    keys = [t.key(arm) for t in chosen for arm in arms]
    jobs = []
    for target in chosen:
        for altitude in sorted({a.altitude_m for a in arms}, reverse=True):
            left = [a for a in arms if a.altitude_m == altitude and target.key(a) not in done]
            if left:
                jobs.append((target, tuple(left)))
    work = partial(_work, sims=sims, max_steps=max_steps, driver=Driver.this())
    for trials in BACKENDS["joblib"](work, jobs, workers=workers, address=None):
        if isinstance(trials, str):
            raise InputError(trials)
        for trial in trials:
            journal.append(asdict(trial))
            done[trial.key] = trial
            notify(
                f"{sum(key in done for key in keys)} of {len(keys)}: {trial.description} "
                f"{trial.target} seed {trial.seed}, {trial.arm}: "
                f"{'found' if trial.found else 'not found'}, {trial.steps} steps"
            )
    return [done[key] for key in sorted(keys)]


def read_flown(path: Path) -> list[FlownTrial]:
    """Return the trials of a file; none when there is no file.

    Raises
    ------
    InputError
        When a line is no trial.
    """
    trials = []
    for number, record in enumerate(Journal(path).records(), 1):
        try:
            trials.append(checked(record, FlownTrial))
        except Fault as fault:
            raise InputError(
                f"Trial {number} of '{path}' is no flown trial: {fault}; delete its line, and give "
                "the same command again to fly it anew"
            ) from None
    return trials


def _work(
    job: tuple[FlownTarget, tuple[Arm, ...]], *, sims: int, max_steps: int, driver: Driver
) -> list[FlownTrial] | str:
    """Return the trials of a job, or the words of what is wrong: not all errors can be pickled."""
    target, arms = job
    with one_thread(stoppable=driver.is_this):
        try:
            return trials_of(target, arms, sims=sims, max_steps=max_steps)
        except SloopError as error:
            return f"{target.annotated.id} {target.target}: {error}"


def _check_settings(folder: Path, settings: Mapping[str, Any]) -> None:
    """Keep the settings of a run in its folder, and refuse to go on under others."""
    path = folder / _SETTINGS
    if not path.exists():
        path.write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")
        return
    try:
        held = parse_json(read_text(path, "File"))
    except ForeignFault as error:
        raise InputError(f"'{path}' is not JSON: {error}") from error
    differing = changes(held if isinstance(held, dict) else {}, settings)
    if differing:
        raise InputError(
            f"Output folder '{folder}' holds trials of other settings: {'; '.join(differing)}. "
            "Choose another folder, or go back to those settings"
        )


def _chosen(
    descriptions: Sequence[AnnotatedDescription],
    find_map: Callable[[str], CityMap],
    targets: int,
    seeds: int,
    notify: Callable[[str], None],
) -> list[FlownTarget]:
    """Return what is searched for, seed by seed, those of all maps in turn."""
    by_map: dict[str, list[tuple[AnnotatedDescription, str]]] = {}
    for annotated in descriptions:
        for target in annotated.targets:
            by_map.setdefault(annotated.map, []).append((annotated, target))
    cities = {name: find_map(name) for name in by_map}
    longest = max((len(v) for v in by_map.values()), default=0)
    chosen: list[list[FlownTarget]] = []
    for annotated, target in (v[i] for i in range(longest) for v in by_map.values() if i < len(v)):
        if len(chosen) == targets:
            break
        of_seeds = [FlownTarget(annotated, target, s, cities[annotated.map]) for s in range(seeds)]
        fault = next((t.fault() for t in of_seeds if t.fault()), "")
        if fault:
            notify(f"{annotated.id} {target} is left out: {fault}")
        else:
            chosen.append(of_seeds)
    if len(chosen) < targets:
        notify(f"{len(chosen)} targets can be searched for; {targets} were asked for")
    return [of_seeds[seed] for seed in range(seeds) for of_seeds in chosen]
