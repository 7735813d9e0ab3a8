"""Learn a model's parameters from descriptions of targets whose cells are known."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, is_dataclass, replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, gather_evidence, ground_description
from sloop_ppl.models.likelihoods import Parameter, parameters_of, with_values
from sloop_ppl.models.likelihoods.parameters import share_parameter
from sloop_ppl.models.logspace import log_normalise
from sloop_ppl.models.tuning import with_parameters
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["Example", "Fitted", "fit", "log_scores"]

_ROUND = 5
_PATIENCE = 3

_MODEL = (
    share_parameter("lapse", 0.1, "probability that a phrase is wrong"),
    share_parameter("temper", 0.5, "how far a component of several phrases is tempered"),
)
_KAPPA = Parameter(
    "kappa", "1", 0.0, math.inf, 4.0, 0.7, "concentration around the likeliest front"
)


@dataclass(frozen=True, eq=False)
class Example:
    """A description and where its targets truly are.

    Parameters
    ----------
    description : what was said.
    city : the map.
    cells : target -> row (row 0 in the south) and column; targets left out teach nothing.
    """

    description: Description
    city: CityMap
    cells: Mapping[str, tuple[int, int]]


@dataclass(frozen=True, eq=False)
class Fitted:
    """Parameters that were learnt, and how.

    Parameters
    ----------
    model : name of the model they are of.
    parameters : section -> name -> value, as ``with_parameters`` takes them.
    provenance : numbers of examples and targets, scores before and after, iterations.
    """

    model: str
    parameters: Mapping[str, Mapping[str, float]]
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def apply(self, model: Preset) -> Preset:
        """Return a model with these parameters."""
        return with_parameters(model, self.parameters)

    def save(self, path: str | Path) -> None:
        """Write them as JSON, which ``--params`` and ``load_parameters`` read.

        Raises
        ------
        OutputError : when the file cannot be written, or does not end in .json.
        """
        check_output(path, (".json",))
        told = {
            "model": self.model,
            "parameters": self.parameters,
            "provenance": self.provenance,
        }
        with written_whole(path) as temporary:
            temporary.write_text(json.dumps(told, indent=2, allow_nan=False) + "\n", "utf-8")


def fit(
    examples: Sequence[Example],
    model: Preset,
    *,
    learn: Sequence[str] | None = None,
    held_out: Sequence[Example] = (),
    iterations: int = 60,
    progress: Callable[[str], None] | None = None,
) -> Fitted:
    """Maximise the log score of the known cells plus the log prior of the parameters.

    Parameters
    ----------
    examples : what is learnt from.
    model : the model whose parameters are learnt, from where they stand.
    learn : names of what is learnt: parameters that the likelihood declares, ``lapse``,
        ``temper``, ``kappa`` (of the frames) and ``weights``; all that the model has when None.
    held_out : examples that tell when to stop: after three rounds of five iterations without a
        better score the best parameters so far are returned; without any, no early stop.
    iterations : at most this many of L-BFGS, > 0.
    progress : told a line per round.

    Returns
    -------
    Fitted
        A reloadable set of parameters.

    Raises
    ------
    InputError : when no example knows a cell, or there is nothing to learn by this name.

    Notes
    -----
    Each parameter is a standard normal number of its declared prior, in float64: the log (or,
    within a finite range, the log odds) of the value less that of the median, over the scale.
    Mixture weights are a softmax of standard normal numbers around the model's own. Under
    ``truth`` normalisation widths can still be learnt, since the score is of the cell.
    """
    free = _Free(model, learn)
    rows = _grouped(examples, model)
    checks = _grouped(held_out, model)
    z = free.start.clone().requires_grad_(True)

    def loss() -> Tensor:
        scores = torch.cat([_scores(free.at(z), free.log_weights(z), group) for group in rows])
        return 0.5 * (z - free.centre).square().sum() - scores.sum()

    def score(groups: list[_Group]) -> float:
        with torch.no_grad():
            made, weights = free.at(z), free.log_weights(z)
            return float(torch.cat([_scores(made, weights, group) for group in groups]).mean())

    before = score(rows)
    optimiser = torch.optim.LBFGS([z], max_iter=_ROUND, line_search_fn="strong_wolfe")

    def closure() -> Tensor:
        optimiser.zero_grad()
        value = loss()
        value.backward()
        return value

    best, best_z, waited, done, last = -math.inf, z.detach().clone(), 0, 0, math.inf
    while done < iterations and waited < _PATIENCE:
        value = float(optimiser.step(closure).detach())
        done += _ROUND
        now = score(checks or rows)
        if progress:
            progress(f"{done} iterations: mean log score {now:.4f}")
        if math.isfinite(now) and now > best + 1e-5:
            best, best_z, waited = now, z.detach().clone(), 0
        else:
            waited += 1
        if abs(last - value) < 1e-6:
            break
        last = value
    with torch.no_grad():
        z.copy_(best_z)
    provenance = {
        "objective": "log score of known cells plus log prior",
        "examples": len(examples),
        "targets": sum(len(group.cells) for group in rows),
        "held_out": len(held_out),
        "iterations": done,
        "mean_log_score_before": before,
        "mean_log_score_after": score(rows),
    }
    return Fitted(model.name, free.values(best_z), provenance)


def log_scores(examples: Sequence[Example], model: Preset) -> Tensor:
    """Return the log belief at each known cell, map by map, shape (n,)."""
    with torch.no_grad():
        return torch.cat([_scores(model, None, g) for g in _grouped(examples, model)])


@dataclass(frozen=True, eq=False)
class _Group:
    """All known targets of one map: their terms, and the index of each one's cell."""

    city: CityMap
    terms: list[Any]
    cells: Tensor


def _grouped(examples: Sequence[Example], model: Preset) -> list[_Group]:
    """Gather the examples by map, targets of which nothing was said left out."""
    by_map: dict[str, tuple[CityMap, list[Any], list[int]]] = {}
    for example in examples:
        grounded = ground_description(example.description, example.city, model)
        city, terms, cells = by_map.setdefault(example.city.digest, (example.city, [], []))
        for target, (row, col) in example.cells.items():
            if grounded.get(target):
                terms.append(grounded[target])
                cells.append(row * city.grid.n_cols + col)
    groups = [_Group(city, t, torch.tensor(c)) for city, t, c in by_map.values() if t]
    if examples and not groups:
        raise InputError("No example says anything of a target whose cell is known")
    return groups


def _scores(model: Preset, log_weights: Tensor | None, group: _Group) -> Tensor:
    """Return the log belief at the known cells, differentiable, shape (N,)."""
    evidence = gather_evidence(group.terms, group.city, model)
    weight = evidence.log_weight
    if log_weights is not None:
        weight = log_normalise(torch.where(torch.isfinite(weight), log_weights, -math.inf))
    rows = evidence.log_truth[0].sum(2) + evidence.log_normaliser[0]
    log_p = log_normalise(torch.logsumexp(weight[..., None] + rows, 1))
    return log_p[torch.arange(len(group.cells)), group.cells]


class _Free:
    """What is learnt of a model, as standard normal numbers."""

    def __init__(self, model: Preset, learn: Sequence[str] | None) -> None:
        if model.needs_truth or model.shared_frames or model.error_m:
            raise InputError(
                f"Model '{model.name}' is told the truth, shares frames or an error; such a model "
                "cannot be fitted"
            )
        self._model = model
        declared = {p.name: ("likelihood", p) for p in parameters_of(model.likelihood)}
        declared |= {p.name: ("model", p) for p in _MODEL}
        prior: Any = model.frame_prior
        spread = is_dataclass(prior) and hasattr(prior, "kappa")
        if spread and model.normalisation != "speaker":
            declared["kappa"] = ("frames", _KAPPA)
        known = [*declared, *(["weights"] if len(model.components) > 1 else [])]
        names = known if learn is None else list(learn)
        for name in names:
            if name not in known:
                raise InputError(
                    f"'{name}' of model '{model.name}' cannot be learnt; expected one of "
                    f"{', '.join(known)}"
                )
        self._learnt = [(*declared[name], name) for name in names if name in declared]
        self._weights = "weights" in names
        own = torch.tensor([part.weight for part in model.components], dtype=torch.float64).log()
        numbers = [_to_normal(p, self._now(section, p)) for section, p, _ in self._learnt]
        start = torch.tensor(numbers, dtype=torch.float64)
        extra = own if self._weights else own[:0]
        self.start = torch.cat([start, extra])
        self.centre = torch.cat([torch.zeros_like(start), extra])
        if not len(self.start):
            raise InputError(f"Model '{model.name}' has nothing to learn")

    def at(self, z: Tensor) -> Preset:
        """Return the model at these numbers, its parameters tensors."""
        sections: dict[str, dict[str, Any]] = {"likelihood": {}, "model": {}, "frames": {}}
        for i, (section, parameter, name) in enumerate(self._learnt):
            sections[section][name] = _from_normal(parameter, z[i])
        model = replace(self._model, **sections["model"])
        likelihood = with_values(model.likelihood, sections["likelihood"])
        prior: Any = model.frame_prior
        if sections["frames"]:
            prior = replace(prior, **sections["frames"])
        return replace(model, likelihood=likelihood, frame_prior=prior)

    def log_weights(self, z: Tensor) -> Tensor | None:
        """Return the log weights of the components, or None when they are not learnt."""
        return torch.log_softmax(z[len(self._learnt) :], -1) if self._weights else None

    def values(self, z: Tensor) -> dict[str, dict[str, float]]:
        """Return the parameters as numbers, by section."""
        told: dict[str, dict[str, float]] = {}
        for i, (section, parameter, name) in enumerate(self._learnt):
            told.setdefault(section, {})[name] = float(_from_normal(parameter, z[i]))
        weights = self.log_weights(z)
        if weights is not None:
            parts = self._model.components
            told["weights"] = {p.name: float(w.exp()) for p, w in zip(parts, weights, strict=True)}
        return told

    def _now(self, section: str, parameter: Parameter) -> float:
        owner: Any = {
            "likelihood": self._model.likelihood,
            "model": self._model,
            "frames": self._model.frame_prior,
        }[section]
        value = float(getattr(owner, parameter.name))
        # At its bound (no lapse, no tempering) a number starts from its prior's median.
        return value if parameter.low < value < parameter.high else parameter.prior_median


def _scaled(parameter: Parameter, value: Tensor) -> Tensor:
    low = torch.log(value - parameter.low)
    return low if math.isinf(parameter.high) else low - torch.log(parameter.high - value)


def _to_normal(parameter: Parameter, value: float) -> float:
    both = torch.tensor([value, parameter.prior_median], dtype=torch.float64)
    at, median = _scaled(parameter, both)
    return float((at - median) / parameter.prior_scale)


def _from_normal(parameter: Parameter, z: Tensor) -> Tensor:
    median = _scaled(parameter, torch.tensor(parameter.prior_median, dtype=torch.float64))
    moved = median + parameter.prior_scale * z
    if math.isinf(parameter.high):
        return parameter.low + torch.exp(moved)
    return parameter.low + (parameter.high - parameter.low) * torch.sigmoid(moved)
