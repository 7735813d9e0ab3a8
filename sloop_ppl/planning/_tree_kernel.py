"""POUCT in machine code on a tree of flat arrays: the algorithm of ``pomdp_py.POUCT``.

Legend: V nodes; A actions; K slots of the hash table, a power of two; S length of a state.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning._compile import inlined, int64, jit, uncached
from sloop_ppl.planning._native import native_draw, native_legal, native_rollout, native_step

__all__ = [
    "Budget",
    "FlatTree",
    "Scratch",
    "compact",
    "find_child",
    "grow",
    "grow_uncached",
    "new_scratch",
    "new_tree",
]


class FlatTree(NamedTuple):
    """A search tree; node 0 is the root, and a node's parent has a smaller number.

    Attributes
    ----------
    visits
        Visits N of each node, shape (V,).
    legal
        Bit mask of each node's actions, shape (V,).
    parent
        ``parent's node * A + action`` of each node, shape (V,).
    key
        Key of the observation that leads to each node, shape (V,).
    counts
        Visits N_a of each action, shape (V, A).
    values
        Mean return Q_a of each action, shape (V, A).
    slots
        Hash table from parent and key to node, -1 where empty, shape (K,).
    """

    visits: NDArray[np.int32]
    legal: NDArray[np.int32]
    parent: NDArray[np.int64]
    key: NDArray[np.int64]
    counts: NDArray[np.int32]
    values: NDArray[np.float64]
    slots: NDArray[np.int32]


class Budget(NamedTuple):
    """Parameters of the search, as in `SearchConfig`."""

    sims: int
    depth: int
    discount: float
    exploration: float


class Scratch(NamedTuple):
    """Room for one simulation: what was done on the way, and what it earned."""

    path: NDArray[np.int64]
    rewards: NDArray[np.float64]


def new_scratch(depth: int) -> Scratch:
    """Return room for simulations of some depth."""
    return Scratch(np.zeros(depth + 1, dtype=np.int64), np.zeros(depth + 1))


def new_tree(capacity: int, n_actions: int) -> FlatTree:
    """Return an empty tree with room for a number of nodes."""
    # K >= 2 V slots, so that at most half are full and linear probing stays short; K is a power of
    # two, so that a slot is found with a mask instead of a division.
    slots = 1 << max(int(capacity * 2 - 1).bit_length(), 4)
    return FlatTree(
        np.zeros(capacity, dtype=np.int32),
        np.zeros(capacity, dtype=np.int32),
        np.zeros(capacity, dtype=np.int64),
        np.zeros(capacity, dtype=np.int64),
        np.zeros((capacity, n_actions), dtype=np.int32),
        np.zeros((capacity, n_actions), dtype=np.float64),
        np.full(slots, -1, dtype=np.int32),
    )


@inlined
def _slot(tree: FlatTree, parent: int, key: int) -> int:
    """Return the slot that holds the child, or the empty one where it belongs."""
    # Open addressing with linear probing; the tree never fills more than half of the K slots.
    mask = len(tree.slots) - 1
    # Odd multipliers spread neighbouring keys: 2**64 / golden ratio (Fibonacci hashing), and that
    # of the finaliser degski64.
    mixed = (np.uint64(parent) * np.uint64(0x9E3779B97F4A7C15)) ^ np.uint64(key)
    mixed = (mixed ^ (mixed >> np.uint64(32))) * np.uint64(0xD6E8FEB86659FD93)
    slot: int = int64(mixed >> np.uint64(33)) & mask  # of 31 well mixed bits
    while True:
        node = tree.slots[slot]
        if node < 0 or (tree.parent[node] == parent and tree.key[node] == key):
            return slot
        slot = (slot + 1) & mask


@jit
def find_child(tree: FlatTree, node: int, action: int, key: int) -> int:
    """Return the node after an action and an observation, or -1."""
    child: int = tree.slots[_slot(tree, node * tree.counts.shape[1] + action, key)]
    return child


@inlined
def _choose(tree: FlatTree, node: int, exploration: float) -> int:
    """Return the action with the highest upper confidence bound; the first that was not tried."""
    # UCB1: argmax over legal a of Q_a + exploration * sqrt(log(N + 1) / N_a).
    log_visits = math.log(tree.visits[node] + 1.0)
    best, best_bound = -1, -np.inf
    for action in range(tree.counts.shape[1]):
        if tree.legal[node] >> action & 1:
            # The bound of an action that was never tried is infinite: the first of them is taken.
            count = tree.counts[node, action]
            if count == 0:
                return action
            bound = tree.values[node, action] + exploration * math.sqrt(log_visits / count)
            if bound > best_bound:
                best, best_bound = action, bound
    return best


@jit
def grow(
    data: Any,
    belief: Any,
    tree: FlatTree,
    size: int,
    budget: Budget,
    random: Any,
    state: Any,
    scratch: Scratch,
) -> int:
    """Run simulations and return the number of nodes.

    Parameters
    ----------
    tree
        The tree; it must have room for one more node per simulation.
    random
        Stream of random numbers, a vector of one uint64.
    state
        A vector to hold states, int64, shape (S,).
    """
    n_actions = tree.counts.shape[1]
    path, rewards = scratch.path, scratch.rewards
    for _ in range(budget.sims):
        native_draw(data, belief, state, random)
        if size == 0:  # the first simulation makes the root, and its return goes nowhere
            tree.legal[0] = native_legal(data, state)
            tree.parent[0] = -1
            size = 1
            continue
        # Down the tree by UCB1, until an observation leads out of it or the horizon is reached.
        # numba compiles a function anew for a constant argument; int64 makes it a variable.
        node, level, total = int64(0), int64(0), 0.0
        # As in pomdp_py, the tree is walked at depths 0 to `depth` (hence the depth + 1 places of
        # `path` and `rewards`), while a rollout ends before `depth`.
        while level <= budget.depth:
            action = _choose(tree, node, budget.exploration)
            reward, key, over = native_step(data, state, action, random)
            path[level], rewards[level] = node * n_actions + action, reward
            level += 1
            if over or level > budget.depth:
                break
            slot = _slot(tree, path[level - 1], key)
            node = int64(tree.slots[slot])
            if node < 0:
                # A new leaf; what follows is estimated by one rollout.
                tree.slots[slot] = size
                tree.parent[size], tree.key[size] = path[level - 1], key
                tree.legal[size] = native_legal(data, state)
                size += 1
                total = native_rollout(data, state, level, budget.depth, budget.discount, random)
                break
        # Back up: R_i = r_i + discount * R_(i+1), and Q_a becomes the running mean of R_i.
        for i in range(level - 1, -1, -1):
            total = rewards[i] + budget.discount * total
            node, action = path[i] // n_actions, path[i] % n_actions
            tree.visits[node] += 1
            tree.counts[node, action] += 1
            tree.values[node, action] += (total - tree.values[node, action]) / tree.counts[
                node, action
            ]
    return size


grow_uncached = uncached(grow)
"""The same for domains of users, whose types must not get into the cache."""


@jit
def _compact(tree: FlatTree, size: int, root: int, into: FlatTree, place: Any) -> int:
    """Copy the nodes below a root; `place`, all -1, shape (V,), takes their new numbers."""
    n_actions = tree.counts.shape[1]
    kept = 0
    # A node is in the subtree when its parent is; `place` maps old numbers to new ones.
    for node in range(root, size):  # parents come first, so theirs are known
        parent = -1
        if node != root:
            parent = place[tree.parent[node] // n_actions]
            if parent < 0:
                continue
        place[node] = kept
        into.visits[kept], into.legal[kept] = tree.visits[node], tree.legal[node]
        for action in range(n_actions):
            into.counts[kept, action] = tree.counts[node, action]
            into.values[kept, action] = tree.values[node, action]
        into.parent[kept], into.key[kept] = -1, 0
        if parent >= 0:
            into.parent[kept] = parent * n_actions + tree.parent[node] % n_actions
            into.key[kept] = tree.key[node]
            into.slots[_slot(into, into.parent[kept], into.key[kept])] = kept
        kept += 1
    return kept


def compact(tree: FlatTree, size: int, root: int, into: FlatTree) -> int:
    """Copy the part of a tree below a node into an empty tree and return its number of nodes."""
    return _compact(tree, size, root, into, np.full(size, -1, dtype=np.int64))
