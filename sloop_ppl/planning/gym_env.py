"""The search as a Gymnasium environment, with the belief as what is observed."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.planning.belief import GridBelief, check_table
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.environment import (
    GridEnvironment,
    observation_of,
    robot_after,
    start_pose,
)
from sloop_ppl.planning.models import SearchRewardModel
from sloop_ppl.planning.motion import Motion
from sloop_ppl.planning.sensors import Sensor
from sloop_ppl.planning.space import SearchSpace

if TYPE_CHECKING:

    class _Env:
        np_random: np.random.Generator

        def reset(self, *, seed: int | None = None, options: Any = None) -> Any: ...

else:
    from gymnasium import Env as _Env

from gymnasium import spaces

__all__ = ["SearchEnv"]

RESET_OPTIONS = ("places", "start")
"""Options that `SearchEnv.reset` takes."""

PIXELS = 8
"""Side of a cell in a rendered picture, pixels."""


class SearchEnv(_Env):
    """Search a map; the belief is updated exactly after every step and is what one sees.

    Parameters
    ----------
    beliefs
        Table of each target, shape (H, W); a uniform one for a target ``Target`` when None.
    city
        The map, or its name.
    config
        The settings; `SearchConfig.max_steps` truncates.
    render_mode
        ``"rgb_array"`` or None.
    sensor, motion
        What is sensed and how moves change the pose; those of the settings when None.

    Raises
    ------
    InputError
        When an action is no number of one, or `reset` is given an option it does not know.

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
        *,
        sensor: Sensor | None = None,
        motion: Motion | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise InputError(f"render_mode is {render_mode!r}; expected 'rgb_array' or None")
        self.render_mode = render_mode
        self._city = load_map(city) if isinstance(city, str) else city
        grid, config = self._city.grid, config or SearchConfig()
        given = {"Target": np.ones(grid.shape)} if beliefs is None else beliefs
        self.space = SearchSpace.of_city(
            self._city, tuple(given), config, sensor=sensor, motion=motion
        )
        self._prior = {
            name: check_table(name, table, grid).reshape(grid.shape)
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
        self._reward = SearchRewardModel(self.space)
        self._belief: GridBelief | None = None
        self._steps = 0

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin anew and return the first observation."""
        super().reset(seed=seed)
        options = {} if options is None else options
        if not isinstance(options, Mapping):
            raise InputError(
                f"The options of reset are {options!r}; expected a mapping with "
                f"{', '.join(RESET_OPTIONS)}"
            )
        for name in options:
            if name not in RESET_OPTIONS:
                raise UnknownName("option of reset", name, RESET_OPTIONS)
        space = self.space
        rng = np.random.default_rng(int(self.np_random.integers(2**63)))
        start = start_pose(options.get("start"), space, rng)
        robot = space.robot(space.snap(start))
        self._belief = GridBelief(space, self._prior, robot, rng=rng, pose=start)
        places = options.get("places")
        if places is None:
            cells = zip(space.target_ids, self._belief.random().cells, strict=True)
            places = {t: space.grid.place_in(*divmod(cell, space.n_cols)) for t, cell in cells}
        self._environment = GridEnvironment(space, places, start, rng=rng)
        self._steps = 0
        return self._observed(), {"reported": {}}

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Do an action; return observation, reward, whether it is over or cut off, and reports."""
        space, belief = self.space, self.belief
        number = _whole(action)
        if number is None or not 0 <= number < len(space.actions):
            names = ", ".join(f"{i} {a.name}" for i, a in enumerate(space.actions))
            raise InputError(f"Action {action!r} is none of: {names}")
        if belief.robot.ended:
            return self._observed(), 0.0, True, False, {"reported": {}}
        chosen = space.actions[number]
        outcome = self._environment.execute(chosen)
        after = robot_after(space, belief.robot, chosen, outcome)
        observation = observation_of(space, chosen, after, outcome)
        reward = self._reward.of(belief.robot, chosen, after)
        self._belief = belief.updated(chosen, observation, after, outcome.pose)
        self._steps += 1
        over = after.ended
        cut = not over and self._steps >= space.config.step_limit
        seen = {name: at for name, at in outcome.report.seen.items() if at is not None}
        if space.sees_mask:
            seen = {name: space.grid.cell_covering(*at) for name, at in seen.items()}
        return self._observed(), float(reward), over, cut, {"reported": seen}

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
        # Each target scaled to its peak, else a wide belief would vanish beside a sharp one.
        belief = np.sum([t / t.max() for t in self.belief.tables.values()], axis=0)
        shade = 1.0 - np.clip(belief, 0.0, 1.0)
        picture = np.repeat(shade[:, :, None], 3, axis=2)
        view = self.space.view_mask(self.belief.robot.pose)
        # Sky blue #56b4e9 for the view, vermilion #d55e00 for the robot (Okabe and Ito).
        picture[view] = 0.6 * picture[view] + 0.4 * np.array([0.34, 0.71, 0.91])
        picture[self.belief.robot.cell] = [0.84, 0.37, 0.0]
        # Row 0 is south, the first row of a picture north.
        large = np.kron(picture[::-1], np.ones((PIXELS, PIXELS, 1)))
        return (large * 255).astype(np.uint8)

    def _observed(self) -> dict[str, Any]:
        robot = self.belief.robot
        found = [robot.found >> i & 1 for i in range(len(self.space.target_ids))]
        return {
            "belief": np.clip(np.array(list(self.belief.tables.values())), 0.0, 1.0),
            "pose": np.array([*robot.cell, robot.heading], dtype=np.int64),
            "found": np.array(found, dtype=np.int8),
            "looked": int(robot.looked),
        }


def _whole(action: Any) -> int | None:
    """Return an action's number, or None where it is no whole number."""
    try:
        return operator.index(np.asarray(action).item())
    except (TypeError, ValueError):
        return None
