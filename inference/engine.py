"""What an inference engine is, and the registry of those there are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.models import Preset, RelationTerm, SharedFrames
from sloop_ppl.registry import Registry

__all__ = ["ENGINES", "Engine", "InferenceInfo", "LogFactors"]


@dataclass(frozen=True)
class InferenceInfo:
    """How an inference went.

    Parameters
    ----------
    engine : the engine's name.
    seconds : wall time it took.
    log_evidence : log probability of what was said, summed over targets; it carries the model's
        normalisation, so it does not rank models.
    not_located : targets of which nothing was said; their belief is their prior.
    """

    engine: str
    seconds: float
    log_evidence: float
    not_located: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class LogFactors:
    """What an engine computes: how a description weighs component and cell of each target.

    Shape legend: N targets, C settings of shared frames, K components, S cells.

    Parameters
    ----------
    components : names, length K.
    shared : the frames that targets share, and the prior of their settings.
    log_factor : log of weight times likelihood given the shared frames, the priors of cells and
        of shared frames left out, shape (N, C, K, S).
    """

    components: tuple[str, ...]
    shared: SharedFrames
    log_factor: NDArray[np.float64]


class Engine(Protocol):
    """Weigh what was said of each target under a model."""

    def __call__(
        self,
        terms: Sequence[tuple[RelationTerm, ...]],
        city: CityMap,
        model: Preset,
        *,
        log_prior: NDArray[np.float64],
        truths: Sequence[tuple[float, float]] | None,
        rng: np.random.Generator | None,
    ) -> LogFactors:
        """Return the log factors; `log_prior` (N, S) is where draws are worth making."""


ENGINES: Registry[Engine] = Registry("engine")
"""Inference engines by name."""
