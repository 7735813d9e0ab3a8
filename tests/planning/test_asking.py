"""Asking as planning knows it: arrays, costs, and a value that is right on small problems."""

from __future__ import annotations

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.planning import (
    GridBelief,
    QuestionTable,
    Reply,
    SearchConfig,
    SearchSpace,
    SearchState,
    run_search,
)
from sloop_ppl.planning._ask_models import (
    AnswerObservation,
    AskObservationModel,
    AskPolicyModel,
    AskRewardModel,
    AskTransitionModel,
    QuestionBoard,
)
from sloop_ppl.planning._ask_value import ReturnEstimator, answered, question_bits
from sloop_ppl.planning.models import (
    SearchObservationModel,
    SearchPolicyModel,
    SearchRewardModel,
    SearchTransitionModel,
)
from sloop_ppl.rng import scalar_rng

CITY = CityMap("field", Grid.square(100.0), ())
SHAPE = CITY.grid.shape
WEST, EAST = (20, 2), (20, 38)


def two_places():
    belief = np.zeros(SHAPE)
    belief[WEST] = belief[EAST] = 0.5
    return belief


def which(cost=10.0, error=0.0, steps=0, name="west or east?"):
    west = np.zeros(SHAPE)
    west[:, :20] = 1.0
    first = west * (1 - error) + (1 - west) * error
    return QuestionTable(name, "T", np.stack([first, 1 - first]), cost, steps)


class Asked:
    """A questioner who offers some questions and answers truthfully that it is in the east."""

    def __init__(self, *tables, goes_on=True):
        self.tables, self.goes_on, self.asked = tables, goes_on, []

    def questions(self, beliefs, left):
        self.beliefs = beliefs["T"]
        return [t for t in self.tables if t.name not in self.asked]

    def ask(self, question):
        self.asked.append(question.name)
        new = self.beliefs * question.p_answer[1]
        return Reply("east", {"T": new / new.sum()}, self.goes_on)


def search(questioner, planner="fast", **options):
    return run_search(
        {"T": np.maximum(two_places(), 1e-12)}, CITY, {"T": CITY.grid.centre_of(*EAST)},
        planner=planner, config=SearchConfig(sims=400), start=(-20.0, 0.0),
        rng=np.random.default_rng(0), questioner=questioner, **options,
    )  # fmt: skip


def belief_at(col=20, table=None):
    space = SearchSpace.of_city(CITY, ("T",), SearchConfig())
    tables = {"T": two_places() if table is None else table}
    robot = space.robot(space.encode(20, col, 0))
    return GridBelief(space, tables, robot, rng=np.random.default_rng(0))


def test_information_and_answers_of_a_table():
    belief = belief_at()
    assert question_bits(belief, [which(), which(error=0.5)]) == pytest.approx([1.0, 0.0])
    (p, west, tells), (q, east, _) = answered(belief, which())
    assert (p, q, tells) == (0.5, 0.5, True)
    assert west[WEST] == east[EAST] == 1.0


def test_the_value_of_knowing_the_place_is_that_of_the_shorter_way():
    estimator, belief = ReturnEstimator(belief_at().space), belief_at()
    known = []
    for place in (WEST, EAST):
        table = np.zeros(SHAPE)
        table[place] = 1.0
        known.append(estimator.expected_return(belief_at(table=table), 1000))
    unknown = estimator.expected_return(belief, 1000)
    gain = estimator.gain(belief, which(cost=10.0))
    assert gain == pytest.approx(np.mean(known) - unknown - 10)
    assert gain > 50
    late = estimator.gain(belief, which(cost=10.0, steps=3))
    assert late == pytest.approx(0.95**3 * np.mean(known) - unknown - 10)
    # The return of a known place: so many moves at -10, then the find.
    steps = next(n for n in range(1, 60) if np.isclose(known[1], value_in(n), atol=1e-6))
    assert 5 <= steps <= 15


def value_in(n):
    """Return the discounted return of n moves and a find."""
    return sum(-10 * 0.95**t for t in range(n)) + 1000 * 0.95**n


def test_not_knowing_changes_nothing():
    estimator, belief, sure = ReturnEstimator(belief_at().space), belief_at(), which(cost=0.0)
    silent = np.full((1, *SHAPE), 0.3)
    unsure = QuestionTable("hm?", "T", np.concatenate([0.7 * sure.p_answer, silent]))
    assert [tells for _, _, tells in answered(belief, unsure)] == [True, True, False]
    assert estimator.gain(belief, unsure) == pytest.approx(0.7 * estimator.gain(belief, sure))


def test_the_best_question_is_chosen_and_valued_anew():
    estimator, belief = ReturnEstimator(belief_at().space), belief_at()
    offered = [which(error=0.4, name="vague"), which(name="clear"), which(error=0.2, name="mid")]
    best = estimator.best(belief, offered)
    assert offered[best.place].name == "clear"
    assert best.gain == pytest.approx(estimator.gain(belief, offered[1]))
    assert best.bits == pytest.approx(1.0)
    assert estimator.best(belief, [which(error=0.5)]) is None
    assert estimator.best(belief, []) is None


@pytest.mark.parametrize("planner", ["pouct", "pomcp"])
def test_asking_is_an_action_of_the_tree(planner):
    episode = search(Asked(which(cost=5.0)), planner, max_questions=1)
    first = episode.info[0].visits
    if episode.questions and episode.questions[0].step == 0:
        assert not any(name.startswith("ask(") for name in first)  # there was one to ask
    else:
        assert first["ask(west or east?)"] > 0
    assert len(episode.questions) <= 1
    assert episode.found


@pytest.mark.parametrize("planner", ["fast", "greedy"])
def test_it_asks_when_that_pays_and_only_as_often_as_it_may(planner):
    questioner = Asked(which(cost=5.0), which(cost=5.0, name="again?"))
    episode = search(questioner, planner, max_questions=1)
    assert len(episode.questions) == 1
    (asked,) = episode.questions
    assert asked.answer == "east"
    assert asked.bits == pytest.approx(1.0, abs=1e-6)
    assert asked.realised == pytest.approx(1.0, abs=1e-6)
    assert episode.found
    assert episode.discounted_return == pytest.approx(
        sum(0.95**t * r for t, r in enumerate(episode.rewards)) - 5.0 * 0.95**asked.step
    )


def test_it_stops_when_nobody_answers_any_more():
    questioner = Asked(which(0.0), which(0.0, error=0.1, name="again?"), goes_on=False)
    episode = search(questioner, max_questions=9)
    assert questioner.asked == ["west or east?"]
    assert episode.found


def test_nothing_is_asked_that_tells_nothing_or_costs_too_much():
    for table in (which(error=0.5, cost=0.0), which(cost=900.0)):
        questioner = Asked(table)
        assert search(questioner, max_questions=5).questions == ()
        assert questioner.asked == []


def models(left=2):
    tables = which(), which(error=0.25, cost=3.0, name="again?")
    space = SearchSpace.of_city(CITY, ("T",), SearchConfig())
    rng = scalar_rng(np.random.default_rng(0))
    board = QuestionBoard(space, left)
    board.offer(tables)
    return (
        space,
        board,
        AskTransitionModel(SearchTransitionModel(space)),
        AskObservationModel(SearchObservationModel(space), board, 1, rng),
        AskRewardModel(SearchRewardModel(space), board),
        AskPolicyModel(SearchPolicyModel(space, rng), board),
    )


def test_asking_in_the_tree():
    space, board, transition, observation, reward, policy = models()
    west = SearchState(space.robot(space.encode(20, 20, 0)), (WEST[0] * 41 + WEST[1],))
    first, again = board.actions
    assert policy.get_all_actions(west) == (*space.moves, first, again)
    after = transition.sample(west, first)
    assert (after.robot, after.cells, after.asked) == (west.robot, west.cells, 1)
    assert policy.get_all_actions(after) == (*space.moves, again)
    assert transition.sample(after, space.moves[0]).asked == 1
    assert policy.get_all_actions(transition.sample(after, again)) == space.moves
    assert reward.sample(west, again, after) == -3.0
    assert reward.sample(west, space.moves[0], transition.sample(west, space.moves[0])) == -10.0
    p = [observation.probability(AnswerObservation(1, 0, a), after, again) for a in (0, 1)]
    assert p == pytest.approx([0.75, 0.25])
    drawn = [observation.sample(after, again).answer for _ in range(2000)]
    assert abs(np.mean(drawn) - 0.25) < 5 * np.sqrt(0.25 * 0.75 / 2000)  # once in a million
    assert observation.argmax(after, again) == AnswerObservation(1, 0, 0)
    assert after != west
    assert transition.probability(after, west, first) == 1.0
    assert transition.probability(west, west, first) == 0.0
    moved = observation.sample(transition.sample(after, space.moves[0]), space.moves[0])
    assert observation.probability(moved, after, first) == 0.0
    assert AnswerObservation(1, 0, 0) != moved


def test_a_board_without_questions_left_has_no_actions():
    _, board, *_, policy = models(left=0)
    assert board.actions == ()
    assert len(policy.get_all_actions(None)) == 4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cost": -1.0}, "Question 'west or east?' costs -1.0 and takes 0 steps; expected"),
        ({"steps": -1}, "Question 'west or east?' costs 10.0 and takes -1 steps; expected"),
    ],
)
def test_a_question_that_cannot_be(options, message):
    with pytest.raises(InputError) as caught:
        which(**options)
    assert str(caught.value).startswith(message)


def test_a_table_or_a_questioner_that_is_none():
    with pytest.raises(InputError, match=r"have shape \(41, 41\); expected \(answers, rows"):
        QuestionTable("hm?", "T", two_places())
    with pytest.raises(InputError, match="The questioner is a int; expected an object with"):
        search(3)
    with pytest.raises(InputError, match="The number of questions is -1; expected 0 or more"):
        search(Asked(), max_questions=-1)
