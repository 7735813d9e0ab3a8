"""What figures ask of the values they draw; anything that has these attributes can be drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap

__all__ = [
    "DistributionLike",
    "EpisodeLike",
    "FrameLike",
    "GroundsLike",
    "LatentsLike",
    "PosteriorLike",
    "RelationLike",
]


class LatentsLike(Protocol):
    """A posterior that answers for latents that its model declares."""

    def latent(self, name: str) -> Any:
        """Return the probability of each value, a labelled array with the coordinate prior."""


@runtime_checkable
class GroundsLike(Protocol):
    """A posterior that says which places are probably meant."""

    def grounds(self, target: str) -> Sequence[Any]:
        """Return, for each ground, its relation and its candidates with ground and p."""


class RelationLike(Protocol):
    """A relation of a target to one or several landmarks."""

    @property
    def relation(self) -> str:
        """Relation word."""

    @property
    def grounds(self) -> tuple[str, ...]:
        """Ids of the landmarks."""

    @property
    def negated(self) -> bool:
        """True for "not behind the bank"."""


class FrameLike(Protocol):
    """Which way the front of a landmark faces, as far as one relation tells."""

    @property
    def ground(self) -> str:
        """Id of the landmark."""

    @property
    def relation(self) -> str:
        """Relation word."""

    @property
    def mean_rad(self) -> float:
        """Mean direction, radians anticlockwise from east."""

    @property
    def kappa(self) -> float | None:
        """Concentration of a von Mises distribution; None for an exact direction."""

    @property
    def p(self) -> float:
        """Probability of this direction, when there are several for one landmark."""


class DistributionLike(Protocol):
    """Which way the front of a landmark faces, as a distribution."""

    def binned(self, count: int) -> NDArray[np.float64]:
        """Return the probability of so many arcs, the first centred on east, shape (B,)."""


class PosteriorLike(Protocol):
    """Where the targets are believed to be."""

    @property
    def city(self) -> CityMap:
        """The map."""

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets."""

    @property
    def texts(self) -> tuple[str, ...]:
        """What was said."""

    def belief(self, target: str) -> NDArray[np.float64]:
        """Return the probability of each cell, shape (H, W), row 0 in the south, sum one."""

    def frames(self, target: str) -> Sequence[FrameLike]:
        """Return the frames of reference that were used, empty when there is none."""

    def relations(self, target: str) -> Sequence[RelationLike]:
        """Return what was said about the target."""


class EpisodeLike(Protocol):
    """A search: where the robot went and what it saw."""

    @property
    def poses(self) -> Sequence[Any]:
        """``(x_m, y_m, heading_deg)`` before the first action and after each."""

    @property
    def actions(self) -> Sequence[str]:
        """What was done, one a step."""

    @property
    def observations(self) -> Sequence[Any]:
        """What was seen, one a step."""

    @property
    def rewards(self) -> Sequence[float]:
        """Reward of each step."""

    @property
    def found_targets(self) -> Sequence[str]:
        """Ids of the targets that were found."""

    @property
    def places(self) -> Mapping[str, tuple[float, float]]:
        """True place of each target, metres."""

    @property
    def views(self) -> Any:
        """True on the cells in view at each pose, shape (steps + 1, H, W)."""

    @property
    def discounted_return(self) -> float:
        """Sum of the discounted rewards."""
