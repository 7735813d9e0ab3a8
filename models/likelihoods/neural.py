"""A small network on distance, angle, size, kind and class, that starts out sensible."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
import torch
from torch import Tensor

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps.landmark import KINDS
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.likelihoods._base import LIKELIHOODS
from sloop_ppl.rng import child

__all__ = ["NeuralLikelihood"]

_CLASSES = (
    "contact", "proximity", "between", "north", "south", "east", "west", "northeast", "northwest",
    "southeast", "southwest", "front", "behind", "left", "right", "across",
)  # fmt: skip
"""Classes that have a row in the tables of weights, in the order of the rows."""

_KINDS = (*KINDS, "map")
_FORMS = ("point", "line", "area")
_EMBEDDED = 4  # numbers that tell a class from others
_PLACE_FEATURES = 4 + len(_FORMS) + len(_KINDS) + _EMBEDDED
_TURN_FEATURES = 2  # cos x, cos 2x


@dataclass(frozen=True, eq=False)
class NeuralLikelihood:
    """log g = logsigmoid(a + b falling + c turning + network).

    Parameters
    ----------
    seed
        Seed of the initial weights, >= 0.
    hidden
        Width of the two hidden layers, > 0.
    weights
        Name -> tensor; drawn from the seed when empty. Make them require gradients and they learn;
        `trainable` returns a copy of which they do.

    Raises
    ------
    UnknownName, InputError
        For weights of a wrong name or shape.

    Notes
    -----
    Source: ours. What goes in: log distance (off a said distance, if one was said), whether the
    cell is on the ground, the ground's size, its form (point, line, area) and kind, an embedding
    of the class of relation, and cosine and double cosine of the angle to the relation's
    direction. A table per class (`base`: offset, fall-off, turning, log width) is added to the
    network's output; it holds hand-set values, the network starts small, so untrained weights
    already know near from far. Weights are drawn with numpy, so a seed means the same anywhere.
    """

    quadrature_error: ClassVar[float] = 1e-10  # smooth

    seed: int = 0
    hidden: int = 16
    weights: Mapping[str, Tensor] = field(default_factory=dict)

    def __post_init__(self) -> None:
        initial = _initial(self.seed, self.hidden)
        for name, value in self.weights.items():
            if name not in initial:
                raise UnknownName("weight of NeuralLikelihood", name, initial)
            if value.shape != initial[name].shape:
                raise InputError(
                    f"Weight '{name}' of NeuralLikelihood has shape {tuple(value.shape)}; expected "
                    f"{tuple(initial[name].shape)}"
                )
        object.__setattr__(self, "weights", {**initial, **self.weights})

    def trainable(self) -> NeuralLikelihood:
        """Return a copy whose weights require gradients; `weights` holds what to optimise."""
        copies = {k: v.detach().clone().requires_grad_() for k, v in self.weights.items()}
        return replace(self, weights=copies)

    def log_g(self, term: GroundedRelation, direction_rad: Tensor | None) -> Tensor:
        """Return log g, shape (B, S), or (S,) for a relation without direction."""
        w = self.weights
        place = w["place"] @ self._place_features(term) + w["place_bias"][:, None]
        level, fall, turn, log_width = w["base"][_row(term)]
        base = level - fall * torch.log1p((term.off_m / log_width.exp()) ** 2)
        if direction_rad is None:
            return self._log_g(place, base)
        x = term.outward_rad - direction_rad[:, None]
        directed = term.has_direction
        # Where a cell has no direction the turning terms take their mean over directions.
        cosine = torch.where(directed, torch.cos(x), 0.0)
        turned = torch.stack([cosine, torch.where(directed, torch.cos(2 * x), 0.0)], -2)
        return self._log_g(place + w["turn"] @ turned, base + turn * (cosine - 1))

    def _log_g(self, first: Tensor, base: Tensor) -> Tensor:
        """Return log g from the first layer's input (..., hidden, S) and the base (..., S)."""
        w = self.weights
        second = w["deep"] @ torch.tanh(first) + w["deep_bias"][:, None]
        out = w["out"] @ torch.tanh(second)
        return torch.nn.functional.logsigmoid(out + base)

    def _place_features(self, term: GroundedRelation) -> Tensor:
        """Return what does not depend on direction, shape (features, S)."""
        off = term.off_m
        same = torch.ones_like(off)
        features = [torch.log1p(off / 10), off / 100, term.on_ground.double()]
        features.append(same * math.log1p(term.extent_m / 20))
        features += [same * (term.form == form) for form in _FORMS]
        features += [same * (term.kind == kind) for kind in _KINDS]
        embedded = self.weights["class"][_row(term)]
        return torch.cat([torch.stack(features), embedded[:, None] * same])


def _row(term: GroundedRelation) -> int:
    """Return the row of a term's class; a class from outside has that of its width."""
    name = term.relation_class
    if name not in _CLASSES:
        name = term.width
    if name == "directed":
        name = "front" if term.needs_frame else "north"
    return _CLASSES.index(name)


def _initial(seed: int, hidden: int) -> dict[str, Tensor]:
    """Return the weights before any training, float64."""
    rng = np.random.default_rng(seed)

    def draw(name: str, *shape: int, scale: float) -> Tensor:
        return torch.from_numpy(child(rng, name).normal(0.0, scale, shape))

    base = torch.tensor([_base(name) for name in _CLASSES], dtype=torch.float64)
    return {
        "class": draw("class", len(_CLASSES), _EMBEDDED, scale=1.0),
        "place": draw("place", hidden, _PLACE_FEATURES, scale=_PLACE_FEATURES**-0.5),
        "place_bias": draw("place_bias", hidden, scale=0.1),
        "turn": draw("turn", hidden, _TURN_FEATURES, scale=_TURN_FEATURES**-0.5),
        "deep": draw("deep", hidden, hidden, scale=hidden**-0.5),
        "deep_bias": draw("deep_bias", hidden, scale=0.1),
        "out": draw("out", hidden, scale=0.1 * hidden**-0.5),
        "base": base,
    }


def _base(relation_class: str) -> list[Any]:
    """Return level, fall-off, turning and log width of a class before any training.

    g = sigmoid(level - fall log(1 + d^2 / width^2) + turn (cos x - 1)): .95 on the ground, .83 one
    width off; widths and sharpness are about those of `StudentVonMisesLikelihood`.
    """
    undirected = {"contact": 6.0, "proximity": 15.0, "between": 8.0, "across": 15.0}
    if relation_class in undirected:
        return [3.0, 2.0, 0.0, math.log(undirected[relation_class])]
    return [3.0, 2.0, 3.0, math.log(20.0)]


LIKELIHOODS.add("neural", NeuralLikelihood())
