"""Say what a plan rests on: its tree as JSON values, and what each move is expected to show."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.values import SearchObservation

__all__ = ["expected_sightings", "flat_tree_to_json", "tree_to_json"]


def expected_sightings(belief: GridBelief) -> Mapping[str, Mapping[str, float]]:
    """Return, by move and target, the belief that the target is in view after the move."""
    space, robot = belief.space, belief.robot
    told = {}
    for move in space.moves:
        view = list(robot.moved(move.index).view)
        told[move.name] = MappingProxyType(
            {
                name: float(table[view].sum())
                for i, (name, table) in enumerate(zip(space.target_ids, belief.flat, strict=True))
                if not robot.found >> i & 1
            }
        )
    return MappingProxyType(told)


def tree_to_json(root: Any, depth: int, n_cols: int | None = None) -> dict[str, Any]:
    """Return the top of a tree of ``pomdp_py.POUCT`` or POMCP as JSON values.

    Parameters
    ----------
    root : a node of the tree, such as ``agent.tree``.
    depth : how many actions deep to go.
    n_cols : columns of the grid, by which cells in observations are named.

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
    cells = ["-" if cell < 0 else str(divmod(cell, n_cols)) for cell in observation.seen]
    return f"seen {' '.join(cells)}, found {observation.found:b}"


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
        if levels[node] > depth:
            continue
        told: dict[str, Any] = {"visits": int(tree.visits[node]), "actions": {}}
        if levels[node] < depth:
            told["actions"] = {
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
            branch["after"][str(int(tree.key[node]))] = told
        kept[node] = told
    return kept[0] if size else {"visits": 0, "actions": {}}
