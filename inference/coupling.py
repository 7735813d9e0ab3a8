"""Combine prior, sensing and descriptions of several targets, coupled by the frames they share."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.inference.said import Said

__all__ = ["Coupling", "log_sum"]

Table = NDArray[np.float64]

_MOST_SETTINGS = 5184


class Coupling:
    """The joint posterior of shared frames, components and cells, one target at a time.

    Shape legend: G joint settings of all shared frames of all descriptions (1 when none is
    shared); C settings of one description; K components; S cells.

    Parameters
    ----------
    log_prior : target -> log prior over cells, shape (S,).
    log_sensed : target -> log likelihood of what was sensed, shape (S,).
    said : target -> what was said of it.

    Raises
    ------
    InputError : when the descriptions share so many frames that their joint settings cannot be
        enumerated.

    Notes
    -----
    Given the shared frames the targets are independent, so the joint is a sum over settings g:
    p(g) prod_i sum_{k, s_i} prior_i sensed_i prod_d factor_d(g, k, s_i).
    """

    def __init__(
        self,
        log_prior: Mapping[str, Table],
        log_sensed: Mapping[str, Table],
        said: Mapping[str, tuple[Said, ...]],
    ) -> None:
        self._prior, self._sensed, self._said = log_prior, log_sensed, said
        sharing = [s for parts in said.values() for s in parts if s.shared.size > 1]
        self._shared = list({id(s.shared): s.shared for s in sharing}.values())
        sizes = [shared.size for shared in self._shared]
        if np.prod(sizes) > _MOST_SETTINGS:
            raise InputError(
                f"The descriptions share frames with {int(np.prod(sizes))} joint settings; at "
                f"most {_MOST_SETTINGS} can be enumerated; use a model without shared frames"
            )
        # Row g holds, for every description that shares frames, the index of its setting.
        self._settings = np.array(list(itertools.product(*map(range, sizes))), dtype=int)
        self._log_p = np.zeros(len(self._settings))
        for column, shared in enumerate(self._shared):
            self._log_p += shared.log_prior.numpy()[self._settings[:, column]]
        self._message = {target: log_sum(self._rest(target, None), -1) for target in log_prior}

    @property
    def log_evidence(self) -> float:
        """Log probability of all that was said and sensed."""
        return float(log_sum(self._log_p + sum(self._message.values()), 0))

    def possible(self, target: str) -> bool:
        """Tell whether some cell of the target has a positive probability."""
        return bool(np.isfinite(self._message[target]).any())

    def belief(self, target: str) -> Table:
        """Return the probability of each cell, shape (S,)."""
        log_p = log_sum(self._rest(target, None) + self._others(target)[:, None], 0)
        return _normalised(log_p)

    def joint(self, target: str, which: int) -> Table:
        """Return the posterior of setting, component and cell for one description, (C, K, S).

        The settings are those of the description's own shared frames.
        """
        part = self._said[target][which]
        rest = self._rest(target, which) + self._others(target)[:, None]
        if part.shared.size > 1:
            column = self._column(part)
            own = self._settings[:, column]
            rest = np.stack([log_sum(rest[own == c], 0) for c in range(part.shared.size)])
        else:
            rest = log_sum(rest, 0)[None]
        log_joint = rest[:, None, :] + part.log_factor
        return _normalised(log_joint)

    def settings(self, part: Said) -> Table:
        """Return the posterior of the settings of a description's shared frames, shape (C,)."""
        log_p = self._log_p + sum(self._message.values())
        own = self._settings[:, self._column(part)]
        weights = _normalised(log_p)
        return np.array([weights[own == c].sum() for c in range(part.shared.size)])

    def _column(self, part: Said) -> int:
        return next(i for i, shared in enumerate(self._shared) if shared is part.shared)

    def _others(self, target: str) -> Table:
        """Return the log weight of each setting from its prior and the other targets, (G,)."""
        others = (m for name, m in self._message.items() if name != target)
        log_p: Table = self._log_p + sum(others)
        return log_p

    def _rest(self, target: str, leave_out: int | None) -> Table:
        """Return prior, sensing and descriptions (but one) in each setting, (G or 1, S)."""
        parts = self._said[target]
        skip = None if leave_out is None else leave_out % len(parts)
        log_p: Table = (self._prior[target] + self._sensed[target])[None]
        if any(part.shared.size > 1 for part in parts):
            log_p = np.repeat(log_p, len(self._settings), axis=0)
        for i, part in enumerate(parts):
            if i != skip:
                table = log_sum(part.log_factor, 1)
                if part.shared.size > 1:
                    table = table[self._settings[:, self._column(part)]]
                log_p = log_p + table
        return log_p


def log_sum(log_p: Table, axis: int) -> Table:
    """Return the log of the sum of exp over one axis; -inf where all is impossible."""
    if log_p.shape[axis] == 1:
        return np.asarray(log_p.take(0, axis))
    peak = log_p.max(axis, keepdims=True)
    peak[~np.isfinite(peak)] = 0.0
    with np.errstate(divide="ignore"):
        total: Table = np.log(np.exp(log_p - peak).sum(axis)) + peak.squeeze(axis)
    return total


def _normalised(log_p: Table) -> Table:
    """Return the probabilities that log weights stand for."""
    weights = np.exp(log_p - log_p.max())
    normalised: Table = weights / weights.sum()
    return normalised
