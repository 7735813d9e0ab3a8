"""Compare engines on one description, and models by the evidence of what was said."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import softmax

from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.inference.engines import ENGINES, Engine, engine_of
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.inference.posterior import Posterior
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel, preset
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from rich.table import Table

__all__ = ["EngineComparison", "EngineRun", "ModelScore", "compare", "rank_models"]


@dataclass(frozen=True, eq=False)
class EngineRun:
    """How one engine did.

    Parameters
    ----------
    engine
        Its name.
    total_variation
        Target -> total variation of its belief from the exact one, in [0, 1]; empty when it could
        not run.
    log_evidence
        Its estimate of the log evidence; None when it could not run.
    seconds
        Wall time of one inference, the first call of all excepted.
    refused
        Why it could not run; None when it could.
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
    model
        The model's name.
    reference
        The engine that the others are compared with.
    runs
        One per engine.
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
    model: str | ObservationModel = "bayes",
    engines: Sequence[str | Engine] | None = None,
    *,
    prior: Any = None,
    rng: np.random.Generator,
    reference: str | Engine = "exact",
) -> EngineComparison:
    """Infer from one description with several engines.

    Parameters
    ----------
    description
        What was said.
    city
        The map.
    model
        A model's name, or an ObservationModel.
    engines
        Names of engines, or engines with options; all that are registered when None.
    prior
        Belief before anything was said; see :func:`sloop_ppl.inference.log_priors`.
    rng
        Where engines that draw do so, each from a stream of its own name.
    reference
        The engine that counts as right.

    Returns
    -------
    EngineComparison
        An engine that refuses the model keeps its row, with the reason.

    Raises
    ------
    UnknownName
        When there is no such engine or model.
    """
    chosen = preset(model)
    # An unknown name is refused before the work.
    first = engine_of(reference)
    if isinstance(engines, str) or not isinstance(engines or (), Iterable):
        raise InputError(
            f"engines is {engines!r}; expected several of them, such as ['enumerate', 'importance']"
        )
    others = [engine_of(engine) for engine in (ENGINES if engines is None else engines)]
    right, _ = infer_description(
        description, city, chosen, first, prior=prior, rng=child(rng, "engine", first.name)
    )
    runs = [_run(engine, right, description, city, chosen, prior, rng) for engine in others]
    return EngineComparison(chosen.name, first.name, tuple(runs))


def _run(
    engine: Engine,
    right: Posterior,
    description: Description,
    city: CityMap,
    model: ObservationModel,
    prior: Any,
    rng: np.random.Generator,
) -> EngineRun:
    try:
        posterior, info = infer_description(
            description, city, model, engine, prior=prior, rng=child(rng, "engine", engine.name)
        )
    except SloopError as error:
        return EngineRun(engine.name, {}, None, float("nan"), str(error))
    apart = {
        target: float(0.5 * np.abs(posterior.belief(target) - right.belief(target)).sum())
        for target in right.targets
    }
    return EngineRun(engine.name, apart, float(posterior.log_evidence), info.seconds)


@dataclass(frozen=True)
class ModelScore:
    """How well one model predicted what was said.

    Parameters
    ----------
    name
        What the model is called in the comparison.
    log_evidence
        Log probability of what was said, natural.
    bits_behind
        How many bits it is behind the best, >= 0.
    p
        Its probability when all were equally likely before.
    """

    name: str
    log_evidence: float
    bits_behind: float
    p: float


def rank_models(
    posteriors: Sequence[Posterior] | Mapping[str, Posterior],
) -> tuple[ModelScore, ...]:
    """Rank models by the probability they gave to what was said, best first.

    Parameters
    ----------
    posteriors
        One posterior per model, of the same descriptions on the same map from the same prior; by
        name, or named by their models.

    Raises
    ------
    InputError
        When there are none; when one is not normalised over what could have been said; or when they
        are not about the same words, map, prior and sensing.

    Notes
    -----
    The evidence of a model with ``truth`` or ``map`` normalisation is no probability of what was
    said, so it ranks nothing.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> from sloop_ppl.models import speaker_of
    >>> models = (speaker_of("bayes"), speaker_of("sloop-m4"))
    >>> posts = [sloop.infer("The red bike is near Ivy.", "cleveland", model=m) for m in models]
    >>> [score.bits_behind >= 0 for score in rank_models(posts)]
    [True, True]
    """
    named = _named(posteriors)
    (first_name, first), *others = named.items()
    for name, posterior in named.items():
        if posterior.model.normalisation != "speaker":
            raise InputError(
                f"Model '{name}' has '{posterior.model.normalisation}' normalisation, so its log "
                "evidence ranks no models; expected 'speaker' for all of them: "
                "dataclasses.replace(model, normalisation='speaker')"
            )
    for name, posterior in others:
        differs = _difference(first, posterior)
        if differs:
            raise InputError(
                f"Models '{first_name}' and '{name}' cannot be ranked: they differ in {differs}; "
                "infer both from the same"
            )
    scores = np.array([float(posterior.log_evidence) for posterior in named.values()])
    best = scores.max()
    ranked = [
        ModelScore(name, float(score), float((best - score) / math.log(2)), float(p))
        for name, score, p in zip(named, scores, softmax(scores), strict=True)
    ]
    return tuple(sorted(ranked, key=lambda score: -score.log_evidence))


def _named(posteriors: Sequence[Posterior] | Mapping[str, Posterior]) -> dict[str, Posterior]:
    if isinstance(posteriors, Mapping):
        named = dict(posteriors)
    else:
        named = {posterior.model.name: posterior for posterior in posteriors}
        if len(named) < len(posteriors):
            raise InputError(
                "Two of the posteriors have models of the same name; give a mapping of name to "
                "posterior"
            )
    if not named:
        raise InputError("There is no posterior to rank; expected at least one")
    return named


def _difference(one: Posterior, other: Posterior) -> str:
    """Return what two posteriors were told differently, or nothing."""
    if one.city.digest != other.city.digest:
        return "their map"
    if one.descriptions != other.descriptions:
        return "what was said"
    if one.model.joint_grounds != other.model.joint_grounds and any(
        len(r.grounds) > 1 for d in one.descriptions for r in d.relations
    ):
        return "how many phrases a relation to several grounds is (joint_grounds)"
    for mine, theirs, what in (
        (one.log_prior, other.log_prior, "their prior"),
        (one.log_sensed, other.log_sensed, "what was sensed"),
    ):
        if set(mine) != set(theirs) or any(not np.array_equal(mine[t], theirs[t]) for t in mine):
            return what
    return ""
