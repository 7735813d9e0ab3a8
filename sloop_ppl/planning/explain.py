"""Say what a plan rests on: its tree as JSON values, and what each move is expected to show."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._search_tables import likeliest_poses, reach_from
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.motion import ExactMotion
from sloop_ppl.planning.pose import HEADINGS
from sloop_ppl.planning.sensors import FanSensor
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchObservation

__all__ = ["expected_sightings", "flat_tree_to_json", "tree_to_json", "unreachable_notes"]

WORTH_SAYING = 0.05
"""Least belief out of reach that is worth a note."""


def expected_sightings(belief: GridBelief) -> Mapping[str, Mapping[str, float]]:
    """Return, by move and target, the belief that the target is in view after the move."""
    space, robot = belief.space, belief.robot
    expected = {}
    for move in space.moves:
        outcomes = space.outcomes(move.index, robot.pose)
        views = [(chance, list(space.view(pose))) for chance, pose, _ in outcomes]
        expected[move.name] = MappingProxyType(
            {
                name: float(sum(chance * table[view].sum() for chance, view in views))
                for i, (name, table) in enumerate(zip(space.target_ids, belief.flat, strict=True))
                if not robot.found >> i & 1
            }
        )
    return MappingProxyType(expected)


def unreachable_notes(belief: GridBelief) -> tuple[str, ...]:
    """Say of each target how much of its belief no search can bring into view in time.

    Returns
    -------
    tuple of str
        One line for each target of which more than `WORTH_SAYING` is out of reach within the
        steps of the search, every move at its most probable outcome.
    """
    space = belief.space
    limit = space.config.step_limit
    # Where nothing worth a note can be out of reach, spare the breadth-first search.
    if _is_open(space):
        far = ~_surely_seen(space, belief.robot.pose, limit)
        if all(float(table[far].sum()) <= WORTH_SAYING for table in belief.flat):
            return ()
    reach = reach_from(belief.robot.pose, likeliest_poses(space))
    near = np.flatnonzero((reach.steps >= 0) & (reach.steps < limit))
    if len(near) == reach.steps.size and not space.hides:
        return ()
    seen = np.zeros(space.n_cells, dtype=bool)
    if space.hides:
        for pose in near.tolist():
            seen |= space.view_mask(space.pose_at(pose)).reshape(-1)
    else:
        seen = _union_of_fans(space, near)
    hurried = bool((reach.steps >= limit).any())
    notes = []
    for name, table in zip(space.target_ids, belief.flat, strict=True):
        lost = float(table[~seen].sum())
        if lost > WORTH_SAYING:
            part = f"{lost:.0%} of the belief of {name} cannot be brought into view"
            if hurried:
                notes.append(
                    f"{part} within {limit} steps from this start: allow more steps, or start "
                    "elsewhere"
                )
            else:
                notes.append(f"{part} from this start, however many steps: start elsewhere")
    return tuple(notes)


def _is_open(space: SearchSpace) -> bool:
    """Tell whether every cell can be seen, after fewer steps than rows and columns, from anywhere.

    It is so with a quarter fan as long as a step, turns of 45 degrees and nothing in the way.
    """
    sensor, motion = space.sensor, space.motion
    if not isinstance(sensor, FanSensor) or type(motion) is not ExactMotion:
        return False
    # Eight fans of 90 degrees overlap, and a reach of a step leaves no gap between two steps.
    wide = sensor.fov_deg >= 90 and sensor.range_cells >= motion.step_cells
    wide = wide and sensor.min_range_cells <= 1 and motion.turn_deg == 45
    roomy = min(space.shape) >= 4 * motion.step_cells
    return wide and roomy and not (space.no_fly or space.hides)


def _surely_seen(space: SearchSpace, pose: int, limit: int) -> NDArray[np.bool_]:
    """Return cells of an open map that can be seen in so many steps, shape (H * W,)."""
    if limit >= space.n_rows + space.n_cols:
        return np.ones(space.n_cells, dtype=bool)
    # What is open as a whole is so in the part that has robot and cell in two of its corners, when
    # that part is roomy.
    row, col, _ = space.decode(pose)
    roomy = 4 * space.config.step_cells
    north = np.maximum(np.abs(np.arange(space.n_rows) - row) + 1, roomy)
    east = np.maximum(np.abs(np.arange(space.n_cols) - col) + 1, roomy)
    seen: NDArray[np.bool_] = (north[:, None] + east <= limit).ravel()
    return seen


def _union_of_fans(space: SearchSpace, poses: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Return the cells that are in view from some pose, shape (H * W,)."""
    cells, headings = np.divmod(poses, HEADINGS)
    rows, cols = np.divmod(cells, space.n_cols)
    seen = np.zeros(space.shape, dtype=bool)
    for heading, fan in enumerate(space.fans):
        at = headings == heading
        for dr, dc in fan:
            r, c = rows[at] + dr, cols[at] + dc
            inside = (r >= 0) & (r < space.n_rows) & (c >= 0) & (c < space.n_cols)
            seen[r[inside], c[inside]] = True
    return seen.reshape(-1)


def tree_to_json(root: Any, depth: int, n_cols: int | None = None) -> dict[str, Any]:
    """Return the top of a tree of ``pomdp_py.POUCT`` or POMCP, to some depth in actions, as JSON.

    Parameters
    ----------
    n_cols
        Columns of the grid, by which cells in observations are named.

    Returns
    -------
    dict
        ``visits`` and ``actions``: name -> ``value``, ``visits`` and ``after``, which holds the
        same by observation.
    """
    node: dict[str, Any] = {"visits": int(root.num_visits), "actions": {}}
    if depth <= 0:
        return node
    for action, branch in root.children.items():
        node["actions"][str(action)] = {
            "value": float(branch.value),
            "visits": int(branch.num_visits),
            "after": {
                _label(observation, n_cols): tree_to_json(child, depth - 1, n_cols)
                for observation, child in branch.children.items()
            },
        }
    return node


def _label(observation: Any, n_cols: int | None) -> str:
    if not isinstance(observation, SearchObservation):
        return str(observation)
    if n_cols is None:
        return str(observation)
    cells = [_seen(report, n_cols) for report in observation.seen]
    return f"seen {' '.join(cells)}, found {observation.found:b}"


def _seen(report: Any, n_cols: int) -> str:
    if report in (-1, None):
        return "-"
    return str(divmod(report, n_cols) if isinstance(report, int) else report)


def flat_tree_to_json(tree: Any, size: int, actions: tuple[Any, ...], depth: int) -> dict[str, Any]:
    """Return the top of a tree of the planner ``fast``, as `tree_to_json` does.

    Observations are named by their keys.
    """
    n_actions = len(actions)
    levels = np.zeros(size, dtype=np.int64)
    kept: dict[int, dict[str, Any]] = {}
    for node in range(size):
        parent, action = divmod(int(tree.parent[node]), n_actions)
        levels[node] = 0 if node == 0 else levels[parent] + 1
        # Parents come before children, so every node below a kept one is met after it.
        if levels[node] > depth:
            continue
        payload: dict[str, Any] = {"visits": int(tree.visits[node]), "actions": {}}
        if levels[node] < depth:
            payload["actions"] = {
                str(actions[a]): {
                    "value": float(tree.values[node, a]),
                    "visits": int(tree.counts[node, a]),
                    "after": {},
                }
                for a in range(n_actions)
                if tree.legal[node] >> a & 1
            }
        if node:
            branch = kept[parent]["actions"][str(actions[action])]
            branch["after"][str(int(tree.key[node]))] = payload
        kept[node] = payload
    return kept[0] if size else {"visits": 0, "actions": {}}
