"""How far two posteriors' beliefs are apart: in one number, cell by cell, and side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sloop_ppl._html import beside, caption, html_table
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap
from sloop_ppl.maps._notebook import city_svg
from sloop_ppl.models import ObservationModel

__all__ = ["BeliefComparison", "compare_beliefs"]

Table = NDArray[np.float64]


class Compared(Protocol):
    """What is compared: a posterior."""

    @property
    def city(self) -> CityMap:
        """The map."""

    @property
    def model(self) -> ObservationModel:
        """The observation model."""

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets."""

    def belief(self, target: str) -> Table:
        """Return the probability of each cell, shape (H, W)."""


@dataclass(frozen=True, eq=False, repr=False)
class BeliefComparison:
    """Two beliefs of each target that two posteriors have in common.

    Parameters
    ----------
    city
        The map.
    labels
        What the two are called: their models, where these differ.
    beliefs
        Target -> the belief of the one and of the other, each of shape (H, W).
    """

    city: CityMap
    labels: tuple[str, str]
    beliefs: Mapping[str, tuple[Table, Table]]

    def __repr__(self) -> str:
        each = (f"{t} {tv:.4f}" for t, tv in self.total_variation.items())
        return f"BeliefComparison({' and '.join(self.labels)}: total variation {', '.join(each)})"

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets that both have."""
        return tuple(self.beliefs)

    @property
    def total_variation(self) -> Mapping[str, float]:
        """Target -> half the sum of absolute differences, in [0, 1]."""
        return MappingProxyType(
            {t: 0.5 * float(np.abs(a - b).sum()) for t, (a, b) in self.beliefs.items()}
        )

    @property
    def kl_nats(self) -> Mapping[str, float]:
        """Target -> sum of a log(a / b), nats; infinite where b excludes what a does not."""
        return MappingProxyType({t: _kl(a, b) for t, (a, b) in self.beliefs.items()})

    @property
    def reverse_kl_nats(self) -> Mapping[str, float]:
        """Target -> sum of b log(b / a), nats."""
        return MappingProxyType({t: _kl(b, a) for t, (a, b) in self.beliefs.items()})

    def difference(self, target: str) -> Table:
        """Return the second belief less the first, summing to zero, shape (H, W).

        Raises
        ------
        UnknownName
            When the two have no such target in common.
        """
        if target not in self.beliefs:
            raise UnknownName("target that both posteriors have", target, self.targets)
        first, second = self.beliefs[target]
        return second - first

    def _repr_html_(self) -> str:
        parts = []
        for target, (first, second) in self.beliefs.items():
            heats = (first, second, second - first)
            titles = (*self.labels, "second less first")
            panels = [
                caption(title) + city_svg(self.city, f"{target}, {title}", heat=heat)
                for title, heat in zip(titles, heats, strict=True)
            ]
            parts.append(caption(target) + beside(panels))
        head = ("target", "total variation", "KL, nats", "KL of the second, nats")
        rows = [
            (t, self.total_variation[t], self.kl_nats[t], self.reverse_kl_nats[t])
            for t in self.targets
        ]
        return "".join(parts) + html_table(rows, head)


def compare_beliefs(first: Compared, second: Compared) -> BeliefComparison:
    """Return how two posteriors differ; see :meth:`sloop_ppl.Posterior.compare`."""
    if not callable(getattr(second, "belief", None)) or not hasattr(second, "targets"):
        raise InputError(
            f"What is compared with is a {type(second).__name__}; expected a Posterior, as "
            "sloop_ppl.infer returns it"
        )
    if first.city.grid != second.city.grid:
        raise InputError(
            f"The posteriors are of map '{first.city.name}', {first.city.grid.shape} cells, and "
            f"of '{second.city.name}', {second.city.grid.shape}; expected the same cells"
        )
    common = [target for target in first.targets if target in second.targets]
    if not common:
        raise InputError(
            f"The posteriors have no target in common: {', '.join(first.targets)}, and "
            f"{', '.join(second.targets)}"
        )
    labels = first.model.name, second.model.name
    if labels[0] == labels[1]:
        labels = f"{labels[0]}, first", f"{labels[1]}, second"
    beliefs = {target: (first.belief(target), second.belief(target)) for target in common}
    return BeliefComparison(first.city, labels, MappingProxyType(beliefs))


def _kl(a: Table, b: Table) -> float:
    held = a > 0
    with np.errstate(divide="ignore"):
        ratio = np.log(a[held]) - np.log(b[held])
    return max(float((a[held] * ratio).sum()), 0.0)
