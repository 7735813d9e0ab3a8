"""Plan on the belief itself: a tree search over paths with belief-greedy walks below its leaves."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.search._pomdp import Agent
from sloop_ppl.search.belief import GridBelief
from sloop_ppl.search.episode import PlanInfo
from sloop_ppl.search.goals import flood, look_around, pick_goals
from sloop_ppl.search.greedy import find_worth
from sloop_ppl.search.ground import Ground, Worth
from sloop_ppl.search.hindsight import hindsight_bounds
from sloop_ppl.search.native_data import search_data
from sloop_ppl.search.paths import PathTree, explore
from sloop_ppl.search.pose_tables import next_poses
from sloop_ppl.search.sensing import HEADINGS
from sloop_ppl.search.space import SearchSpace
from sloop_ppl.search.values import SearchAction, SearchObservation

__all__ = ["InformedPlanner"]

GOALS = 32
"""How many poses the walks may drive to."""

FIELDS_BYTES = 64 * 2**20
"""Room for the distances to goals that are kept between steps."""

HINDSIGHT = 0.5
"""Share of what one who knew the target's place would earn in the worth of a leaf."""

EXPLORATION_SHARE = 0.03
"""Share of the exploration weight that is used: paths have no noise to be averaged out."""


class InformedPlanner:
    """Search the tree of paths; find what was seen when that is worth it.

    Exact for one target and a sensor without noise, up to the horizon; with more targets it
    counts every target's sighting and neglects the detours after the first. A noisy sensor's
    misses are counted, its false reports are not, except in the decision to find.

    Parameters
    ----------
    space : the search space.
    rng : not used; nothing is drawn.
    """

    def __init__(self, space: SearchSpace, *, rng: np.random.Generator | None = None) -> None:
        del rng
        self._space = space
        config = space.config
        self._reach = math.floor(config.sensor_range_cells + 1e-9)
        self._ground = _ground(space, self._reach)
        n_poses = space.n_cells * HEADINGS
        rows = max(min(FIELDS_BYTES // (2 * n_poses), 8 * GOALS), 4)
        self._fields = np.empty((rows, n_poses), dtype=np.int16)
        self._places: dict[int, int] = {}
        self._queue = np.empty(n_poses, dtype=np.int32)
        self._seen = np.empty(n_poses)
        self._goals = np.empty(min(GOALS, rows // 2), dtype=np.int32)
        self._bordered = (
            space.n_rows + 2 * self._reach,
            space.n_cols + 2 * self._reach,
        )
        self._factor = np.ones(self._bordered[0] * self._bordered[1])
        self._powers = config.discount ** np.arange(2**15, dtype=np.float64)
        self._bound = hindsight_bounds(space)
        self._plan: list[int] = []

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the first move of the best path, or a find."""
        begun = time.perf_counter()
        belief: GridBelief = agent.belief
        space, config = self._space, self._space.config
        found = self._find(belief)
        if found is not None:
            find, value = found
            self._plan = []
            seconds = time.perf_counter() - begun
            return find, PlanInfo("fast", seconds=seconds, values={find.name: value})
        worth = self._worth(belief)
        goals, fields = self._drive_to(worth, belief.robot.pose)
        hint = np.array(self._plan[: config.depth], dtype=np.int32)
        tree = self._tree(belief, config.sims + 1, worth)
        explore(self._ground, worth, tree, goals, fields, 1, config.sims, hint)
        values = [self._value(worth, tree, 0, m) for m in range(3)]
        best = max(range(3), key=lambda m: (values[m], -m))
        self._plan, chances = self._best_path(worth, tree)
        children = tree.child[0]
        info = PlanInfo(
            "fast",
            sims=config.sims,
            seconds=time.perf_counter() - begun,
            values={m.name: values[m.index] for m in space.moves if children[m.index] >= 0},
            visits={
                m.name: int(tree.visits[children[m.index]])
                for m in space.moves
                if children[m.index] >= 0
            },
            tree=self._told(worth, tree, 0, config.tree_depth) if config.tree_depth else None,
            notes={
                "path": tuple(space.actions[m].name for m in self._plan),
                "expected_seen": tuple(chances),
            },
        )
        return space.moves[best], info

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Keep the rest of the path that was planned, as the first to be tried."""
        del agent
        follows = bool(self._plan) and self._plan[0] == action.index and not observation.any
        self._plan = self._plan[1:] if follows else []

    def forget(self) -> None:
        """Drop the path that was planned."""
        self._plan = []

    def _find(self, belief: GridBelief) -> tuple[SearchAction, float] | None:
        """Return the best find and its worth, when it is worth more than looking once more."""
        if not belief.robot.looked:
            return None
        config = belief.space.config
        worths = [find_worth(belief, find) for find in belief.space.finds]
        best = int(np.argmax(worths))
        span = config.right_find_reward - config.wrong_find_reward
        chance = (worths[best] - config.wrong_find_reward) / span if span else 0.0
        again = chance * config.true_positive_rate * config.right_find_reward
        wait = config.move_reward + config.discount**2 * again
        if worths[best] <= 0 or (chance < 1 - 1e-9 and worths[best] < wait):
            return None
        return belief.space.finds[best], worths[best]

    def _worth(self, belief: GridBelief) -> Worth:
        config = belief.space.config
        mass = np.zeros(self._bordered)
        inner = mass[self._reach : -self._reach, self._reach : -self._reach]
        for i, table in enumerate(belief.flat):
            if not belief.robot.found >> i & 1:
                inner += table.reshape(belief.space.shape)
        return Worth(
            mass=mass.ravel(),
            hit=float(config.true_positive_rate),
            move=float(config.move_reward),
            collision=float(config.collision_reward),
            right=float(config.right_find_reward),
            powers=self._powers,
            horizon=3 * config.depth,
            depth=config.depth,
            exploration=float(config.exploration * EXPLORATION_SHARE),
            cells=self._holding(mass),
            bound=self._bound,
            hindsight=HINDSIGHT,
        )

    def _holding(self, mass: NDArray[np.float64]) -> NDArray[np.int32]:
        """Return row, column and place of the cells that hold all but a little of the mass."""
        flat = mass.ravel()
        order = np.argsort(-flat, kind="stable")
        total = np.cumsum(flat[order])
        kept = np.sort(order[: int(np.searchsorted(total, total[-1] * (1 - 1e-3))) + 1])
        row, col = np.divmod(kept, mass.shape[1])
        cells: NDArray[np.int32] = np.stack(
            [row - self._reach, col - self._reach, kept], axis=1
        ).astype(np.int32)
        return cells

    def _drive_to(self, worth: Worth, pose: int) -> tuple[NDArray[np.int32], NDArray[np.int16]]:
        """Return poses that are worth driving to, and the moves to each from every pose."""
        look_around(self._ground, worth, self._factor, self._seen)
        steps = self._steps_from(pose)
        n = pick_goals(
            self._ground, worth, self._factor, self._seen, steps, self._reach, self._goals
        )
        goals = self._goals[:n].copy()
        wanted = set(goals.tolist())
        for goal in goals.tolist():
            if goal in self._places:
                continue
            place = len(self._places)
            if place == len(self._fields):
                old = next(g for g in self._places if g not in wanted)
                place = self._places.pop(old)
            flood(self._ground, goal, self._fields[place], self._queue)
            self._places[goal] = place
        return goals, self._fields[[self._places[g] for g in goals.tolist()]]

    def _steps_from(self, pose: int) -> NDArray[np.int16]:
        """Return an underestimate of the moves from a pose to every other: as the crow flies."""
        space = self._space
        row, col, _ = space.decode(pose)
        rows = np.abs(np.arange(space.n_rows) - row)[:, None]
        cols = np.abs(np.arange(space.n_cols) - col)[None, :]
        steps = np.maximum(rows, cols) // space.config.step_cells
        return np.repeat(steps.astype(np.int16).ravel(), HEADINGS)

    def _tree(self, belief: GridBelief, size: int, worth: Worth) -> PathTree:
        """Return a tree that holds its root alone."""
        most = self._ground.fans.shape[1]
        room = (worth.depth + worth.horizon + 1) * most
        tree = PathTree(
            pose=np.empty(size, dtype=np.int32),
            parent=np.full(size, -1, dtype=np.int32),
            move=np.full(size, -1, dtype=np.int32),
            child=np.full((size, 3), -1, dtype=np.int32),
            visits=np.zeros(size, dtype=np.int32),
            gain=np.zeros(size),
            left=np.zeros(size),
            best=np.zeros(size),
            factor=self._factor,
            log=np.empty(room, dtype=np.int32),
            old=np.empty(room),
        )
        tree.pose[0] = belief.robot.pose
        tree.left[0] = worth.mass.sum()
        tree.best[0] = -np.inf
        return tree

    def _value(self, worth: Worth, tree: PathTree, node: int, move: int) -> float:
        child = int(tree.child[node, move])
        if child < 0:
            return -math.inf
        reward = worth.move
        if move == 0 and len(self._ground.collides) and self._ground.collides[tree.pose[node]]:
            reward = worth.collision
        later = worth.right * tree.gain[child] + tree.best[child]
        return float(reward * min(tree.left[node], 1.0) + worth.powers[1] * later)

    def _told(self, worth: Worth, tree: PathTree, node: int, depth: int) -> dict[str, Any]:
        """Return the top of the tree as JSON values; a path goes on while nothing is seen."""
        moves = [m for m in range(3) if tree.child[node, m] >= 0] if depth else []
        return {
            "visits": int(tree.visits[node]),
            "actions": {
                self._space.actions[m].name: {
                    "value": self._value(worth, tree, node, m),
                    "visits": int(tree.visits[tree.child[node, m]]),
                    "expected_seen": float(tree.gain[tree.child[node, m]]),
                    "after": {
                        "nothing seen": self._told(worth, tree, int(tree.child[node, m]), depth - 1)
                    },
                }
                for m in moves
            },
        }

    def _best_path(self, worth: Worth, tree: PathTree) -> tuple[list[int], list[float]]:
        """Return the moves of the best path in the tree and what each is expected to show."""
        node = 0
        path: list[int] = []
        chances: list[float] = []
        while True:
            values = [self._value(worth, tree, node, m) for m in range(3)]
            move = max(range(3), key=lambda m: (values[m], -m))
            if values[move] == -math.inf:
                return path, chances
            node = int(tree.child[node, move])
            path.append(move)
            chances.append(float(tree.gain[node]))


def _ground(space: SearchSpace, reach: int) -> Ground:
    """Return the map as arrays, with a border as wide as the sensor sees."""
    data = search_data(space)
    width = space.n_cols + 2 * reach
    nexts = next_poses(space)
    poses = np.arange(space.n_cells * HEADINGS, dtype=np.int32)
    moved = nexts[0] != poses
    before = np.full(len(poses), -1, dtype=np.int32)
    before[nexts[0, moved]] = poses[moved]
    row, col = np.divmod(poses // HEADINGS, space.n_cols)
    return Ground(
        nexts=nexts,
        before=before,
        home=((row + reach) * width + col + reach).astype(np.int32),
        fans=(data.fans[:, :, 0] * width + data.fans[:, :, 1]).astype(np.int32),
        sizes=data.fan_sizes.astype(np.int32),
        hidden=data.hidden,
        collides=data.blocked,
        width=width,
        turn=data.turn,
    )
