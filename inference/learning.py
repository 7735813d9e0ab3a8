"""Learn a model's parameters from descriptions of targets whose cells are known."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import torch
from torch import Tensor

from sloop_ppl.errors import InputError, SloopError
from sloop_ppl.inference._free_parameters import FreeParameters
from sloop_ppl.inference._supervised_scores import (
    Example,
    SupervisedScore,
    belief_scores,
    supervised_score,
)
from sloop_ppl.models import ObservationModel
from sloop_ppl.models.likelihoods import summed_within
from sloop_ppl.models.tuning import with_parameters
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["Example", "Fitted", "curvature", "fit", "log_scores", "maximise"]

_ROUND = 5  # steps of L-BFGS between two looks at the held-out score
_PATIENCE = 3  # rounds without a gain before the fit ends
_95_PERCENT = 1.959964  # quantile .975 of the standard normal
_CLOSE = 1e-4
"""Gain of a round, in nats of all examples together, below which the fit ends."""

_WITHIN = 1e-3
"""How exactly frames are summed out on the way to the maximum, in nats of a cell."""

_EXACTLY = 1e-9
"""The same for scores that are told, and where gradients are subtracted from one another."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Parameters that were learnt, and how.

    Parameters
    ----------
    model
        Name of the model they are of.
    parameters
        Section -> name -> value, as ``with_parameters`` takes them.
    intervals
        Section -> name -> ends of a 95 % interval by Laplace's approximation; empty when none were
        asked for, or held-out examples stopped the fit short of the maximum.
    provenance
        Numbers of examples and targets, scores before and after, iterations; how far each number
        ``moved`` from the middle of its prior, in standard deviations of the prior.
    """

    model: str
    parameters: Mapping[str, Mapping[str, float]]
    intervals: Mapping[str, Mapping[str, tuple[float, float]]] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def apply(self, model: ObservationModel) -> ObservationModel:
        """Return a model with these parameters."""
        return with_parameters(model, self.parameters)

    def to_json(self) -> dict[str, Any]:
        """Return what `save` writes."""
        return {
            "model": self.model,
            "parameters": self.parameters,
            "intervals": self.intervals,
            "provenance": self.provenance,
        }

    def save(self, path: str | Path) -> None:
        """Write them as JSON, which ``--params`` and ``load_parameters`` read.

        Raises
        ------
        OutputError
            When the file cannot be written, or does not end in .json.
        """
        check_output(path, (".json",))
        with written_whole(path) as temporary:
            payload = json.dumps(self.to_json(), indent=2, allow_nan=False)
            temporary.write_text(payload + "\n", "utf-8")


def fit(
    examples: Sequence[Example],
    model: ObservationModel,
    *,
    learn: Sequence[str] | None = None,
    held_out: Sequence[Example] = (),
    iterations: int = 60,
    intervals: bool = True,
    progress: Callable[[str], None] | None = None,
) -> Fitted:
    """Maximise a log score of the known cells plus the log prior of the parameters.

    Parameters
    ----------
    examples
        What is learnt from.
    model
        The model whose parameters are learnt, from where they stand.
    learn
        Names of what is learnt: parameters that the likelihood declares, ``lapse``, ``temper``,
        ``kappa`` and ``absolute`` (of the frames) and ``weights``; when None all that the model
        has but those whose `Parameter` is not learnt by default.
    held_out
        Examples that tell when to stop: after three rounds of five iterations without a better
        score the best parameters so far are returned; without any, no early stop.
    iterations
        At most this many of L-BFGS, > 0.
    intervals
        False to leave them out: they take two more gradients for each number learnt.
    progress
        Called with a line per round.

    Returns
    -------
    Fitted
        A reloadable set of parameters.

    Raises
    ------
    InputError
        When no example knows a cell, there is nothing to learn by this name, or the score is not a
        number.

    Notes
    -----
    The score of a model that gives words a probability (``speaker`` normalisation, plain products
    and ``uninformative``) is the log probability of what was said given the known cell: a
    likelihood of its parameters. Any other is scored by the log belief at the known cell. (The
    probability that the phrases are true would not do: it grows with every width.)

    Parameters are learnt as standard normal numbers of their declared priors; see
    :class:`sloop_ppl.inference._free_parameters.FreeParameters`. An interval is the maximum plus
    and minus 1.96 standard deviations of the Gaussian of the same curvature, in those numbers.
    """
    free = FreeParameters(model, learn)
    score = supervised_score(examples, free)
    checks = supervised_score(held_out, free) if held_out else None
    z, stats = maximise(free, score, checks=checks, iterations=iterations, progress=progress)
    covariance = curvature(free, score, z) if intervals and checks is None else None
    ends = {} if covariance is None else free.intervals(z, covariance, _95_PERCENT)
    provenance = {
        "objective": f"{score.score_name} plus log prior",
        "examples": len(examples),
        "targets": score.size,
        "held_out": len(held_out),
        **stats,
        "moved": {
            name: float(away) for name, away in zip(free.names, z - free.centre, strict=True)
        },
    }
    values = {name: float(value) for name, value in free.values(z).items()}
    return Fitted(model.name, free.by_section(values), free.by_section(ends), provenance)


def maximise(
    free: FreeParameters,
    score: SupervisedScore,
    *,
    checks: SupervisedScore | None = None,
    iterations: int,
    progress: Callable[[str], None] | None = None,
) -> tuple[Tensor, dict[str, Any]]:
    """Return the numbers of the greatest score plus log prior, shape (P,), and how it went.

    Parameters
    ----------
    score, checks
        What it is learnt from, and what tells when to stop.
    iterations
        At most this many of L-BFGS, > 0.
    progress
        Told a line per round.

    Raises
    ------
    InputError
        When the score or its gradient is not a number where it starts.

    Notes
    -----
    On the way frames are summed out to .001 nats of a cell (`summed_within`), which spares most
    directions of a likelihood without a closed form. The scores told of the start and the end are
    those of the full sum, and so is what the held-out examples say.
    """
    z = free.start.clone()

    def mean_score(of: SupervisedScore) -> float:
        with torch.no_grad(), summed_within(_EXACTLY):
            return float(of.scores(free, z, {}).mean())

    before = mean_score(score)
    if not math.isfinite(before):
        raise InputError(
            f"The {score.score_name} is {before} under model '{free.model.name}'; expected a "
            "finite number: give the model a lapse, or a likelihood that nowhere is 0"
        )
    z.requires_grad_(True)
    descent = _Descent(free, score, z)
    optimiser = torch.optim.LBFGS([z], max_iter=_ROUND, line_search_fn="strong_wolfe")
    best, best_z, waited, done, last = -math.inf, z.detach().clone(), 0, 0, math.inf
    while done < iterations and waited < _PATIENCE:
        optimiser.step(descent)
        done += _ROUND
        value, mean = descent.now()
        if checks is not None:
            mean = mean_score(checks)
        now = -value if checks is None else mean
        if progress:
            progress(f"{done} iterations: mean log score {mean:.4f}")
        if math.isfinite(now) and now > best + 1e-5:
            best, best_z, waited = now, z.detach().clone(), 0
        else:
            waited += 1
        if abs(last - value) < _CLOSE:
            break
        last = value
    with torch.no_grad():
        z.copy_(best_z)
    return best_z, {
        "iterations": done,
        "steps_refused": descent.refused,
        "mean_log_score_before": before,
        "mean_log_score_after": mean_score(score),
    }


class _Met(NamedTuple):
    """What was found at some numbers: the loss, the mean score, and the loss's gradient."""

    loss: float
    mean_score: float
    gradient: Tensor


class _Descent:
    """The loss that L-BFGS descends, with a value and a gradient wherever a step may lead.

    Parameters
    ----------
    free
        What is learnt.
    score
        What it is learnt from.
    z
        The numbers, shape (P,), which the optimiser moves.

    Attributes
    ----------
    refused
        How many steps led to no number.
    """

    def __init__(self, free: FreeParameters, score: SupervisedScore, z: Tensor) -> None:
        self._free, self._score, self._z = free, score, z
        self._met: dict[bytes, _Met] = {}
        self._last, self._worst = z.detach().clone(), -math.inf
        self.refused = 0

    def __call__(self) -> Tensor:
        """Return the loss and leave its gradient with the numbers.

        A step to where the score or its gradient is no number, or a parameter leaves its range,
        meets a slope that leads back, above all that was met before: the line search shortens it.
        """
        met = self._met.get(self._key)
        if met is None:
            met = self._found()
            if not self._met:
                self._check_start(met)
            if not (math.isfinite(met.loss) and bool(met.gradient.isfinite().all())):
                self.refused += 1
                away = self._z.detach() - self._last
                self._z.grad = 2 * away
                return self._worst + 1 + away.square().sum()
            self._met[self._key] = met
            self._last, self._worst = self._z.detach().clone(), max(self._worst, met.loss)
        self._z.grad = met.gradient.clone()
        return torch.tensor(met.loss, dtype=torch.float64)

    def _check_start(self, met: _Met) -> None:
        """Refuse a start whose gradient leads nowhere."""
        named = zip(self._free.names, met.gradient, strict=True)
        astray = [name for name, slope in named if not bool(slope.isfinite())]
        if astray:
            raise InputError(
                f"The {self._score.score_name} has no gradient in {', '.join(astray)} under model "
                f"'{self._free.model.name}' where the fit starts; expected finite numbers: "
                "check_likelihood tries a likelihood's gradients"
            )

    def now(self) -> tuple[float, float]:
        """Return the loss and the mean score where the numbers are; NaN where there is none."""
        met = self._met.get(self._key) or self._found()
        return met.loss, met.mean_score

    @property
    def _key(self) -> bytes:
        # L-BFGS asks again for what it has been told: where each of its rounds starts.
        return self._z.detach().numpy().tobytes()

    def _found(self) -> _Met:
        z = self._z
        z.grad = None
        try:
            with torch.enable_grad(), summed_within(_WITHIN):
                scores = self._score.scores(self._free, z, {})
                loss = 0.5 * (z - self._free.centre).square().sum() - scores.sum()
                (gradient,) = torch.autograd.grad(loss, z)
        except SloopError:
            if not self._met:
                raise  # where it starts a mistake is one
            return _Met(math.nan, math.nan, torch.zeros_like(z))
        return _Met(float(loss.detach()), float(scores.detach().mean()), gradient)


def curvature(free: FreeParameters, score: SupervisedScore, z: Tensor) -> Tensor | None:
    """Return the covariance of the numbers by Laplace's approximation, shape (P, P).

    None where the score plus log prior does not curve down in every direction, as it does not
    away from its maximum. The gradient is differentiated by central differences.
    """
    # Central differences err by step^2 / 6 = 2e-9 of the third derivative, and by the error of the
    # gradients over the step, 1e-9 / 1e-4 = 1e-5: small beside the prior's own curvature, one.
    step = 1e-4
    rows = []
    for i in range(len(z)):
        sides = []
        for sign in (1.0, -1.0):
            at = z.clone()
            at[i] += sign * step
            at.requires_grad_(True)
            with torch.enable_grad(), summed_within(_EXACTLY):
                loss = 0.5 * (at - free.centre).square().sum() - score.scores(free, at, {}).sum()
                sides.append(torch.autograd.grad(loss, at)[0])
        rows.append((sides[0] - sides[1]) / (2 * step))
    hessian = torch.stack(rows)
    factor, failed = torch.linalg.cholesky_ex((hessian + hessian.T) / 2)
    return None if failed else torch.cholesky_inverse(factor)


def log_scores(examples: Sequence[Example], model: ObservationModel) -> Tensor:
    """Return the log belief at each known cell, map by map, shape (n,)."""
    return belief_scores(examples, model)
