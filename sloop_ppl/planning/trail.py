"""A tree of paths, and what one of its paths has seen, marked on the map.

Legend: V nodes; B blocks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import inlined
from sloop_ppl.planning.ground import Ground, Worth
from sloop_ppl.planning.outlook import Outlook

__all__ = ["PathTree", "Trail", "go_to", "retreat"]


class PathTree(NamedTuple):
    """Paths from the robot's pose; node 0 is the root, and levels follow one another.

    Attributes
    ----------
    pose, parent, move : where a node is, the node before it, and the move between, shape (V,).
    child : node after each move, -1 where it was not gone on with, shape (V, 3).
    first : the first move of the path to a node, shape (V,).
    gain : expected number of targets that are first seen on entering it, shape (V,).
    left : expected number of targets that are left, shape (V,).
    past : discounted rewards up to the node, shape (V,).
    best : worth of what follows, as far as it is known, shape (V,).
    visits : how many simulations began at it or below, shape (V,).
    whole : whether a path through it was followed to the end, shape (V,).
    """

    pose: NDArray[np.int32]
    parent: NDArray[np.int32]
    move: NDArray[np.int32]
    child: NDArray[np.int32]
    first: NDArray[np.int32]
    gain: NDArray[np.float64]
    left: NDArray[np.float64]
    past: NDArray[np.float64]
    best: NDArray[np.float64]
    visits: NDArray[np.int32]
    whole: NDArray[np.bool_]


class Trail(NamedTuple):
    """What one path has seen, marked on the map; going on to a path beside it changes little.

    Attributes
    ----------
    factor : share of each cell's mass that is left, bordered map; all ones at the root.
    lost : mass that is no longer left in each block, shape (B,).
    blocks : the blocks in which some was lost, shape (B,).
    cells : cells in the order in which they were seen; `shares` is what was left of each before.
    ends : how many cells and how many blocks there are at each level, shape (levels + 1, 2).
    nodes : the path, by level, shape (levels + 1,).
    wanted : room for another, shape (levels + 1,).
    """

    factor: NDArray[np.float64]
    lost: NDArray[np.float64]
    blocks: NDArray[np.int32]
    cells: NDArray[np.int32]
    shares: NDArray[np.float64]
    ends: NDArray[np.int64]
    nodes: NDArray[np.int32]
    wanted: NDArray[np.int32]


@inlined
def _see(
    ground: Ground, worth: Worth, outlook: Outlook, tree: PathTree, trail: Trail, level: int
) -> None:
    """Mark what the node at a level of the path shows."""
    n_cells, n_blocks = trail.ends[level - 1, 0], trail.ends[level - 1, 1]
    pose = tree.pose[trail.nodes[level]]
    home, heading = ground.home[pose], pose & 7
    for k in range(ground.sizes[heading]):
        if len(ground.hidden) > 0 and ground.hidden[pose, k]:
            continue
        cell = home + ground.fans[heading, k]
        share = trail.factor[cell]
        seen = worth.mass[cell] * share * worth.hit
        if seen > 0.0:
            trail.factor[cell] = share * (1.0 - worth.hit)
            trail.cells[n_cells], trail.shares[n_cells] = cell, share
            n_cells += 1
            block = outlook.block[cell]
            if trail.lost[block] == 0.0:
                trail.blocks[n_blocks] = block
                n_blocks += 1
            trail.lost[block] += seen
    trail.ends[level, 0], trail.ends[level, 1] = n_cells, n_blocks


@inlined
def retreat(worth: Worth, outlook: Outlook, trail: Trail, level: int, to: int) -> None:
    """Take the marks of the levels above one back."""
    for i in range(trail.ends[level, 0] - 1, trail.ends[to, 0] - 1, -1):
        cell = trail.cells[i]
        trail.factor[cell] = trail.shares[i]
        trail.lost[outlook.block[cell]] -= worth.mass[cell] * trail.shares[i] * worth.hit
    for i in range(trail.ends[to, 1], trail.ends[level, 1]):
        trail.lost[trail.blocks[i]] = 0.0


@inlined
def go_to(
    ground: Ground,
    worth: Worth,
    outlook: Outlook,
    tree: PathTree,
    trail: Trail,
    node: int,
    level: int,
    marked: int,
) -> None:
    """Mark what the path to a node at some level has seen, where `marked` levels of one are."""
    for i in range(level, 0, -1):
        trail.wanted[i] = node
        node = tree.parent[node]
    same = 0
    while same < min(level, marked) and trail.wanted[same + 1] == trail.nodes[same + 1]:
        same += 1
    retreat(worth, outlook, trail, marked, same)
    for i in range(same + 1, level + 1):
        trail.nodes[i] = trail.wanted[i]
        _see(ground, worth, outlook, tree, trail, i)
