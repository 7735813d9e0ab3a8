"""What happens in a search, collected step by step, in metres."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.maps import Grid
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.episode import PlanInfo, Pose, Step
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction, SearchObservation

__all__ = ["Record"]

Tables = Mapping[str, NDArray[np.float64]]


class Record:
    """Collects what happens, in metres."""

    def __init__(self, grid: Grid, space: SearchSpace, keep_beliefs: bool) -> None:
        self._grid, self._space, self._keep = grid, space, keep_beliefs
        self.actions: list[str] = []
        self._poses: list[Pose] = []
        self._observations: list[Mapping[str, tuple[float, float] | None]] = []
        self._rewards: list[float] = []
        self._views: list[NDArray[np.bool_]] = []
        self._infos: list[PlanInfo] = []
        self._beliefs: list[Tables] = []
        self._found = 0

    def begin(self, belief: GridBelief) -> None:
        """Record where the search begins."""
        row, col, heading = self._space.decode(belief.robot.pose)
        self._poses.append((*self._grid.centre_of(row, col), heading * 45.0))
        self._views.append(self._space.view_mask(belief.robot.pose))
        if self._keep:
            self._beliefs.append(MappingProxyType(belief.tables))

    def add(
        self,
        action: SearchAction,
        observation: SearchObservation,
        reward: float,
        belief: GridBelief,
        info: PlanInfo,
    ) -> Step:
        """Record one step and return it."""
        self.begin(belief)
        self.actions.append(action.name)
        self._rewards.append(float(reward))
        self._infos.append(info)
        self._found = belief.robot.found
        seen = zip(self._space.target_ids, observation.seen, strict=True)
        self._observations.append(
            MappingProxyType(
                {
                    name: None
                    if cell < 0
                    else self._grid.centre_of(*divmod(cell, self._space.n_cols))
                    for name, cell in seen
                }
            )
        )
        return Step(
            index=len(self.actions) - 1,
            action=action.name,
            pose=self._poses[-1],
            observation=self._observations[-1],
            reward=float(reward),
            found_targets=self.found_targets(),
            view=self._views[-1],
            beliefs=MappingProxyType(belief.tables),
            info=info,
        )

    def found_targets(self) -> tuple[str, ...]:
        """Return the ids of the targets found so far."""
        return tuple(t for i, t in enumerate(self._space.target_ids) if self._found >> i & 1)

    def columns(self) -> dict[str, Any]:
        """Return the fields of an `Episode` that were collected, up to the last whole step."""
        n = len(self._observations)
        return {
            "poses": tuple(self._poses[: n + 1]),
            "actions": tuple(self.actions[:n]),
            "observations": tuple(self._observations),
            "rewards": tuple(self._rewards[:n]),
            "found_targets": self.found_targets(),
            "views": np.array(self._views[: n + 1]),
            "info": tuple(self._infos[:n]),
            "beliefs": tuple(self._beliefs[: n + 1]),
        }
