"""What may be learnt of a model, as numbers that are standard normal under their priors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass, replace
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.models import ObservationModel, latents_of
from sloop_ppl.models.likelihoods import (
    Parameter,
    parameters_of,
    share_parameter,
    with_values,
)
from sloop_ppl.models.simulation import why_not_generative

__all__ = ["FreeParameters"]

_MODEL = (
    share_parameter("lapse", 0.1, "probability that a phrase is wrong"),
    share_parameter("own_lapse", 0.1, "probability that a phrase of one's own place is wrong"),
    # n phrases count as the root of n: a product that is sharper covers less where phrases repeat
    # one another, which few descriptions show, so that the prior is narrow.
    Parameter("temper", "1", 0.0, 1.0, 0.5, 0.3, "how far a component of phrases is tempered"),
)
_FRAMES = (
    Parameter("kappa", "1", 0.0, math.inf, 4.0, 0.7, "concentration around the predicted front"),
    share_parameter("absolute", 0.8, "probability that left and right are those of the map"),
)


class FreeParameters:
    """What is learnt of a model, as P standard normal numbers.

    Parameters
    ----------
    model
        Where the numbers start.
    learn
        Names of what is learnt; when None all that the model has and that are learnt by default.

    Attributes
    ----------
    names
        Name of each number, ``weights:component`` for those of the mixture.
    start, centre
        Where the numbers start, and the mean of their prior, shape (P,).

    Raises
    ------
    InputError
        When a name is unknown, or the model is one that cannot be fitted.

    Notes
    -----
    Each parameter is a standard normal number of its declared prior, in float64: the log (or,
    within a finite range, the log odds) of the value less that of the median, over the scale.
    Mixture weights are a softmax of standard normal numbers around the model's own.
    """

    def __init__(self, model: ObservationModel, learn: Sequence[str] | None) -> None:
        if model.needs_truth or model.shared_frames or model.error_m or latents_of(model):
            raise InputError(
                f"Model '{model.name}' is told the truth, shares frames or an error, or declares "
                "latents; such a model cannot be fitted"
            )
        self.model = model
        self.is_generative = not why_not_generative(model)
        declared = {p.name: ("likelihood", p) for p in parameters_of(model.likelihood)}
        # Words are scored without tempering, and by one lapse.
        left_out = ("temper", "own_lapse") if self.is_generative else ()
        declared |= {
            p.name: ("model", p)
            for p in _MODEL
            if p.name not in left_out and getattr(model, p.name) is not None
        }
        prior: Any = model.frame_prior
        if is_dataclass(prior):
            # A speaker's left and right are those of the ground, as every other word.
            frame_parameters = _FRAMES[:1] if self.is_generative else _FRAMES
            declared |= {p.name: ("frames", p) for p in frame_parameters if hasattr(prior, p.name)}
        known = [*declared, *(["weights"] if len(model.components) > 1 else [])]
        aside = {name for name, (_, parameter) in declared.items() if not parameter.by_default}
        usual = [name for name in known if name not in aside]
        chosen = usual if learn is None else list(dict.fromkeys(learn))
        for name in chosen:
            if name not in known:
                raise InputError(
                    f"'{name}' of model '{model.name}' cannot be learnt; expected one of "
                    f"{', '.join(known)}"
                )
        if not chosen:
            raise InputError(f"Model '{model.name}' has nothing to learn")
        self._learnt = [(*declared[name], name) for name in chosen if name in declared]
        self._parts = [part.name for part in model.components] if "weights" in chosen else []
        shares = [part.weight for part in model.components] if self._parts else []
        own = torch.tensor(shares, dtype=torch.float64).log()
        numbers = [_to_normal(p, self._now(section, p)) for section, p, _ in self._learnt]
        start = torch.tensor(numbers, dtype=torch.float64)
        self.start = torch.cat([start, own])
        self.centre = torch.cat([torch.zeros_like(start), own])
        self.names = (
            *(name for _, _, name in self._learnt),
            *(f"weights:{part}" for part in self._parts),
        )

    def may_vary(self, name: str) -> int:
        """Return the position of a parameter that may differ from speaker to speaker.

        Raises
        ------
        InputError
            When it is not learnt, or is no number of the likelihood or the frames.
        """
        varying = [n for section, _, n in self._learnt if section != "model"]
        if name not in varying:
            raise InputError(
                f"'{name}' cannot vary from speaker to speaker; expected one of what is learnt of "
                f"the likelihood and the frames: {', '.join(varying) or 'nothing'}"
            )
        return self.names.index(name)

    def scale(self, i: int) -> float:
        """Return the prior standard deviation of the log, or log odds, of a parameter's value."""
        return self._learnt[i][1].prior_scale

    def at(self, z: Sequence[Tensor] | Tensor) -> ObservationModel:
        """Return the model at these numbers, its parameters tensors.

        Parameters
        ----------
        z
            One number per parameter; those of the likelihood and the frames may be of shape (S,),
            one per cell of the terms that the model is asked about.
        """
        sections: dict[str, dict[str, Any]] = {"likelihood": {}, "model": {}, "frames": {}}
        for i, (section, parameter, name) in enumerate(self._learnt):
            sections[section][name] = _from_normal(parameter, z[i])
        model = replace(self.model, **sections["model"])
        likelihood = with_values(model.likelihood, sections["likelihood"])
        prior: Any = model.frame_prior
        if sections["frames"]:
            prior = replace(prior, **sections["frames"])
        return replace(model, likelihood=likelihood, frame_prior=prior)

    def log_weights(self, z: Tensor) -> Tensor | None:
        """Return the log weights of the components, or None when they are not learnt."""
        return torch.log_softmax(z[len(self._learnt) :], -1) if self._parts else None

    def values(self, z: Tensor) -> dict[str, Tensor]:
        """Return name -> values at some numbers; what is learnt of weights is the weights.

        Parameters
        ----------
        z
            Shape (..., P).

        Returns
        -------
        dict of Tensor
            By the names of `names`, shape (...) each.
        """
        by_name = {
            name: _from_normal(parameter, z[..., i])
            for i, (_, parameter, name) in enumerate(self._learnt)
        }
        weights = torch.softmax(z[..., len(self._learnt) :], -1)
        for k, part in enumerate(self._parts):
            by_name[f"weights:{part}"] = weights[..., k]
        return by_name

    def by_section(self, values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """Lay out something per name of `names` as ``with_parameters`` takes parameters."""
        sections = {name: section for section, _, name in self._learnt}
        by_section: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            section, _, own = name.rpartition(":")
            by_section.setdefault(section or sections[name], {})[own] = value
        return by_section

    def intervals(self, z: Tensor, covariance: Tensor, deviations: float) -> dict[str, Any]:
        """Return name -> ends of an interval that is symmetric in the number, not in the value.

        Parameters
        ----------
        z
            The middle, shape (P,).
        covariance
            Covariance of the numbers, shape (P, P).
        deviations
            Half the interval in standard deviations; 1.96 of them are 95 %.
        """
        away = deviations * covariance.diagonal().sqrt()
        low, high = self.values(z - away), self.values(z + away)
        by_name = {name: (float(low[name]), float(high[name])) for _, _, name in self._learnt}
        first = len(self._learnt)
        for k, part in enumerate(self._parts):
            # A weight's log odds are its number less the logsumexp of the others.
            others = torch.arange(len(self._parts)) != k
            slope = torch.zeros_like(z)
            slope[first + k] = 1.0
            slope[first:][others] = -torch.softmax(z[first:][others], 0)
            odds = z[first + k] - torch.logsumexp(z[first:][others], 0)
            half = deviations * (slope @ covariance @ slope).sqrt()
            ends = torch.sigmoid(torch.stack([odds - half, odds + half]))
            by_name[f"weights:{part}"] = (float(ends[0]), float(ends[1]))
        return by_name

    def _now(self, section: str, parameter: Parameter) -> float:
        owner: Any = {
            "likelihood": self.model.likelihood,
            "model": self.model,
            "frames": self.model.frame_prior,
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
