"""What happens in a search, collected step by step, in metres."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.environment import Outcome
from sloop_ppl.planning.episode import PlanInfo, Step
from sloop_ppl.planning.pose import Pose
from sloop_ppl.planning.sensors import MaskSensor
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchAction

__all__ = ["Record"]

Tables = Mapping[str, NDArray[np.float64]]


class Record:
    """Collects what happens, in metres.

    Parameters
    ----------
    space
        The search space.
    keep_beliefs
        Keep the beliefs at every pose.
    """

    def __init__(self, space: SearchSpace, keep_beliefs: bool) -> None:
        self._space, self._keep = space, keep_beliefs
        self.actions: list[str] = []
        self._poses: list[Pose] = []
        self._observations: list[Mapping[str, Any]] = []
        self._rewards: list[float] = []
        self._views: list[NDArray[np.bool_]] = []
        self._infos: list[PlanInfo] = []
        self._beliefs: list[Tables] = []
        self._found = 0

    def begin(self, pose: Pose, belief: GridBelief) -> None:
        """Record where the search begins."""
        self._poses.append(pose)
        self._views.append(self._space.view_mask(pose))
        if self._keep:
            self._beliefs.append(MappingProxyType(belief.tables))

    def add(
        self,
        action: SearchAction,
        outcome: Outcome,
        reward: float,
        belief: GridBelief,
        info: PlanInfo,
    ) -> Step:
        """Record one step and return it."""
        self.begin(outcome.pose, belief)
        self.actions.append(action.name)
        self._rewards.append(float(reward))
        self._infos.append(info)
        self._found = belief.robot.found
        seen = outcome.report.seen
        self._observations.append(
            MappingProxyType({name: self._place(seen.get(name)) for name in self._space.target_ids})
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
            collision=outcome.collision,
        )

    def _place(self, report: Any) -> Any:
        """Return the middle of the cell at which a target was seen; other reports as they are."""
        sensor = self._space.sensor
        if report is None or not isinstance(sensor, MaskSensor):
            return report
        return self._space.grid.centre_of(*divmod(sensor.cell_of(report), self._space.n_cols))

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
