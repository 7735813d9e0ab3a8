"""Small searches that several tests share."""

from __future__ import annotations

import random

import numpy as np

from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.planning import (
    GridBelief,
    SearchConfig,
    SearchObservationModel,
    SearchPolicyModel,
    SearchRewardModel,
    SearchSpace,
    SearchTransitionModel,
)
from sloop_ppl.planning._pomdp import Agent


def space_of(shape=(7, 9), ids=("A",), **settings) -> SearchSpace:
    return SearchSpace(shape, tuple(ids), SearchConfig(**settings))


def city_of(rows: int, cols: int) -> CityMap:
    """Return an empty map of rows x cols cells of 5 m, none of them overhanging by much."""
    return CityMap("empty", Grid(0.0, 0.0, cols * 5.0 - 1, rows * 5.0 - 1), ())


def agent_of(space: SearchSpace, tables, pose: int, *, looked=True, seed=0) -> Agent:
    rng = np.random.default_rng(seed)
    belief = GridBelief(space, tables, space.robot(pose, looked=looked), rng=rng)
    return Agent(
        belief,
        SearchPolicyModel(space, random.Random(seed)),
        SearchTransitionModel(space),
        SearchObservationModel(space),
        SearchRewardModel(space),
    )
