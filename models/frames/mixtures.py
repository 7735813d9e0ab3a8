"""Turn what a network says of landmarks into distributions of their fronts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart

__all__ = ["merged_first", "mixtures"]

_LEAST = 0.01  # parts that weigh less are left to the lapse
_FLAT = 0.5  # so are parts of a lesser concentration


def mixtures(
    mean_rad: NDArray[np.float64], kappa: NDArray[np.float64], weight: NDArray[np.float64]
) -> list[FrameDistribution]:
    """Return N mixtures, the heaviest parts first; what is light or flat is left to the lapse.

    Parameters
    ----------
    mean_rad, kappa, weight : of P parts each, shape (N, P); weights sum to at most one.

    Returns
    -------
    list of FrameDistribution
        N of them; each lapse is what its kept parts lack to one.
    """
    order = np.argsort(-weight, axis=1, kind="stable")
    kept = (weight >= _LEAST) & (kappa >= _FLAT)
    found: list[FrameDistribution] = []
    for i, row in enumerate(order):
        which = row[kept[i, row]]
        told = (one[i, which].tolist() for one in (mean_rad, kappa, weight))
        parts = tuple(
            FramePart(math.remainder(mean, 2 * math.pi), spread, share)
            for mean, spread, share in zip(*told, strict=True)
        )
        found.append(FrameDistribution(parts, lapse=1 - sum(part.weight for part in parts)))
    return found


def merged_first(
    count: int,
    mean_rad: NDArray[np.float64],
    kappa: NDArray[np.float64],
    weight: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return mixtures whose first parts are replaced with one, put last.

    Parameters
    ----------
    count : how many are merged, into the von Mises with their first moment; they are equally
        concentrated.
    mean_rad, kappa, weight : of P parts each, shape (N, P).

    Returns
    -------
    tuple of numpy.ndarray
        The same three of P - count + 1 parts.

    Notes
    -----
    The mean resultant of a von Mises is about 1 - 1/(2 kappa) for kappa > 2; the inverse is the
    approximation of Best and Fisher (1981).
    """
    share, spread = weight[:, :count], kappa[:, 0]
    total = share.sum(1)
    some = total >= 1e-12
    moment = (share * np.exp(1j * mean_rad[:, :count])).sum(1) / np.where(some, total, 1.0)
    r = np.abs(moment) * (1 - 1 / (2 * np.maximum(spread, 2.0)))
    wide = np.where(r < 0.53, 2 * r + r**3 + 5 * r**5 / 6, -0.4 + 1.39 * r + 0.43 / (1 - r))
    combined = np.where(r < 0.85, wide, 1 / np.maximum(r**3 - 4 * r**2 + 3 * r, 1e-12))
    one = (np.angle(moment), np.minimum(combined, spread), total)
    mean, concentration, whole = (
        np.concatenate([old[:, count:], np.where(some, new, 0.0)[:, None]], 1)
        for old, new in zip((mean_rad, kappa, weight), one, strict=True)
    )
    return mean, concentration, whole
