"""Plan on the belief itself: a tree search over paths, which draws no targets."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._belief_mass import add_mass, eighth_power, sum_by_block
from sloop_ppl.planning._greedy_path import greedy_path, new_scouts
from sloop_ppl.planning._path_kernel import explore, new_candidates, new_tree
from sloop_ppl.planning._path_map import (
    Objective,
    detection_masses,
    new_path_state,
    path_map_of,
)
from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning._search_tables import reach_of
from sloop_ppl.planning._value_bound import set_mass, value_bound_of
from sloop_ppl.planning.baselines import find_value
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.planners import RunningPlanner, overridden
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.tree_search import PouctFallback
from sloop_ppl.planning.values import SearchAction, SearchObservation

__all__ = ["PathSearch", "RunningPathSearch", "sharpened"]

SIMS_A_LEVEL = 12
"""Fewest simulations a level; with fewer in all, paths are shorter."""

_LAST_STAMP = np.iinfo(np.int32).max

_SQUARINGS = 3
"""The sharper belief is the belief to the power of 2 to this, which is 8."""


@dataclass(frozen=True)
class PathSearch:
    """Search the tree of paths; find what was detected when that is worth it.

    Exact for one target and a sensor without noise, up to the horizon; with more targets it
    counts every target's detection and neglects the detours after the first. A noisy sensor's
    misses are counted, its false reports are not, except in the decision to find; of a motion's
    outcomes the most probable counts. Paths are chosen, and valued, under the sharpened belief
    (`hedge` of `SearchConfig`); what they are expected to show is reported under the belief itself.
    Nothing is drawn.

    Parameters
    ----------
    sims, depth, discount, hedge, tree_depth
        As in `SearchConfig`, whose values count where None is given.
    """

    sims: int | None = None
    depth: int | None = None
    discount: float | None = None
    hedge: float | None = None
    tree_depth: int | None = None

    name = "fast"

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings of a search with the planner's own in their places."""
        return replace(overridden(config, self), rollout=None)

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; only its fallback draws from `rng`."""
        return RunningPathSearch(space) if space.sees_mask else PouctFallback(space, rng)


class RunningPathSearch:
    """The path search in the course of one search."""

    def __init__(self, space: SearchSpace) -> None:
        self._space = space
        config = space.config
        reach = reach_of(space)
        self._map = path_map_of(space)
        self._bound = value_bound_of(space, self._map)
        self._bordered = space.n_rows + 2 * reach, space.n_cols + 2 * reach
        self._reach = reach
        self._powers = np.empty(space.n_cells if config.hedge else 0)
        self._sims = config.sims
        # A level needs about a dozen simulations to choose among paths; docs/search.md.
        self._depth = min(config.horizon, max(config.sims // SIMS_A_LEVEL, 1))
        n_cells, n_poses = self._bordered[0] * self._bordered[1], space.n_cells * HEADINGS
        self._state = new_path_state(
            n_cells, len(self._bound.blocks), self._depth, self._map.fans.shape[1]
        )
        # A level takes 12 times its even share of the simulations at most, and never all of them
        # twice; 64 for the paths that are kept in any case.
        widest = min(2 * config.sims, 12 * config.sims // self._depth) + 64
        # Nodes are kept extensions: no more than simulations, the last level, and 4 wanted ones a
        # level.
        self._tree = new_tree(config.sims + widest + 4 * self._depth)
        self._found = new_candidates(widest, n_poses)
        self._scouts = new_scouts(space, len(self._bound.blocks), reach)
        self._stamp = 1
        self._plan: NDArray[np.int64] = np.empty(0, dtype=np.int64)
        self._expected = -1  # the pose after the first move of the plan, if it does not slip

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the first move of the best path, or a find."""
        begun = time.perf_counter()
        belief: GridBelief = agent.belief
        space, config = self._space, self._space.config
        found = self._find(belief)
        # After a find the belief is another one: the rest of the plan was made for a miss.
        if found is not None:
            find, value = found
            self.forget()
            seconds = time.perf_counter() - begun
            return find, PlanInfo("fast", seconds=seconds, values={find.name: value})
        self._learn_view(belief)
        objective = self._objective(belief)
        tree, pose = self._tree, belief.robot.pose
        root = tree[0]
        root["pose"], root["remaining"] = pose, objective.total
        root["move"], root["child"] = -1, -1
        if self._stamp > _LAST_STAMP - self._depth:
            self._found.kept["stamp"], self._stamp = 0, 1
        size, last, spent = explore(
            self._map, objective, self._bound, tree, self._state, self._found,
            self._sims, self._depth, self._hint(objective, pose), self._stamp,
        )  # fmt: skip
        self._stamp += self._depth
        path = self._best_path(last, size)
        chances = self._detected(belief, path)
        self._plan = tree["move"][path]
        children = {m: tree[child] for m, child in enumerate(root["child"]) if child >= 0}
        info = PlanInfo(
            "fast",
            sims=spent,
            seconds=time.perf_counter() - begun,
            values={space.moves[m].name: self._value(objective, c) for m, c in children.items()},
            visits={space.moves[m].name: int(c["visits"]) for m, c in children.items()},
            tree=self._tree_below([], objective, belief, config.tree_depth)
            if config.tree_depth
            else None,
            notes={
                "path": tuple(space.moves[m].name for m in self._plan),
                "expected_seen": tuple(chances.tolist()),
            },
        )
        move = int(self._plan[0])
        self._expected = space.moved(move, pose)[0]
        return space.moves[move], info

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Keep the rest of the path that was planned, as one to go on with."""
        # A detection ends what the plan assumes, and a slip leads to a pose that it does not go on
        # from.
        follows = len(self._plan) > 0 and self._plan[0] == action.index and not observation.any
        if follows and agent.belief.robot.pose == self._expected:
            self._plan = self._plan[1:]
        else:
            self.forget()

    def forget(self) -> None:
        """Drop the path that was planned."""
        self._plan = self._plan[:0]

    def path_return(self, belief: GridBelief, share: float) -> float:
        """Return the expected discounted return of the path that was planned last.

        Parameters
        ----------
        belief
            What it is judged by, at its word; where the robot is.
        share
            Share of the value bound that counts for what the path does not detect.

        Notes
        -----
        ``G_T + g ** T * share * V_T``: exact over the cells, with the belief itself instead of the
        sharpened one that the path was chosen by, up to the horizon T.
        """
        config, objective = self._space.config, self._objective_of(belief, 0.0)
        pose, poses = belief.robot.pose, []
        rewards = []
        for move in self._plan:
            stopped = len(self._map.collides) > 0 and self._map.collides[move, pose]
            rewards.append(objective.collision if stopped else objective.move)
            pose = self._space.next_pose(int(move), pose)
            poses.append(pose)
        detected = np.zeros(len(poses))
        left = objective.mass.copy()
        detection_masses(self._map, left, self._space.hit, np.array(poses), detected)
        remaining = np.minimum(objective.total - np.cumsum(detected) + detected, 1.0)
        weight = config.discount ** np.arange(len(poses))
        later = config.discount * config.right_find_reward * detected
        total = float((weight * (np.array(rewards) * remaining + later)).sum())
        by_block = self._by_block(left)
        row, col, heading = self._space.decode(pose)
        if len(self._bound.around):
            promised = float(self._bound.around[pose] @ by_block)
        else:
            blocks, bound = self._bound.blocks, self._bound.bound
            north = blocks["row"] - row + (bound.shape[1] - 1) // 2
            east = blocks["col"] - col + (bound.shape[2] - 1) // 2
            promised = float(bound[heading, north, east] @ by_block)
        return total + config.discount ** len(poses) * share * promised

    def _learn_view(self, belief: GridBelief) -> None:
        """Take from the robot's pose what it did not show to a robot between cells."""
        unseen, hidden, pose = belief.unseen, self._map.hidden, belief.robot.pose
        if not unseen and not len(hidden):
            return
        if not len(hidden):
            shape = self._space.n_cells * HEADINGS, self._map.fans.shape[1]
            hidden = np.zeros(shape, dtype=bool)
            self._map = self._map._replace(hidden=hidden)
        space = self._space
        shown = belief.robot.view - unseen
        row, col, heading = space.decode(pose)
        for place, (dr, dc) in enumerate(space.fans[heading]):
            inside = 0 <= row + dr < space.n_rows and 0 <= col + dc < space.n_cols
            hidden[pose, place] = not inside or (row + dr) * space.n_cols + col + dc not in shown

    def _find(self, belief: GridBelief) -> tuple[SearchAction, float] | None:
        """Return the best find and its value, when it is worth more than looking once more."""
        if not belief.robot.looked:
            return None
        config = belief.space.config
        values = [find_value(belief, find) for find in belief.space.finds]
        best = int(np.argmax(values))
        # value = p R + (1 - p) W of the best find, solved for the probability p that it is right.
        span = config.right_find_reward - config.wrong_find_reward
        chance = (values[best] - config.wrong_find_reward) / span if span else 0.0
        # Looking once more costs a move, r + g**2 * p h R: the look, then the find of what it
        # shows.
        again = chance * belief.space.hit * config.right_find_reward
        wait = config.move_reward + config.discount**2 * again
        if values[best] <= 0 or (chance < 1 - 1e-9 and values[best] < wait):
            return None
        return belief.space.finds[best], values[best]

    def _objective(self, belief: GridBelief) -> Objective:
        """Return what counts under a belief, and give its mass to the value bound."""
        bound = self._bound
        objective = self._objective_of(belief, belief.space.config.hedge)
        set_mass(bound, self._by_block(objective.mass), belief.space.n_cols)
        return objective

    def _by_block(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mass of each block, shape (B,)."""
        sums = np.zeros(len(self._bound.blocks))
        sum_by_block(mass, self._bound.block, sums)
        return sums

    def _objective_of(self, belief: GridBelief, share: float) -> Objective:
        """Return what counts under a belief, a share of which is sharpened."""
        config, space = belief.space.config, belief.space
        mass = self._mass(belief, share)
        return Objective(
            mass=mass,
            total=float(mass.sum()),
            hit=space.hit,
            move=float(config.move_reward),
            collision=float(config.collision_reward),
            right=float(config.right_find_reward),
            discount=float(config.discount),
        )

    def _mass(self, belief: GridBelief, share: float) -> NDArray[np.float64]:
        """Return the expected number of targets left by cell of the bordered map, shape (G,)."""
        mass = np.zeros(self._bordered)
        for i, table in enumerate(belief.flat):
            if not belief.robot.found >> i & 1:
                # Independent targets add up; the border stays empty.
                if share == 0.0:
                    add_mass(mass, table, 1.0, self._powers[:0], 0.0, self._reach)
                    continue
                eighth_power(table, float(table.max()), self._powers)
                sharp = share / float(self._powers.sum())  # see `sharpened`
                add_mass(mass, table, 1.0 - share, self._powers, sharp, self._reach)
        return mass.ravel()

    def _detected(self, belief: GridBelief, path: list[int]) -> NDArray[np.float64]:
        """Return how many targets each node of a path is expected to be the first to show."""
        space, detected = self._space, np.zeros(len(path))
        wanted = [t for i, t in enumerate(belief.flat) if not belief.robot.found >> i & 1]
        left: dict[int, float] = {}
        for i, pose in enumerate(self._tree["pose"][path].tolist()):
            for cell in self._shown(pose):
                mass = left.get(cell)
                if mass is None:
                    mass = sum(float(table[cell]) for table in wanted)
                detected[i] += space.hit * mass
                left[cell] = mass * (1.0 - space.hit)
        return detected

    def _shown(self, pose: int) -> list[int]:
        """Return the cells in view from a pose, flat indices in the order of the fan."""
        space, hidden = self._space, self._map.hidden
        row, col, heading = space.decode(pose)
        return [
            (row + dr) * space.n_cols + col + dc
            for place, (dr, dc) in enumerate(space.fans[heading])
            if 0 <= row + dr < space.n_rows
            and 0 <= col + dc < space.n_cols
            and not (len(hidden) and hidden[pose, place])
        ]

    def _hint(self, objective: Objective, pose: int) -> NDArray[np.int64]:
        """Return the rest of the last plan or, where there is none, the greedy path."""
        if len(self._plan):
            return self._plan
        moves = np.empty(self._depth, dtype=np.int64)
        n = greedy_path(self._map, objective, self._bound, pose, self._scouts, moves)
        return moves[:n]

    def _value(self, objective: Objective, child: Any) -> float:
        """Return the value of the move to a child, ``r * min(L, 1) + g * (R * D + ahead)``."""
        parent, collides = self._tree[child["parent"]], self._map.collides
        stopped = len(collides) > 0 and collides[child["move"], parent["pose"]]
        reward = objective.collision if stopped else objective.move
        later = objective.right * child["detected"] + child["ahead"]
        return float(reward * min(parent["remaining"], 1.0) + objective.discount * later)

    def _best_path(self, last: int, size: int) -> list[int]:
        """Return the nodes of the path of the highest value, among those followed to the end."""
        tree = self._tree
        weight = self._space.config.discount**self._depth
        # Paths of the last level have T moves: G_T + g ** T * V_T.
        scores = tree["past"][last:size] + weight * tree["ahead"][last:size]
        node, path = last + int(np.argmax(scores)), []
        while node > 0:
            path.append(node)
            node = int(tree[node]["parent"])
        return path[::-1]

    def _tree_below(
        self, path: list[int], objective: Objective, belief: GridBelief, depth: int
    ) -> dict[str, Any]:
        """Return the tree below a path as JSON values; a path goes on while nothing is detected."""
        tree, node = self._tree, self._tree[path[-1] if path else 0]
        children = [int(child) for child in node["child"] if child >= 0] if depth else []
        return {
            "visits": int(node["visits"]),
            "actions": {
                self._space.actions[tree[child]["move"]].name: {
                    "value": self._value(objective, tree[child]),
                    "visits": int(tree[child]["visits"]),
                    "expected_seen": float(self._detected(belief, [*path, child])[-1]),
                    "after": {
                        "nothing seen": self._tree_below(
                            [*path, child], objective, belief, depth - 1
                        )
                    },
                }
                for child in children
            },
        }


def sharpened(table: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Return a power mixture: a belief, a share of which is replaced by its eighth power.

    Parameters
    ----------
    table
        Belief b over cells, >= 0, summing to one; any shape.
    share
        How much is replaced, s in [0, 1]; 0 returns the belief as it is.

    Returns
    -------
    numpy.ndarray
        ``(1 - s) * b + s * b ** 8 / sum(b ** 8)``, summing to one, shape as `table`. A uniform
        belief is left as it is, and no two cells change their order.

    Notes
    -----
    Not in the paper. A path that takes a belief at its word looks at the slopes on its way to the
    peak; where targets lie nearer to the peaks than the belief says, that is a loss.
    """
    if share == 0.0:
        return table
    # Divided by the greatest first, so that the eighth power does not underflow everywhere.
    sharper = table / table.max()
    for _ in range(_SQUARINGS):
        sharper *= sharper
    mixed: NDArray[np.float64] = (1.0 - share) * table + (share / sharper.sum()) * sharper
    return mixed
