"""Run a random and a greedy agent in the Gymnasium environment; nothing is trained.

Run: python examples/gym_search.py [--episodes 5]
"""

from __future__ import annotations

import argparse
from typing import Any

import gymnasium
import numpy as np

from sloop_ppl.planning import make_planner
from sloop_ppl.planning.gym_register import ENVIRONMENT, register


class HistoryAgent:
    """What a planner of ours asks of an agent: a belief and what was observed last."""

    def __init__(self, env):
        self._env, self.history = env, ()

    @property
    def belief(self):
        """The environment's belief."""
        return self._env.belief


def random_action(env, rng):
    """Return any action that may be taken."""
    return int(rng.choice(np.flatnonzero(env.action_masks())))


def run(env, choose, seed):
    """Return the discounted reward of one episode."""
    env.reset(seed=seed)
    total, weight, over, cut, info = 0.0, 1.0, False, False, {"reported": {}}
    while not (over or cut):
        _, reward, over, cut, info = env.step(choose(info))
        total += weight * reward
        weight *= env.space.config.discount
    return total


def main():
    """Compare the two agents on the same seeds."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=5)
    episodes = parser.parse_args().episodes
    register()
    env: Any = gymnasium.make(ENVIRONMENT).unwrapped
    greedy = make_planner("greedy", env.space, rng=np.random.default_rng(0))
    agent: Any = HistoryAgent(env)
    rng = np.random.default_rng(0)

    def greedily(info):
        return 3 if info["reported"] else greedy.plan(agent)[0].index

    for name, choose in (("random", lambda _: random_action(env, rng)), ("greedy", greedily)):
        rewards = [run(env, choose, seed) for seed in range(episodes)]
        print(f"{name}: mean discounted reward {np.mean(rewards):.0f} over {episodes} episodes")


if __name__ == "__main__":
    main()
