# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Bring a pomdp-py domain
#
# You have a POMDP written with pomdp-py, and people who say where things are. This tutorial uses a
# sentence in such a domain in two ways: as its initial belief, and as an observation during the
# run. In the domain, a robot drives over the cells of a map and sees only its own cell.

# %%
import os
import random

import matplotlib.pyplot as plt
import numpy as np
import pomdp_py

import sloop_ppl as sloop
from sloop_ppl.bridge import LanguageObservationModel, Utterance, as_histogram

QUICK = os.environ.get("SLOOP_QUICK") == "1"  # continuous integration plans with fewer simulations
city = sloop.load_map("cleveland", cell_m=20)
HEIGHT, WIDTH = city.grid.shape
CAR = city.grid.cell_at(-47.5, -62.5)  # row and column; row 0 is the southernmost
print(HEIGHT, "x", WIDTH, "cells of 20 m; the car stands at", tuple(int(i) for i in CAR))

# %% [markdown]
# ## The domain
#
# This part does not depend on language. A state is the cells of the robot and of the car.

# %%
MOVES = {"north": (1, 0), "south": (-1, 0), "east": (0, 1), "west": (0, -1)}
ACTIONS = [pomdp_py.SimpleAction(name) for name in (*MOVES, "pick")]
START = (9, 9)


class Place(pomdp_py.SimpleState):
    """The cells of robot and car, each a row and a column."""

    def __init__(self, robot, car):
        super().__init__((robot, car))
        self.robot, self.car = robot, car


def moved(robot, action):
    north, east = MOVES.get(action.name, (0, 0))
    return (
        min(max(robot[0] + north, 0), HEIGHT - 1),
        min(max(robot[1] + east, 0), WIDTH - 1),
    )


class Driving(pomdp_py.TransitionModel):
    def sample(self, state, action):
        return Place(moved(state.robot, action), state.car)

    def probability(self, next_state, state, action):
        return float(next_state == self.sample(state, action))


class Looking(pomdp_py.ObservationModel):
    def sample(self, next_state, action):
        return pomdp_py.SimpleObservation(next_state.robot == next_state.car)

    def probability(self, observation, next_state, action):
        return float(observation == self.sample(next_state, action))


class Picking(pomdp_py.RewardModel):
    def sample(self, state, action, next_state):
        if action.name != "pick":
            return -1.0
        return 100.0 if state.robot == state.car else -100.0


class Going(pomdp_py.RolloutPolicy):
    """Drive to the car's cell in the sampled state."""

    def rollout(self, state, history=()):
        (row, col), (to_row, to_col) = state.robot, state.car
        if row != to_row:
            return ACTIONS[0] if row < to_row else ACTIONS[1]
        if col != to_col:
            return ACTIONS[2] if col < to_col else ACTIONS[3]
        return ACTIONS[4]

    def get_all_actions(self, state=None, history=None):
        return ACTIONS

    def sample(self, state):
        return random.choice(ACTIONS)


# %% [markdown]
# ## A sentence as the initial belief
#
# `as_histogram` turns a belief over cells into a `pomdp_py.Histogram` over your own states.

# %%
said = sloop.parse("The green Toyota is behind Velvet Dog.", city)
posterior = sloop.infer(said, city)


def belief_of(table, robot):
    return as_histogram(table, lambda row, col: Place(robot, (row, col)))


after = belief_of(posterior.belief("GreenToyota"), START)
before = belief_of(np.ones(city.grid.shape), START)
truth = Place(START, tuple(int(i) for i in CAR))
print(f"belief at the true cell: {after[truth]:.4f} with the sentence, {before[truth]:.4f} without")

# %% [markdown]
# ## A sentence as an observation
#
# `LanguageObservationModel` is the likelihood of a description given the target's place, as a
# pomdp-py `ObservationModel`. A uniform belief updated by it is the posterior.

# %%
words = LanguageObservationModel(city, "GreenToyota", lambda state: state.car)
heard = pomdp_py.update_histogram_belief(
    before, ACTIONS[4], Utterance(said), words, None, static_transition=True
)
print("the same:", max(abs(heard[s] - after[s]) for s in after) < 1e-12)

# %% [markdown]
# ## Plan with both
#
# pomdp-py's POUCT plans with each of the two beliefs, with and without the sentence.


# %%
def drive(belief, sims, steps=60):
    """Return the cells that the robot visits, and whether it picks up the car."""
    random.seed(0)
    np.random.seed(0)  # pomdp-py draws from there
    agent = pomdp_py.Agent(belief, Going(), Driving(), Looking(), Picking())
    planner = pomdp_py.POUCT(
        max_depth=12,
        discount_factor=0.95,
        num_sims=sims,
        exploration_const=50,
        rollout_policy=agent.policy_model,
    )
    state, path = truth, [START]
    for _ in range(steps):
        action = planner.plan(agent)
        if action.name == "pick":
            return path, state.robot == state.car
        state = agent.transition_model.sample(state, action)
        seen = agent.observation_model.sample(state, action)
        agent.update_history(action, seen)
        planner.update(agent, action, seen)
        # The car stands still and the sensor is exact, so the update is a mask.
        left = {
            Place(state.robot, s.car): p
            for s, p in agent.belief.get_histogram().items()
            if (s.car == state.robot) == seen.data
        }
        total = sum(left.values())
        agent.set_belief(pomdp_py.Histogram({s: p / total for s, p in left.items()}))
        path.append(state.robot)
    return path, False


sims = 60 if QUICK else 600
runs = {"with the sentence": drive(after, sims), "without": drive(before, sims)}
for name, (path, found) in runs.items():
    print(f"{name:18s} found: {found}, {len(path) - 1} moves")

# %% [markdown]
# ## Look at it

# %%
figure, ax = plt.subplots(figsize=(7, 7), layout="constrained")
sloop.plots.plot_belief(posterior, "GreenToyota", ax=ax, legend=False, title="Two drives")
x_m, y_m = city.grid.x_m, city.grid.y_m
for (name, (path, _)), colour in zip(runs.items(), ("#0b6e99", "#b4530a"), strict=True):
    rows, cols = np.transpose(path)
    ax.plot(x_m[cols], y_m[rows], "-o", markersize=3, color=colour, label=name)
ax.plot(x_m[CAR[1]], y_m[CAR[0]], "X", markersize=11, color="#10855b", label="the car")
ax.legend(loc="upper left")

# %% [markdown]
# Next: [planning with language](../planning_with_language.md) and [search](../search.md), which
# has this package's own planners, sensors and environments.
