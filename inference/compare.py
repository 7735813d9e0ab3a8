"""Run one description under several engines: how far from exact, and how long each took."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.errors import SloopError
from sloop_ppl.inference.engine import ENGINES
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.inference.posterior import Posterior
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, preset
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from rich.table import Table

__all__ = ["EngineComparison", "EngineRun", "compare"]


@dataclass(frozen=True, eq=False)
class EngineRun:
    """How one engine did.

    Parameters
    ----------
    engine : its name.
    total_variation : target -> total variation of its belief from the exact one, in [0, 1]; empty
        when it could not run.
    log_evidence : its estimate of the log evidence; None when it could not run.
    seconds : wall time of one inference, the first call of all excepted.
    refused : why it could not run; None when it could.
    """

    engine: str
    total_variation: Mapping[str, float]
    log_evidence: float | None
    seconds: float
    refused: str | None = None

    @property
    def worst(self) -> float:
        """The greatest total variation over targets, NaN when the engine could not run."""
        return max(self.total_variation.values(), default=float("nan"))


@dataclass(frozen=True, eq=False)
class EngineComparison:
    """A table of engines; rows in the order they were asked for.

    Parameters
    ----------
    model : the model's name.
    reference : the engine that the others are compared with.
    runs : one per engine.
    """

    model: str
    reference: str
    runs: tuple[EngineRun, ...]

    def __getitem__(self, engine: str) -> EngineRun:
        """Return the run of an engine."""
        return next(run for run in self.runs if run.engine == engine)

    def rows(self) -> list[tuple[str, str, str, str]]:
        """Return engine, total variation, log evidence and seconds of each run, as text."""
        return [
            (run.engine, "-", "-", run.refused)
            if run.refused is not None
            else (run.engine, f"{run.worst:.1e}", f"{run.log_evidence:.4f}", f"{run.seconds:.3g}")
            for run in self.runs
        ]

    def to_markdown(self) -> str:
        """Return the table in Markdown."""
        lines = [self._header(), ("---", "---:", "---:", "---:"), *self.rows()]
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)

    def to_rich(self) -> Table:
        """Return the table for a terminal."""
        from rich.table import Table

        table = Table(box=None, pad_edge=False, header_style="bold", title=f"model {self.model}")
        for i, name in enumerate(self._header()):
            table.add_column(name, justify="right" if i else "left")
        for row in self.rows():
            table.add_row(*row)
        return table

    def __str__(self) -> str:
        return self.to_markdown()

    def _header(self) -> tuple[str, str, str, str]:
        return "engine", f"total variation from {self.reference}", "log evidence", "seconds"


def compare(
    description: Description,
    city: CityMap,
    model: str | Preset = "bayes",
    engines: Sequence[str] | None = None,
    *,
    prior: Any = None,
    rng: np.random.Generator,
    reference: str = "exact",
) -> EngineComparison:
    """Infer from one description with several engines.

    Parameters
    ----------
    description : what was said.
    city : the map.
    model : a model's name, or a Preset.
    engines : names of engines; all that are registered when None.
    prior : belief before anything was said; see :func:`sloop_ppl.inference.log_priors`.
    rng : where engines that draw do so, each from a stream of its own name.
    reference : the engine that counts as right.

    Returns
    -------
    EngineComparison
        An engine that refuses the model keeps its row, with the reason.

    Raises
    ------
    UnknownName : when there is no such engine or model.
    """
    chosen = preset(model)
    names = tuple(ENGINES) if engines is None else tuple(engines)
    for name in (*names, reference):
        ENGINES[name]  # an unknown name is refused before the work
    right, _ = infer_description(
        description, city, chosen, reference, prior=prior, rng=child(rng, "engine", reference)
    )
    runs = [_run(name, right, description, city, chosen, prior, rng) for name in names]
    return EngineComparison(chosen.name, reference, tuple(runs))


def _run(
    engine: str,
    right: Posterior,
    description: Description,
    city: CityMap,
    model: Preset,
    prior: Any,
    rng: np.random.Generator,
) -> EngineRun:
    try:
        posterior, info = infer_description(
            description, city, model, engine, prior=prior, rng=child(rng, "engine", engine)
        )
    except SloopError as error:
        return EngineRun(engine, {}, None, float("nan"), str(error))
    apart = {
        target: float(0.5 * np.abs(posterior.belief(target) - right.belief(target)).sum())
        for target in right.targets
    }
    return EngineRun(engine, apart, float(posterior.log_evidence), info.seconds)
