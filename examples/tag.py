"""Chase a target that moves, in pomdp-py's own `tag`, after words about where it was.

A description is evidence about its own time. What was said of step 0 conditions the belief at
step 0, and the domain's prediction carries it on; taken as said of now, it points at a place that
the target has left. The words come late here: three steps after the moment they speak of.

pomdp-py 1.3.5 samples from sets, which Python 3.11 refuses, and its motion policy returns after the
first of several candidates, and its belief forgets the target's place with every attempt to tag.
`Flight`, `Motion` and `Chase` mend that.

    python examples/tag.py
"""

from __future__ import annotations

import argparse
import random
from dataclasses import dataclass

import numpy as np
import pomdp_py
from pomdp_py.problems.tag.agent.agent import TagAgent, belief_update
from pomdp_py.problems.tag.domain.action import MoveEast2D, TagAction
from pomdp_py.problems.tag.domain.state import TagState
from pomdp_py.problems.tag.models.components.grid_map import GridMap
from pomdp_py.problems.tag.models.components.motion_policy import TagTargetMotionPolicy
from pomdp_py.problems.tag.models.policy_model import TagPolicyModel
from pomdp_py.problems.tag.models.transition_model import TagTransitionModel

import sloop_ppl as sloop
from sloop_ppl.bridge import LanguageObservationModel, as_histogram

TEXT = "The dog is just west of the Hat Factory."
DOG = sloop.TargetObject("Dog", ("dog",), None, "dog")
CELL_M = 40.0
LATE = 3
STAYS = 0.2


class Flight(TagTargetMotionPolicy):
    """The target steps away from the robot, each way that leads away being equally likely."""

    def _compute_candidate_actions(self, robot_position, target_position, valid):
        away = super()._compute_candidate_actions(robot_position, target_position, valid)
        return sorted(away, key=str)

    def probability(self, next_target_position, target_position, robot_position, valid):
        """Return the probability of the target's next place."""
        away = self._compute_candidate_actions(robot_position, target_position, valid)
        stays = next_target_position == target_position
        if not away:
            return float(stays)
        if stays:
            return self._pr_stay
        x, y = target_position
        steps = [(x + a.motion[0], y + a.motion[1]) for a in away]
        return (1 - self._pr_stay) * steps.count(next_target_position) / len(steps)


class Motion(TagTransitionModel):
    """A target stays where it is while the robot tries to tag it."""

    def probability(self, next_state, state, action, **options):
        """Return the probability of the next state."""
        if isinstance(action, TagAction) and next_state.target_position != state.target_position:
            return 0.0
        return super().probability(next_state, state, action, **options)


class Chase(TagPolicyModel):
    """All actions, in one order."""

    def get_all_actions(self, state=None, history=None):
        """Return what can be done."""
        return sorted(super().get_all_actions(state, history), key=str)

    def rollout(self, state, history=None):  # noqa: ARG002
        """Tag when there, else go nearer."""
        (x, y), (u, v) = state.robot_position, state.target_position
        if (x, y) == (u, v):
            return TagAction()
        moves = [a for a in self.get_all_actions(state) if not isinstance(a, TagAction)]
        return min(moves, key=lambda a: abs(x + a.motion[0] - u) + abs(y + a.motion[1] - v))


@dataclass(frozen=True)
class Result:
    """Probability of the cell in which the target is, and what the chase brought."""

    then: float
    now: float
    unheard: float
    tagged: bool
    steps: int
    belief: pomdp_py.Histogram


def main(smoke: bool = False) -> Result:
    """Hear late where the target was, and chase it."""
    city = sloop.load_map("cleveland", cell_m=CELL_M)
    height, width = city.grid.shape
    world = GridMap(width, height, set())
    said = sloop.parse(TEXT, city, targets=[DOG])
    words = LanguageObservationModel(
        city, DOG.id, lambda state: (state.target_position[1], state.target_position[0])
    )
    x, y = city.centroid(said.relations[0].ground)
    row, col = city.grid.cell_at(x - CELL_M, y)
    state = TagState((0, 0), (col, row), False)

    uniform = as_histogram(
        np.ones(city.grid.shape), lambda row, col: TagState(state.robot_position, (col, row), False)
    )
    heard = pomdp_py.update_histogram_belief(
        uniform, MoveEast2D, said, words, None, static_transition=True
    )
    chasers = {"then": agent_of(world, heard), "unheard": agent_of(world, uniform)}
    random.seed(1)
    np.random.seed(1)  # noqa: NPY002 - pomdp-py draws from there; imports may too
    course = []  # while the words are on their way, the robot drives east
    for _ in range(LATE):
        state, seen = act(chasers["then"], state, MoveEast2D)
        course.append(seen)
    for seen in course:
        for agent in chasers.values():
            belief_update(agent, MoveEast2D, seen)
    now = pomdp_py.update_histogram_belief(
        chasers["unheard"].cur_belief, MoveEast2D, said, words, None, static_transition=True
    )
    chances = {
        "then": chasers["then"].cur_belief[state],
        "now": now[state],
        "unheard": chasers["unheard"].cur_belief[state],
    }
    belief = chasers["then"].cur_belief
    print(f"“{TEXT}”, heard {LATE} steps late. P(where the target is by now):")
    print(
        "  as said of then {then:.4f}, of now {now:.4f}, not heard {unheard:.4f}".format(**chances)
    )
    tagged, steps = chase(chasers["then"], state, *((30, 4) if smoke else (300, 200)))
    print(f"{'tagged' if tagged else 'not tagged'} after {steps} more steps")
    return Result(**chances, tagged=tagged, steps=steps, belief=belief)


def agent_of(world: GridMap, belief: pomdp_py.Histogram) -> TagAgent:
    """Return the domain's own agent with the mended models."""
    agent = TagAgent(belief, world, pr_stay=STAYS)
    agent.set_models(
        transition_model=Motion(world, Flight(world, STAYS)), policy_model=Chase(world)
    )
    return agent


def act(agent: TagAgent, state: TagState, action) -> tuple[TagState, object]:
    """Return what the world does, by the domain's own models."""
    after = agent.transition_model.sample(state, action)
    return after, agent.observation_model.sample(after, action)


def chase(agent: TagAgent, state: TagState, sims: int, max_steps: int) -> tuple[bool, int]:
    """Plan with pomdp-py's POUCT until the target is tagged.

    The target moves at the same time as the robot, so that four in five times it is gone when the
    robot enters its cell, and only there is it seen: a chase takes some tens of steps.
    """
    planner = pomdp_py.POUCT(
        max_depth=12,
        discount_factor=0.95,
        num_sims=sims,
        exploration_const=20,
        rollout_policy=agent.policy_model,
    )
    for step in range(max_steps):
        action = planner.plan(agent)
        state, seen = act(agent, state, action)
        if isinstance(action, TagAction) and state.target_found:
            return True, step + 1
        agent.update_history(action, seen)
        planner.update(agent, action, seen)
        belief_update(agent, action, seen)
    return False, max_steps


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="plan hardly at all, for tests")
    main(parser.parse_args().smoke)
