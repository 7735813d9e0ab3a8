"""What an answer is worth to the search that follows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._ask_value import ReturnEstimator
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.environment import start_pose
from sloop_ppl.planning.questions import QuestionTable
from sloop_ppl.planning.space import SearchSpace

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior

__all__ = ["expected_gain"]

_SPREAD = (1 / 6, 1 / 2, 5 / 6)
"""Shares of the map's height and width at which searches are taken to begin, nine in all."""


def expected_gain(
    posterior: Posterior,
    target: str,
    name: str,
    p_answer: NDArray[np.float64],
    *,
    cost: float,
    steps: int,
    start: tuple[float, ...] | None,
    config: Any,
) -> float:
    """Return the expected discounted return with a question less that without it."""
    settings = SearchConfig() if config is None else config
    space = SearchSpace.of_city(posterior.city, (target,), settings)
    question = QuestionTable(name, target, p_answer, cost, steps)
    estimator, rng = ReturnEstimator(space), np.random.default_rng(0)
    if start is not None:
        poses = [space.snap(start_pose(start, space, rng))]
    else:
        rows, cols = ([int(share * n) for share in _SPREAD] for n in space.shape)
        poses = [space.encode(row, col, 0) for row in rows for col in cols]
    tables = {target: posterior.belief(target)}
    gains = [
        estimator.gain(GridBelief(space, tables, space.robot(pose), rng=rng), question)
        for pose in poses
    ]
    return float(np.mean(gains))
