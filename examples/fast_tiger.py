"""Plan for a domain of your own in machine code: the tiger behind one of two doors.

The native-model protocol takes a NamedTuple of data, a NamedTuple of the belief, and four
functions that numba can compile; a state is a vector of whole numbers.

Run: python examples/fast_tiger.py
"""

# ruff: noqa: ARG001, ARG002 - the functions of the protocol take more than a tiger needs

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sloop_ppl.planning import NativeFunctions, NativePouct, register_native, uniform

LISTEN, OPEN_LEFT, OPEN_RIGHT = range(3)


class TigerData(NamedTuple):
    """How well one hears, and the rewards."""

    hear: float
    listen: float
    tiger: float
    gold: float


class TigerBelief(NamedTuple):
    """Probability that the tiger is on the left."""

    left: float


def draw(data, belief, state, random):
    """Draw where the tiger is: 0 left, 1 right."""
    state[0] = 0 if uniform(random) < belief.left else 1


def legal(data, state):
    """All three actions may be taken."""
    return 0b111


def step(data, state, action, random):
    """Listen, or open a door and let the tiger take a new place."""
    if action == LISTEN:
        right = uniform(random) < data.hear
        return data.listen, state[0] if right else 1 - state[0], False
    reward = data.tiger if state[0] == action - OPEN_LEFT else data.gold
    state[0] = 0 if uniform(random) < 0.5 else 1
    return reward, 0 if uniform(random) < 0.5 else 1, False


def policy(data, state, random):
    """Below the leaves, go on listening."""
    return LISTEN


register_native(TigerData, NativeFunctions(draw, legal, step, policy))


class Tiger:
    """The domain, as the planner wants to see it."""

    actions = ("listen", "open-left", "open-right")
    state_size = 1
    data = TigerData(hear=0.85, listen=-1.0, tiger=-100.0, gold=10.0)

    def __init__(self, left=0.5):
        self.left = left

    def belief(self, agent):
        """Return the belief; a pomdp-py domain takes it from the agent."""
        return TigerBelief(self.left)

    def key(self, observation):
        """Return the number that `step` gives for "left" or "right"."""
        return 0 if observation == "left" else 1


def main():
    """Listen until it is clear where the tiger is."""
    tiger = Tiger()
    settings = {"sims": 20_000, "depth": 12, "discount": 0.95, "exploration": 110.0}
    planner = NativePouct(tiger, rng=np.random.default_rng(0), **settings)
    for _ in range(4):
        action = planner.plan(None)  # pyright: ignore[reportArgumentType] - it keeps its own belief
        values = {name: round(value, 1) for name, value in planner.last_info.values.items()}
        print(f"tiger left with probability {tiger.left:.3f}: {action} {values}")
        if action != "listen":
            break
        planner.update(None, action, "left")  # pyright: ignore[reportArgumentType]
        heard = 0.85 * tiger.left
        tiger.left = heard / (heard + 0.15 * (1 - tiger.left))


if __name__ == "__main__":
    main()
