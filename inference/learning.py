"""Learn a model's parameters from descriptions of targets whose cells are known."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference.free_parameters import FreeParameters
from sloop_ppl.inference.known_cells import Example, KnownCells, belief_scores, known_cells
from sloop_ppl.models import Preset
from sloop_ppl.models.tuning import with_parameters
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["Example", "Fitted", "curvature", "fit", "log_scores", "maximise"]

_ROUND = 5
_PATIENCE = 3
_95_PERCENT = 1.959964
_CLOSE = 1e-4
"""Gain of a round, in nats of all examples together, below which the fit ends."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Parameters that were learnt, and how.

    Parameters
    ----------
    model : name of the model they are of.
    parameters : section -> name -> value, as ``with_parameters`` takes them.
    intervals : section -> name -> ends of a 95 % interval by Laplace's approximation; empty when
        none were asked for, or held-out examples stopped the fit short of the maximum.
    provenance : numbers of examples and targets, scores before and after, iterations; how far
        each number ``moved`` from the middle of its prior, in standard deviations of the prior.
    """

    model: str
    parameters: Mapping[str, Mapping[str, float]]
    intervals: Mapping[str, Mapping[str, tuple[float, float]]] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def apply(self, model: Preset) -> Preset:
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
        OutputError : when the file cannot be written, or does not end in .json.
        """
        check_output(path, (".json",))
        with written_whole(path) as temporary:
            told = json.dumps(self.to_json(), indent=2, allow_nan=False)
            temporary.write_text(told + "\n", "utf-8")


def fit(
    examples: Sequence[Example],
    model: Preset,
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
    examples : what is learnt from.
    model : the model whose parameters are learnt, from where they stand.
    learn : names of what is learnt: parameters that the likelihood declares, ``lapse``,
        ``temper``, ``kappa`` and ``absolute`` (of the frames) and ``weights``; all that the model
        has when None.
    held_out : examples that tell when to stop: after three rounds of five iterations without a
        better score the best parameters so far are returned; without any, no early stop.
    iterations : at most this many of L-BFGS, > 0.
    intervals : False to leave them out: they take two more gradients for each number learnt.
    progress : told a line per round.

    Returns
    -------
    Fitted
        A reloadable set of parameters.

    Raises
    ------
    InputError : when no example knows a cell, there is nothing to learn by this name, or the
        score is not a number.

    Notes
    -----
    The score of a model that gives words a probability (``speaker`` normalisation, plain products
    and ``idle``) is the log probability of what was said given the known cell: a likelihood of
    its parameters. Any other is scored by the log belief at the known cell. (The probability that
    the phrases are true would not do: it grows with every width.)

    Parameters are learnt as standard normal numbers of their declared priors; see
    :class:`sloop_ppl.inference.free_parameters.FreeParameters`. An interval is the maximum plus
    and minus 1.96 standard deviations of the Gaussian of the same curvature, in those numbers.
    """
    free = FreeParameters(model, learn)
    known = known_cells(examples, free)
    checks = known_cells(held_out, free) if held_out else None
    z, told = maximise(free, known, checks=checks, iterations=iterations, progress=progress)
    covariance = curvature(free, known, z) if intervals and checks is None else None
    ends = {} if covariance is None else free.intervals(z, covariance, _95_PERCENT)
    provenance = {
        "objective": f"{known.told} plus log prior",
        "examples": len(examples),
        "targets": known.size,
        "held_out": len(held_out),
        **told,
        "moved": {
            name: float(away) for name, away in zip(free.names, z - free.centre, strict=True)
        },
    }
    values = {name: float(value) for name, value in free.values(z).items()}
    return Fitted(model.name, free.by_section(values), free.by_section(ends), provenance)


def maximise(
    free: FreeParameters,
    known: KnownCells,
    *,
    checks: KnownCells | None = None,
    iterations: int,
    progress: Callable[[str], None] | None = None,
) -> tuple[Tensor, dict[str, Any]]:
    """Return the numbers of the greatest score plus log prior, shape (P,), and how it went.

    Parameters
    ----------
    free : what is learnt.
    known, checks : what it is learnt from, and what tells when to stop.
    iterations : at most this many of L-BFGS, > 0.
    progress : told a line per round.

    Raises
    ------
    InputError : when the score is not a number where it starts.
    """
    z = free.start.clone().requires_grad_(True)

    def loss() -> Tensor:
        return 0.5 * (z - free.centre).square().sum() - known.scores(free, z, {}).sum()

    def mean_score(of: KnownCells) -> float:
        with torch.no_grad():
            return float(of.scores(free, z, {}).mean())

    before = mean_score(known)
    if not math.isfinite(before):
        raise InputError(
            f"The {known.told} is {before} under model '{free.model.name}'; expected a finite "
            "number: give the model a lapse, or a likelihood that nowhere is 0"
        )
    optimiser = torch.optim.LBFGS([z], max_iter=_ROUND, line_search_fn="strong_wolfe")

    def closure() -> Tensor:
        optimiser.zero_grad()
        value = loss()
        value.backward()
        return value

    best, best_z, waited, done, last = -math.inf, z.detach().clone(), 0, 0, math.inf
    while done < iterations and waited < _PATIENCE:
        optimiser.step(closure)
        done += _ROUND
        with torch.no_grad():
            value = float(loss())
        now = -value if checks is None else mean_score(checks)
        if progress:
            progress(f"{done} iterations: mean log score {mean_score(checks or known):.4f}")
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
        "mean_log_score_before": before,
        "mean_log_score_after": mean_score(known),
    }


def curvature(free: FreeParameters, known: KnownCells, z: Tensor) -> Tensor | None:
    """Return the covariance of the numbers by Laplace's approximation, shape (P, P).

    None where the score plus log prior does not curve down in every direction, as it does not
    away from its maximum. The gradient is differentiated by central differences.
    """
    step = 1e-4
    rows = []
    for i in range(len(z)):
        sides = []
        for sign in (1.0, -1.0):
            at = z.clone()
            at[i] += sign * step
            at.requires_grad_(True)
            loss = 0.5 * (at - free.centre).square().sum() - known.scores(free, at, {}).sum()
            sides.append(torch.autograd.grad(loss, at)[0])
        rows.append((sides[0] - sides[1]) / (2 * step))
    hessian = torch.stack(rows)
    factor, failed = torch.linalg.cholesky_ex((hessian + hessian.T) / 2)
    return None if failed else torch.cholesky_inverse(factor)


def log_scores(examples: Sequence[Example], model: Preset) -> Tensor:
    """Return the log belief at each known cell, map by map, shape (n,)."""
    return belief_scores(examples, model)
