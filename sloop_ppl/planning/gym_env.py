"""The search as a Gymnasium environment, with the belief as what is observed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.planning.belief import GridBelief, check_table
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.models import (
    SearchObservationModel,
    SearchRewardModel,
    SearchTransitionModel,
)
from sloop_ppl.planning.obstacles import tall_cells
from sloop_ppl.planning.placing import start_pose, true_cells
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.tree import scalar_rng
from sloop_ppl.planning.values import SearchState

if TYPE_CHECKING:

    class _Env:
        np_random: np.random.Generator

        def reset(self, *, seed: int | None = None, options: Any = None) -> Any: ...

else:
    from gymnasium import Env as _Env

from gymnasium import spaces

__all__ = ["SearchEnv"]

PIXELS = 8
"""Side of a cell in a rendered picture, pixels."""


class SearchEnv(_Env):
    """Search a map; the belief is updated exactly after every step and is what one sees.

    Parameters
    ----------
    beliefs : table of each target, shape (H, W); a uniform one for a target ``Target`` when None.
    city : the map, or its name.
    config : the settings; `SearchConfig.max_steps` truncates.
    render_mode : ``"rgb_array"`` or None.

    Notes
    -----
    Actions are numbered as `SearchSpace.actions`. A find before the first look is wrong, as in
    the models. Options of `reset`: ``places`` (target -> x and y in metres; drawn from the
    beliefs when left out) and ``start`` (x, y[, heading]; any cell, heading east, when left out).
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 4}  # noqa: RUF012 - gymnasium's way

    def __init__(
        self,
        beliefs: Mapping[str, NDArray[np.float64]] | None = None,
        city: CityMap | str = "cleveland",
        config: SearchConfig | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise InputError(f"render_mode is {render_mode!r}; expected 'rgb_array' or None")
        self.render_mode = render_mode
        self._city = load_map(city) if isinstance(city, str) else city
        grid, config = self._city.grid, config or SearchConfig()
        given = {"Target": np.ones(grid.shape)} if beliefs is None else beliefs
        tall = None
        if config.no_fly or config.occlusion:
            tall = tall_cells(self._city, config.flight_height_m)
        self.space = SearchSpace(grid.shape, tuple(given), config, tall)
        self._prior = {
            name: check_table(name, table, grid.shape).reshape(grid.shape)
            for name, table in given.items()
        }
        n = len(given)
        rows, cols = grid.shape
        self.observation_space = spaces.Dict(
            {
                "belief": spaces.Box(0.0, 1.0, (n, rows, cols), np.float64),
                "pose": spaces.MultiDiscrete(np.array([rows, cols, 8])),
                "found": spaces.MultiBinary(n),
                "looked": spaces.Discrete(2),
            }
        )
        self.action_space = spaces.Discrete(len(self.space.actions))
        self._transition = SearchTransitionModel(self.space)
        self._reward = SearchRewardModel(self.space)
        self._belief: GridBelief | None = None
        self._steps = 0

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin anew and return the first observation."""
        super().reset(seed=seed)
        options = options or {}
        rng = np.random.default_rng(int(self.np_random.integers(2**63)))
        grid = self._city.grid
        robot = self.space.robot(start_pose(options.get("start"), grid, self.space, rng))
        self._belief = GridBelief(self.space, self._prior, robot, rng=rng)
        if "places" in options:
            cells = true_cells(self.space.target_ids, options["places"], grid)
            self._state = SearchState(robot, cells)
        else:
            self._state = self._belief.random()
        self._sensor = SearchObservationModel(self.space, scalar_rng(rng))
        self._steps = 0
        return self._observed(), {"reported": {}}

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Do an action; return observation, reward, whether it is over or cut off, and reports."""
        if self._belief is None:
            raise InputError("The environment was not reset; call reset() before step()")
        chosen = self.space.actions[int(action)]
        before, self._state = self._state, self._transition.sample(self._state, chosen)
        reward = self._reward.sample(before, chosen, self._state)
        observation = self._sensor.sample(self._state, chosen)
        if not before.robot.ended:
            self._belief = self._belief.updated(chosen, observation, self._state.robot)
        self._steps += 1
        over = self._state.robot.ended
        cut = not over and self._steps >= self.space.config.max_steps
        reported = {
            name: divmod(cell, self.space.n_cols)
            for name, cell in zip(self.space.target_ids, observation.seen, strict=True)
            if cell >= 0
        }
        return self._observed(), float(reward), over, cut, {"reported": reported}

    @property
    def belief(self) -> GridBelief:
        """The belief at present."""
        if self._belief is None:
            raise InputError("The environment was not reset; call reset() first")
        return self._belief

    def action_masks(self) -> NDArray[np.bool_]:
        """Return which actions may be taken: a find only after a look."""
        may = np.ones(len(self.space.actions), dtype=bool)
        may[3:] = self.belief.robot.looked
        return may

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture: belief dark, view tinted, robot red, north up, shape (px, px, 3)."""
        if self.render_mode is None:
            return None
        belief = np.sum([t / t.max() for t in self.belief.tables.values()], axis=0)
        shade = 1.0 - np.clip(belief, 0.0, 1.0)
        picture = np.repeat(shade[:, :, None], 3, axis=2)
        view = self.space.view_mask(self.belief.robot.pose)
        picture[view] = 0.6 * picture[view] + 0.4 * np.array([0.34, 0.71, 0.91])
        picture[self.belief.robot.cell] = [0.84, 0.37, 0.0]
        large = np.kron(picture[::-1], np.ones((PIXELS, PIXELS, 1)))
        return (large * 255).astype(np.uint8)

    def close(self) -> None:
        """Release nothing."""

    def _observed(self) -> dict[str, Any]:
        robot = self.belief.robot
        found = [robot.found >> i & 1 for i in range(len(self.space.target_ids))]
        return {
            "belief": np.clip(np.array(list(self.belief.tables.values())), 0.0, 1.0),
            "pose": np.array([*robot.cell, robot.heading], dtype=np.int64),
            "found": np.array(found, dtype=np.int8),
            "looked": int(robot.looked),
        }
