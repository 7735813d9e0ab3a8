"""The paper's experiment: every described target under every model, range and start."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from sloop_ppl.errors import OutputError, SloopError
from sloop_ppl.eval._answerers import AskingSettings
from sloop_ppl.eval._asking import AskingTrials, recorded_of
from sloop_ppl.eval._backends import BACKENDS, WorkersLost
from sloop_ppl.eval._driver_watch import Driver, working_in
from sloop_ppl.eval._run_folder import RunFolder
from sloop_ppl.eval._trial_files import append_trial
from sloop_ppl.eval._worker_process import one_thread, pickled_model, unpickled_model
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.eval.quality import beliefs_of, model_for
from sloop_ppl.eval.trials import Searching, TrialKey, compile_ahead, trial_of
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel

__all__ = ["SearchedDescription", "Sweep", "SweepProgress", "run_sweep"]

_PATIENCE = 3
_CITIES: dict[str, CityMap] = {}
# A worker's maps, with what was computed on them, by digest: kept from one job to the next.


@dataclass(frozen=True)
class SearchedDescription:
    """A description, its map, and what a model is told of it."""

    annotated: AnnotatedDescription
    city: CityMap
    description: Description


@dataclass(frozen=True)
class Sweep:
    """All trials of an experiment.

    Parameters
    ----------
    descriptions
        The descriptions; each tells the place of at least one target.
    models
        Name -> model, or the model for each map by the map's name.
    ranges_cells
        Ranges of the sensor, cells.
    starts
        How many starts each target is searched from, > 0.
    searching
        How it is searched.
    questions
        How many questions may be asked, each number by itself.
    question_costs
        What a question costs, each cost by itself.
    asking
        How it is asked; None for a sweep that does not ask.
    """

    descriptions: Sequence[SearchedDescription]
    models: Mapping[str, ObservationModel | Mapping[str, ObservationModel]]
    ranges_cells: tuple[float, ...] = (3.0, 4.0, 5.0)
    starts: int = 1
    searching: Searching = Searching()  # noqa: RUF009 - frozen
    questions: tuple[int, ...] = (0,)
    question_costs: tuple[float, ...] = (10.0,)
    asking: AskingSettings | None = None

    def model(self, name: str, map_name: str) -> ObservationModel:
        """Return the model of this name for a map."""
        return model_for(self.models[name], map_name)

    def keys(self, annotated: AnnotatedDescription, model: str) -> Iterator[TrialKey]:
        """Yield the trials of a description under a model."""
        asked = [
            (q, cost) for q in self.questions for cost in (self.question_costs if q else (0.0,))
        ]
        for target in annotated.targets:
            if self.asking is not None and not self.asking.asks_about(annotated, target):
                continue
            for range_cells in self.ranges_cells:
                for start in range(self.starts):
                    for q, cost in asked:
                        yield TrialKey(annotated.id, target, model, range_cells, start, q, cost)

    def all_keys(self) -> Iterator[TrialKey]:
        """Yield all trials."""
        for searched in self.descriptions:
            for name in self.models:
                yield from self.keys(searched.annotated, name)


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep is.

    Parameters
    ----------
    done, total
        How many trials are done, and of how many.
    seconds_left
        How long the rest will take at the pace so far; None when that is not known.
    """

    done: int
    total: int
    seconds_left: float | None


@dataclass(frozen=True)
class _Job:
    """The trials of one description under one model, which share its beliefs."""

    searched: SearchedDescription
    map_digest: str
    model: bytes
    keys: tuple[TrialKey, ...]
    asking: AskingSettings | None = None
    recorded: Mapping[str, tuple[SpatialRelation, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class _Done:
    """What a worker tells of a job: trials done, and what stopped it, if anything did."""

    trials: int
    fault: str | None = None


def run_sweep(
    sweep: Sweep,
    folder: RunFolder,
    *,
    backend: str = "joblib",
    workers: int = 1,
    address: str | None = None,
    progress: Callable[[SweepProgress], None] | None = None,
) -> None:
    """Run the trials that are not in the folder yet.

    Parameters
    ----------
    folder
        Where they go, each as soon as it is done. On a cluster it lies on a file system that all
        workers share.
    workers
        How many processes, > 0; a cluster at an address has its own.
    address
        Address of the cluster, for the backends that take one.
    progress
        Called at the beginning and after each group of trials.

    Raises
    ------
    SloopError
        When a trial cannot be run or written; what is done is kept.
    WorkersLost
        When workers are killed time and again without one trial being done.
    """
    run, lost = BACKENDS[backend], 0
    total = sum(1 for _ in sweep.all_keys())
    done = len(_finished(sweep, folder))
    clock = _Clock()
    if progress:
        progress(SweepProgress(done, total, None))
    if workers > 1 and done < total:
        compile_ahead(sweep.searching)
    while done < total:
        before, jobs = done, _jobs(sweep, _finished(sweep, folder))
        try:
            work = partial(
                _work, folder=str(folder.parts), searching=sweep.searching, driver=Driver.this()
            )
            for result in run(work, jobs, workers=workers, address=address):
                if result.fault is not None:
                    raise OutputError(result.fault)
                done += result.trials
                if progress:
                    progress(SweepProgress(done, total, clock.seconds_left(done, total)))
        except WorkersLost as error:
            done = len(_finished(sweep, folder))
            lost = 0 if done > before else lost + 1
            if lost == _PATIENCE:
                raise WorkersLost(
                    f"{error}, {_PATIENCE} times in a row without a trial being done; is there "
                    "memory enough for so many workers? Give fewer with --workers"
                ) from error
            continue
        done = len(_finished(sweep, folder))
        if done < total:
            raise OutputError(
                f"{total - done} trials were done but are not in '{folder.parts}'; expected a "
                "folder that all workers share: choose one on a file system that the cluster sees"
            )


class _Clock:
    """Tells how long the rest takes; the time until the first result is the workers' start."""

    def __init__(self) -> None:
        self._first: tuple[float, int] | None = None

    def seconds_left(self, done: int, total: int) -> float | None:
        """Return the seconds that the trials still to be done take at the pace so far."""
        now = time.monotonic()
        if self._first is None:
            self._first = now, done
        begun, before = self._first
        if done == before:
            return 0.0 if done == total else None
        return (now - begun) / (done - before) * (total - done)


def _finished(sweep: Sweep, folder: RunFolder) -> set[TrialKey]:
    asked = set(sweep.all_keys())
    return {trial.key for trial in folder.trials()} & asked


def _jobs(sweep: Sweep, finished: set[TrialKey]) -> list[_Job]:
    """Return what is left to do, the long jobs first."""
    models: dict[tuple[str, str], bytes] = {}
    jobs = []
    everyone = [searched.annotated for searched in sweep.descriptions]
    for searched in sweep.descriptions:
        for name in sweep.models:
            left = tuple(key for key in sweep.keys(searched.annotated, name) if key not in finished)
            if left:
                at = name, searched.annotated.map
                models[at] = models.get(at) or pickled_model(sweep.model(*at))
                recorded: Mapping[str, tuple[SpatialRelation, ...]] = {}
                if sweep.asking is not None:
                    seed = sweep.searching.seed
                    recorded = recorded_of(searched.annotated, everyone, sweep.asking, seed)
                jobs.append(
                    _Job(searched, searched.city.digest, models[at], left, sweep.asking, recorded)
                )
    slow = {"uniform": 0}  # wherever the robot looks, it has learnt little
    return sorted(jobs, key=lambda job: slow.get(job.keys[0].model, 1))


def _work(job: _Job, *, folder: str, searching: Searching, driver: Driver) -> _Done:
    """Do a job in a worker, writing each trial as soon as it is done."""
    done = 0
    with one_thread(stoppable=driver.is_this), working_in(Path(folder).parent, driver):
        try:
            city = _CITIES.setdefault(job.map_digest, job.searched.city)
            annotated = job.searched.annotated
            if job.asking is not None:
                trials = AskingTrials(
                    annotated, job.searched.description, city, unpickled_model(job.model),
                    searching, job.asking, job.recorded,
                )  # fmt: skip
                for key in job.keys:
                    append_trial(folder, trials.trial(key))
                    done += 1
                return _Done(done)
            beliefs = beliefs_of(
                annotated, job.searched.description, city, unpickled_model(job.model)
            )
            for key in job.keys:
                append_trial(folder, trial_of(key, annotated, city, beliefs[key.target], searching))
                done += 1
        except SloopError as error:  # some cannot be pickled, so the words have to do
            return _Done(done, str(error))
    return _Done(done)
