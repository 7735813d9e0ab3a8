"""The trials of a finished sweep, ready to be averaged."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._bootstrap import clustered_interval
from sloop_ppl.eval._facts import TargetFacts
from sloop_ppl.eval._run_folder import RunFolder, read_run
from sloop_ppl.eval._tables import Estimate
from sloop_ppl.eval.trials import Searching, Trial

__all__ = ["Results", "TargetKey", "read_results", "reward_summary"]

TargetKey = tuple[str, str]
"""Ids of a description and of one of its targets."""


@dataclass(frozen=True)
class Results:
    """A finished sweep.

    Parameters
    ----------
    folder
        Where it lies.
    trials
        All its trials, sorted by key.
    """

    folder: RunFolder
    trials: tuple[Trial, ...]

    @property
    def manifest(self) -> Mapping[str, Any]:
        """What the sweep was made of."""
        return self.folder.manifest

    @property
    def models(self) -> tuple[str, ...]:
        """The models, in the order in which they were asked for."""
        return tuple(self.manifest["model_names"])

    @property
    def ranges(self) -> tuple[float, ...]:
        """The ranges of the sensor, cells."""
        return tuple(self.manifest["ranges_cells"])

    @property
    def primary(self) -> tuple[str, str, float]:
        """The two models and the range of the comparison named before the run."""
        first, second = self.manifest["primary"]["models"]
        return first, second, float(self.manifest["primary"]["range_cells"])

    @property
    def table_range(self) -> float:
        """The range of the paper's tables, 3 cells, where it was run; else the first."""
        return 3.0 if 3.0 in self.ranges else self.ranges[0]

    @property
    def label(self) -> str:
        """What tells this sweep from others on the same descriptions."""
        searching, starts = Searching(**self.manifest["searching"]), self.manifest["starts"]
        fan = "" if searching.fov_deg == 90 else f", fan {searching.fov_deg:g}°"
        fitted = ", fitted without the line's city" if self.manifest["cv"] else ""
        return (
            f"{searching.label}{fan}; {self.manifest['relations']} relations{fitted}; "
            f"{starts} start{'s' if starts > 1 else ''}"
        )

    @cached_property
    def facts(self) -> Mapping[TargetKey, TargetFacts]:
        """What was said of each target, in file order."""
        return {(f.description, f.target): f for f in self.folder.targets}

    @cached_property
    def _by_cell(self) -> Mapping[tuple[str, float], tuple[Trial, ...]]:
        cells: dict[tuple[str, float], list[Trial]] = {}
        asked = self.manifest.get("asking")
        plain = int(asked["questions"][0]) if asked else 0
        cost = float(asked["question_costs"][0]) if asked and plain else 0.0
        for trial in self.trials:
            if (trial.key.questions, trial.key.question_cost) != (plain, cost):
                continue
            cells.setdefault((trial.key.model, trial.key.range_cells), []).append(trial)
        return {key: tuple(found) for key, found in cells.items()}

    def of(self, model: str, range_cells: float) -> tuple[Trial, ...]:
        """Return the trials of a model at a range."""
        return self._by_cell.get((model, range_cells), ())

    def rewards(
        self, model: str, range_cells: float, targets: Iterable[TargetKey] | None = None
    ) -> dict[TargetKey, float]:
        """Return target -> discounted reward, averaged over its starts.

        Parameters
        ----------
        model, range_cells
            Whose trials.
        targets
            Those wanted; all when None.
        """
        sums: dict[TargetKey, list[float]] = {}
        for trial in self.of(model, range_cells):
            key = trial.key.description, trial.key.target
            sums.setdefault(key, []).append(trial.discounted_reward)
        wanted = self.facts if targets is None else targets
        return {key: float(np.mean(sums[key])) for key in wanted if key in sums}

    def clusters(self, targets: Iterable[TargetKey]) -> list[tuple[str, str]]:
        """Return map and configuration of some targets."""
        return [(self.facts[t].map, self.facts[t].configuration) for t in targets]

    def estimate(self, values: Mapping[TargetKey, float]) -> Estimate:
        """Return the mean of a value per target, with an interval by bootstrap."""
        return self._bootstrapped(list(values.values()), self.clusters(values))

    def estimate_trials(self, trials: Sequence[Trial]) -> Estimate:
        """Return the mean discounted reward of some trials, with an interval by bootstrap."""
        clusters = [(trial.map, trial.configuration) for trial in trials]
        return self._bootstrapped([trial.discounted_reward for trial in trials], clusters)

    def _bootstrapped(self, values: list[float], clusters: list[tuple[str, str]]) -> Estimate:
        ends = clustered_interval(values, clusters, rng=np.random.default_rng(self.seed))
        return Estimate(float(np.mean(values)), *ends)

    def difference(self, first: str, second: str, range_cells: float) -> dict[TargetKey, float]:
        """Return target -> reward of one model less that of another, on the same starts."""
        one, other = self.rewards(first, range_cells), self.rewards(second, range_cells)
        return {target: one[target] - other[target] for target in one}

    @property
    def seed(self) -> int:
        """Seed of the sweep, and of the intervals of its report."""
        return int(self.manifest["searching"]["seed"])


def read_results(path: str | Path) -> Results:
    """Return the sweep in a folder.

    Raises
    ------
    InputError
        When the folder holds no sweep, or one that has not ended.
    """
    folder = read_run(path)
    trials = folder.trials()
    made_of = folder.manifest
    expected = made_of["n_trials"]
    if len(trials) < expected:
        raise InputError(
            f"The sweep in '{path}' has {len(trials)} of its {expected} trials; give the same "
            "`sloop eval search` command again to finish it"
        )
    return Results(folder, tuple(trials))


def reward_summary(results: Results) -> dict[str, Any]:
    """Return what ``sloop eval report --json`` prints of a sweep that does not ask.

    Notes
    -----
    `steps` is the mean over all trials, those that found nothing included.
    """
    models: dict[str, dict[str, Any]] = {}
    for model in results.models:
        models[model] = {}
        for range_cells in results.ranges:
            trials = results.of(model, range_cells)
            reward = results.estimate(results.rewards(model, range_cells))
            models[model][f"{range_cells:g}"] = {
                "n": len(trials),
                "discounted_reward": reward.mean,
                "ci95": [reward.low, reward.high],
                "success": float(np.mean([trial.found for trial in trials])),
                "steps": float(np.mean([trial.steps for trial in trials])),
            }
    return {
        "relations": results.manifest["relations"],
        "planner": results.manifest["searching"]["planner"],
        "models": models,
    }
