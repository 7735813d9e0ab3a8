"""Planners are values, by name or from outside; what is wrong with one is one line."""

from __future__ import annotations

import random

import numpy as np
import pytest
from support.small_searches import agent_of, city_of, space_of

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.planning import (
    PLANNERS,
    Fast,
    Greedy,
    PlanInfo,
    Pomcp,
    Pouct,
    Random,
    RandomRollout,
    SearchConfig,
    SearchPlanner,
    list_planners,
    make_planner,
    planner_of,
    run_search,
)

SHAPE = (9, 11)
WANTED = "a planner's name, or an object with a method plan(agent) that returns an action"


def search(planner, seed=1, **settings):
    return run_search(
        {"A": np.eye(9, 11) + 0.02},
        city_of(*SHAPE),
        {"A": (31.0, 22.0)},
        planner=planner,
        config=SearchConfig(**{"sims": 50, "max_steps": 6, **settings}),
        start=(3.0, 3.0),
        rng=np.random.default_rng(seed),
    )


def test_the_names_come_in_their_order_and_stand_for_values():
    assert list_planners() == ["pouct", "pomcp", "fast", "greedy", "random"]
    assert [PLANNERS[n] for n in PLANNERS] == [Pouct, Pomcp, Fast, Greedy, Random]
    for name, planner in PLANNERS.items():
        assert planner_of(name) == planner() == planner_of(planner)
        assert isinstance(planner(), SearchPlanner)
        assert planner().name == name


def test_planners_are_equal_by_what_they_are_set_to():
    assert Pouct(sims=500) == Pouct(sims=500)
    assert Pouct(sims=500) != Pouct(sims=501)
    assert Pouct() != Pomcp()
    assert len({Greedy(), Greedy(), Fast(hedge=0.1), Fast(hedge=0.1)}) == 2
    assert repr(Pouct(sims=500, exploration=200.0)) == (
        "Pouct(sims=500, depth=None, exploration=200.0, discount=None, rollout=None, "
        "tree_depth=None)"
    )
    with pytest.raises(AttributeError):
        Pouct().sims = 3


def test_a_planners_own_settings_count_and_the_episode_shows_them():
    episode = search(Pouct(sims=20, exploration=50.0, discount=0.9), sims=50)
    assert (episode.config.sims, episode.config.exploration) == (20, 50.0)
    assert episode.config.discount == 0.9
    assert {info.sims for info in episode.info} == {20}
    assert episode.discounted_return == pytest.approx(
        sum(0.9**t * r for t, r in enumerate(episode.rewards))
    )
    assert search(Pouct(), sims=50).config.sims == 50
    with pytest.raises(InputError) as error:
        search(Pouct(sims=0))
    assert str(error.value) == "sims is 0; expected a whole number of at least 1"


@pytest.mark.parametrize("name", PLANNERS)
def test_a_name_a_class_and_a_value_are_one_search(name):
    planner = PLANNERS[name]
    told = [search(p) for p in (name, planner, planner())]
    if name not in ("greedy", "random"):
        told.append(search(planner(sims=50), sims=99))
    assert {episode.planner for episode in told} == {name}
    assert len({(e.actions, e.poses, e.rewards) for e in told}) == 1
    assert {tuple(i.values.items()) for i in told[0].info} == {
        tuple(i.values.items()) for i in told[-1].info
    }


def test_one_value_serves_many_searches():
    planner = Pouct(sims=40)
    first, other, again = search(planner, 1), search(planner, 2), search(planner, 1)
    assert first.actions == again.actions
    assert [dict(i.values) for i in first.info] == [dict(i.values) for i in again.info]
    assert [dict(i.values) for i in first.info] != [dict(i.values) for i in other.info]


def test_a_planner_with_settings_of_its_own_needs_a_space_that_has_them():
    space = space_of(SHAPE, sims=50)
    with pytest.raises(InputError) as error:
        make_planner(Pouct(sims=60), space, rng=np.random.default_rng(0))
    assert str(error.value) == (
        "Planner 'pouct' has settings that the search space does not have; make the space with "
        "SearchSpace(..., planner.settings(config))"
    )
    agent = agent_of(space, {"A": np.ones(SHAPE)}, pose=0)
    running = make_planner(Pouct(sims=50), space, rng=np.random.default_rng(0))
    assert running.plan(agent)[1].sims == 50


class Lefty:
    """A user's planner: left, left, left, then a find; it learns what was done."""

    def __init__(self):
        self.learnt = []

    def plan(self, agent):
        return "left" if len(agent.history) < 3 else "find"

    def update(self, agent, action, observation):
        assert agent.history[-1] == (action, observation)
        self.learnt.append(action.name)


LEFTS = ("left", "left", "left", "find")


def test_a_users_planner_is_an_object_or_its_class():
    lefty = Lefty()
    for planner in (lefty, Lefty):
        episode = search(planner)
        assert (episode.planner, episode.actions) == ("Lefty", LEFTS)
        assert {(info.planner, info.sims) for info in episode.info} == {("Lefty", 0)}
        assert set(episode.info[0].expected) == {"forward", "left", "right"}
    assert lefty.learnt == list(LEFTS)


def test_a_users_planner_may_return_an_action_or_what_it_thinks_of_it():
    class Named(Lefty):
        name = "my own"

        def plan(self, agent):
            action = next(
                a for a in agent.valid_actions() if a.name == super(Named, self).plan(agent)
            )
            return action, PlanInfo("inner", sims=7, values={"left": 3.0})

    episode = search(Named())
    assert (episode.planner, episode.actions) == ("my own", LEFTS)
    assert {(i.planner, i.sims, i.values["left"]) for i in episode.info} == {("inner", 7, 3.0)}

    class Tells(Lefty):
        def plan(self, agent):
            return super().plan(agent), {"anything": "else"}

    assert search(Tells()).actions == LEFTS


def test_a_users_planner_begins_with_the_space_and_its_own_stream():
    class Begins:
        def begin(self, space, *, rng):
            self.space, self.drawn = space, rng.random()

        def plan(self, agent):
            return self.space.moves[1]

    class Makes:
        def begin(self, space, *, rng):
            made = Lefty()
            made.begin = None
            return made

        def plan(self, agent):
            raise AssertionError("what begin returned plans")

    begins = Begins()
    assert search(begins).actions == ("left",) * 6
    assert begins.space.shape == SHAPE
    drawn = [begins.drawn]
    for seed in (1, 2):
        search(begins, seed)
        drawn.append(begins.drawn)
    assert drawn[0] == drawn[1] != drawn[2]
    assert search(Makes()).actions == LEFTS


def test_a_users_planner_forgets_when_the_beliefs_are_replaced():
    class Forgets(Lefty):
        forgot = 0

        def forget(self):
            self.forgot += 1

    planner = Forgets()
    table = np.full(SHAPE, 0.5)
    table[8, 10] = 5.0
    run_search(
        {"A": np.ones(SHAPE)},
        city_of(*SHAPE),
        {"A": (51.0, 42.0)},
        planner=planner,
        config=SearchConfig(max_steps=3),
        start=(3.0, 3.0),
        rng=np.random.default_rng(0),
        on_observation=lambda _: {"A": table},
    )
    assert planner.forgot == 3


def test_a_planner_of_pomdp_py_is_a_planner():
    import pomdp_py

    rollout = RandomRollout(space_of(SHAPE), random.Random(0))
    planner = pomdp_py.POUCT(
        max_depth=5, num_sims=60, exploration_const=1000.0, rollout_policy=rollout
    )
    episode = search(planner)
    assert episode.planner == "POUCT"
    assert episode.steps > 0
    assert planner.last_num_sims == 60


class Wrong:
    def __init__(self, choice):
        self.choice = choice

    def plan(self, agent):
        return self.choice


class Silent:
    def begin(self, space, *, rng):
        return object()

    def plan(self, agent):
        return "left"


@pytest.mark.parametrize(
    ("planner", "message"),
    [
        (Wrong("up"), "Planner 'Wrong' chose 'up'; expected one of: forward, left, right, find"),
        (Wrong(None), "Planner 'Wrong' chose None; expected one of: forward, left, right, find"),
        (Wrong(0), "Planner 'Wrong' chose 0; expected one of: forward, left, right, find"),
        (
            Wrong(("left", "right", "left")),
            (
                "Planner 'Wrong' chose ('left', 'right', 'left'); expected one of: forward, left, "
                "right, find"
            ),
        ),
        (
            Silent(),
            (
                "Planner 'Silent' has no method plan(agent) once it has begun; expected begin to "
                "return an object that plans, or None"
            ),
        ),
        (object(), f"The planner is a object; expected {WANTED}"),
        (None, f"The planner is a NoneType; expected {WANTED}"),
        (SearchConfig, f"The planner is a type; expected {WANTED}"),
        (lambda agent: "left", f"The planner is a function; expected {WANTED}"),
    ],
)
def test_a_planner_that_is_none_or_chooses_wrongly_is_one_line(planner, message):
    with pytest.raises(InputError) as error:
        search(planner)
    assert str(error.value) == message


FILE = """
import random
import pomdp_py
from sloop_ppl.planning import Pouct, RandomRollout, SearchConfig, SearchSpace

class Lefty:
    def plan(self, agent):
        return "left"

class Failing:
    def plan(self, agent):
        raise KeyError("north")

class Slotted:
    __slots__ = ()

    def plan(self, agent):
        return "left"

def make():
    return Lefty()

value = Pouct(sims=30)
rollout = RandomRollout(SearchSpace((9, 11), ("A",), SearchConfig()), random.Random(0))
tree = pomdp_py.POUCT(max_depth=5, num_sims=60, rollout_policy=rollout)
number = 3
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(FILE)
    return path


def test_a_planner_is_taken_from_a_file(file):
    for name in ("Lefty", "make", "Slotted"):
        episode = search(f"{file}:{name}")
        assert (episode.planner, episode.actions) == (f"mine.py:{name}", ("left",) * 6)
    assert search(f"{file}:value").config.sims == 30
    assert search(f"{file}:value").actions == search(Pouct(sims=30)).actions
    assert search(f"{file}:tree").steps > 0


def test_a_planner_of_a_file_serves_many_searches(file):
    planner = planner_of(f"{file}:Lefty")
    depths = []
    for _ in range(3):
        search(planner)
        method, depth = planner.planner.plan, 0
        while (method := getattr(method, "__wrapped__", None)) is not None:
            depth += 1
        depths.append(depth)
    assert depths == [1, 1, 1]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "mine.py:Failing",
            "Planner 'mine.py:Failing' fails in plan at line 12: KeyError: 'north'",
        ),
        (
            "mine.py:number",
            f"Planner 'mine.py:number' is a int; expected {WANTED}",
        ),
        (
            "mine.py:Leffty",
            (
                "Planner of mine.py 'Leffty' is unknown; expected one of Lefty, Failing, Slotted, "
                "make, value, tree; did you mean 'Lefty'?"
            ),
        ),
        (
            "mine.py",
            (
                "Planner 'mine.py' names nothing of the file; there are: mine.py:Lefty, "
                "mine.py:Failing, mine.py:Slotted, mine.py:make, mine.py:value, mine.py:tree; "
                f"expected {WANTED}"
            ),
        ),
        ("yours.py:Lefty", "Planner file 'yours.py' does not exist; give FILE.py:NAME"),
        (
            "broken.py:Lefty",
            "Planner 'broken.py' fails at line 2: NameError: name 'y' is not defined",
        ),
    ],
)
def test_what_is_wrong_with_a_planner_of_a_file_is_one_line(file, monkeypatch, name, message):
    monkeypatch.chdir(file.parent)
    (file.parent / "broken.py").write_text("x = 1\nz = x + y\n")
    with pytest.raises(InputError) as error:
        search(name)
    assert str(error.value) == message


def test_an_unknown_name_is_one_line():
    with pytest.raises(UnknownName) as error:
        search("greed")
    assert str(error.value) == (
        "Planner 'greed' is unknown; expected one of pouct, pomcp, fast, greedy, random; did you "
        "mean 'greedy'?"
    )
