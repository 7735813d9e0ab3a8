"""The multi-object search behind the native-model protocol."""

from __future__ import annotations

import numpy as np

from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.native import NativeFunctions, register_native
from sloop_ppl.planning.native_data import SearchData, search_data
from sloop_ppl.planning.native_rollout import rollout
from sloop_ppl.planning.native_rules import CELLS, SearchBelief, draw, legal, policy, step
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchObservation

__all__ = ["NativeSearch"]

register_native(SearchData, NativeFunctions(draw, legal, step, policy, rollout))


class NativeSearch:
    """The search as a `NativeModel`.

    Parameters
    ----------
    space : the search space.
    """

    def __init__(self, space: SearchSpace) -> None:
        self.space = space
        self.actions = space.actions
        self.state_size = CELLS + 2 * len(space.target_ids)
        self.data = search_data(space)

    def belief(self, agent: Agent) -> SearchBelief:
        """Return the agent's `GridBelief` as arrays."""
        grid: GridBelief = agent.belief
        seen = 0
        if agent.history:
            last: SearchObservation = agent.history[-1][1]
            unfound = (i for i, at in enumerate(last.seen) if at >= 0)
            seen = next(unfound, -1) + 1
        robot = grid.robot
        row, col = robot.cell
        numbers = (row, col, robot.heading, robot.found, robot.finds, int(robot.looked), seen)
        return SearchBelief(np.array(numbers, dtype=np.int64), np.cumsum(grid.flat, axis=1))

    def key(self, observation: SearchObservation) -> int:
        """Return the key that `step` gives for an observation."""
        key = observation.found
        for at in observation.seen:
            key = (key * 1_000_003 + at + 2) & 0xFFFFFFFFFFFFFFFF
        return key - (1 << 64) if key >> 63 else key
