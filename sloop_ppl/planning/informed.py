"""Plan on the belief itself: a tree search over paths, which draws no targets."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._pomdp import Agent
from sloop_ppl.planning.baselines import find_worth
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.drive import drive, no_ways
from sloop_ppl.planning.episode import PlanInfo
from sloop_ppl.planning.ground import Worth, ground_of, reach_of
from sloop_ppl.planning.hedge import hedged
from sloop_ppl.planning.outlook import believe, outlook_of
from sloop_ppl.planning.paths import Candidates, explore, worth_of_move
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.sightings import sightings
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.trail import PathTree, Trail
from sloop_ppl.planning.values import SearchAction, SearchObservation

__all__ = ["InformedPlanner"]


SIMS_A_LEVEL = 12
"""Fewest simulations a level; with fewer in all, paths are shorter."""


class InformedPlanner:
    """Search the tree of paths; find what was seen when that is worth it.

    Exact for one target and a sensor without noise, up to the horizon; with more targets it
    counts every target's sighting and neglects the detours after the first. A noisy sensor's
    misses are counted, its false reports are not, except in the decision to find. Paths are
    chosen, and valued, under the hedged belief (`hedge` of `SearchConfig`); what they are expected
    to show is told under the belief itself.

    Parameters
    ----------
    space : the search space.
    rng : not used; nothing is drawn.
    """

    def __init__(self, space: SearchSpace, *, rng: np.random.Generator | None = None) -> None:
        del rng
        self._space = space
        config = space.config
        reach, n_poses = reach_of(space), space.n_cells * HEADINGS
        self._ground = ground_of(space)
        self._outlook = outlook_of(space)
        self._bordered = space.n_rows + 2 * reach, space.n_cols + 2 * reach
        self._inner = slice(reach, reach + space.n_rows), slice(reach, reach + space.n_cols)
        self._sims = config.sims
        self._depth = min(config.depth, max(config.sims // SIMS_A_LEVEL, 1))
        n_cells, n_blocks = self._bordered[0] * self._bordered[1], len(self._outlook.mass)
        most = (self._depth + 1) * self._ground.fans.shape[1]
        self._trail = Trail(
            factor=np.ones(n_cells),
            lost=np.zeros(n_blocks),
            blocks=np.empty(n_blocks, dtype=np.int32),
            cells=np.empty(most, dtype=np.int32),
            shares=np.empty(most),
            ends=np.zeros((self._depth + 1, 2), dtype=np.int64),
            nodes=np.zeros(self._depth + 1, dtype=np.int32),
            wanted=np.zeros(self._depth + 1, dtype=np.int32),
        )
        widest = min(2 * config.sims, 12 * config.sims // self._depth) + 64
        self._tree = _no_tree(config.sims + widest + 4 * self._depth)
        self._found = _no_candidates(widest, n_poses, len(self._tree.pose))
        self._ways = no_ways(n_poses)
        self._plan: NDArray[np.int32] = np.empty(0, dtype=np.int32)

    def plan(self, agent: Agent) -> tuple[SearchAction, PlanInfo]:
        """Return the first move of the best path, or a find."""
        begun = time.perf_counter()
        belief: GridBelief = agent.belief
        space, config = self._space, self._space.config
        found = self._find(belief)
        if found is not None:
            find, value = found
            self.forget()
            seconds = time.perf_counter() - begun
            return find, PlanInfo("fast", seconds=seconds, values={find.name: value})
        worth = self._worth(belief)
        tree = self._tree
        pose = belief.robot.pose
        tree.pose[0], tree.left[0], tree.move[0], tree.child[0] = pose, worth.total, -1, -1
        self._found.level.fill(-1)
        size, last, spent = explore(
            self._ground, worth, self._outlook, tree, self._trail, self._found,
            self._sims, self._depth, self._hint(worth, pose),
        )  # fmt: skip
        path = self._best_path(last, size)
        believed = self._bordered_mass(belief, 0.0)
        chances = self._sightings(believed, path)
        self._plan = tree.move[path]
        values = {m: self._value(worth, 0, m) for m in range(3) if tree.child[0, m] >= 0}
        info = PlanInfo(
            "fast",
            sims=spent,
            seconds=time.perf_counter() - begun,
            values={space.moves[m].name: value for m, value in values.items()},
            visits={space.moves[m].name: int(tree.visits[tree.child[0, m]]) for m in values},
            tree=self._told(worth, believed, [], config.tree_depth) if config.tree_depth else None,
            notes={
                "path": tuple(space.moves[m].name for m in self._plan),
                "expected_seen": tuple(chances.tolist()),
            },
        )
        return space.moves[int(self._plan[0])], info

    def update(self, agent: Agent, action: SearchAction, observation: SearchObservation) -> None:
        """Keep the rest of the path that was planned, as one to go on with."""
        del agent
        follows = len(self._plan) > 0 and self._plan[0] == action.index and not observation.any
        if follows:
            self._plan = self._plan[1:]
        else:
            self.forget()

    def forget(self) -> None:
        """Drop the path that was planned."""
        self._plan = self._plan[:0]

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
        config, space = belief.space.config, belief.space
        flat = self._bordered_mass(belief, config.hedge)
        outlook = self._outlook
        blocks = np.bincount(outlook.block, weights=flat, minlength=len(outlook.mass))
        believe(outlook, blocks.astype(np.float64), space.n_cols)
        return Worth(
            mass=flat,
            total=float(flat.sum()),
            hit=float(config.true_positive_rate),
            move=float(config.move_reward),
            collision=float(config.collision_reward),
            right=float(config.right_find_reward),
            discount=float(config.discount),
        )

    def _bordered_mass(self, belief: GridBelief, hedge: float) -> NDArray[np.float64]:
        """Return the expected number of targets left by cell of the bordered map."""
        mass = np.zeros(self._bordered)
        for i, table in enumerate(belief.flat):
            if not belief.robot.found >> i & 1:
                mass[self._inner] += hedged(table, hedge).reshape(self._space.shape)
        return mass.ravel()

    def _sightings(self, mass: NDArray[np.float64], path: list[int]) -> NDArray[np.float64]:
        """Return how many targets each node of a path is expected to be the first to show."""
        hit, seen = float(self._space.config.true_positive_rate), np.zeros(len(path))
        sightings(self._ground, mass.copy(), hit, self._tree.pose[path], seen)
        return seen

    def _hint(self, worth: Worth, pose: int) -> NDArray[np.int32]:
        """Return the rest of the last plan or, where there is none, the greedy way."""
        if len(self._plan):
            return self._plan
        moves = np.empty(self._depth, dtype=np.int32)
        n = drive(self._ground, worth, self._trail.factor, pose, self._ways, moves)
        return moves[:n]

    def _value(self, worth: Worth, node: int, move: int) -> float:
        return float(worth_of_move(self._ground, worth, self._tree, node, move))

    def _best_path(self, last: int, size: int) -> list[int]:
        """Return the nodes of the path that is worth most, among those followed to the end."""
        tree = self._tree
        weight = self._space.config.discount**self._depth
        scores = tree.past[last:size] + weight * tree.best[last:size]
        node, path = last + int(np.argmax(scores)), []
        while node > 0:
            path.append(node)
            node = int(tree.parent[node])
        return path[::-1]

    def _told(
        self, worth: Worth, believed: NDArray[np.float64], path: list[int], depth: int
    ) -> dict[str, Any]:
        """Return the tree below a path as JSON values; a path goes on while nothing is seen."""
        tree, node = self._tree, path[-1] if path else 0
        children = [int(child) for child in tree.child[node] if child >= 0] if depth else []
        return {
            "visits": int(tree.visits[node]),
            "actions": {
                self._space.actions[tree.move[child]].name: {
                    "value": self._value(worth, node, int(tree.move[child])),
                    "visits": int(tree.visits[child]),
                    "expected_seen": float(self._sightings(believed, [*path, child])[-1]),
                    "after": {
                        "nothing seen": self._told(worth, believed, [*path, child], depth - 1)
                    },
                }
                for child in children
            },
        }


def _whole(size: int) -> NDArray[np.int32]:
    return np.zeros(size, dtype=np.int32)


def _no_tree(size: int) -> PathTree:
    """Return room for a tree."""
    return PathTree(
        pose=_whole(size),
        parent=_whole(size),
        move=_whole(size),
        child=np.full((size, 3), -1, dtype=np.int32),
        first=_whole(size),
        gain=np.zeros(size),
        left=np.zeros(size),
        past=np.zeros(size),
        best=np.zeros(size),
        visits=_whole(size),
        whole=np.zeros(size, dtype=bool),
    )


def _no_candidates(size: int, n_poses: int, n_nodes: int) -> Candidates:
    """Return room for the candidates of a level."""
    return Candidates(
        score=np.zeros(size),
        pose=_whole(size),
        parent=_whole(size),
        move=_whole(size),
        gain=np.zeros(size),
        past=np.zeros(size),
        later=np.zeros(size),
        heap=_whole(size),
        level=np.full(n_poses, -1, dtype=np.int32),
        node=_whole(n_poses),
        before=_whole(n_nodes),
    )
