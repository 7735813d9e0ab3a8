"""The joint posterior follows a search: what is seen and said, in any order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.bridge import search
from sloop_ppl.bridge._tracking import BeliefTracker
from sloop_ppl.bridge.searching import imagined_places
from sloop_ppl.errors import BeliefCollapse, InputError, NoRelationFound
from sloop_ppl.inference import infer_description
from sloop_ppl.models import Component, PredictedSpread, preset
from sloop_ppl.planning import SearchConfig, SearchInterrupted, run_search
from tests.scenes import house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(15), street_y=30.0)
OWN = replace(
    preset("bayes"),
    components=(Component("product"),),
    frame_prior=PredictedSpread(kappa=0.5, lapse=0.0, absolute=0.0),
)
SHARED = replace(OWN, shared_frames=True)
TWO = said(
    relation("front", "House", figure="A"),
    relation("behind", "House", figure="B"),
    targets=("A", "B"),
)
MORE = said(relation("near", "MainSt", figure="B"), targets=("B",))
PLACES = {"A": (0.0, -15.0), "B": (0.0, 20.0)}


def posterior(model=SHARED, what=TWO):
    return infer_description(what, CITY, model)[0]


def rng(seed=0):
    return np.random.default_rng(seed)


def found(episode):
    return {t: episode.posterior.belief(t) for t in episode.posterior.targets}


def test_a_frame_of_two_targets_couples_them():
    assert posterior().is_coupled
    assert not posterior(OWN).is_coupled
    alone = said(relation("front", "House", figure="A"), relation("left", "House", figure="A"),
                 targets=("A",))  # fmt: skip
    assert not posterior(SHARED, alone).is_coupled


def test_seeing_one_target_moves_the_other_during_the_search():
    steps = []
    options = {"start": (5.0, -25.0, 270.0), "planner": "random", "on_step": steps.append}
    config = SearchConfig(fov_deg=360, max_steps=1)  # A is in view whatever is done
    episode = search(posterior(), CITY, PLACES, rng=rng(), config=config, **options)
    coupled, steps[:] = steps[-1].beliefs["B"], []
    search(posterior(OWN), CITY, PLACES, rng=rng(), config=config, **options)
    assert episode.observations[-1]["A"] is not None
    assert coupled[8:].sum() > 0.75 > 0.65 > steps[-1].beliefs["B"][8:].sum()
    np.testing.assert_allclose(coupled, episode.posterior.belief("B"), atol=1e-12)


@pytest.mark.parametrize("planner", ["greedy", "random", "pouct"])
def test_targets_that_share_nothing_are_searched_as_ever(planner):
    before = posterior(OWN)
    config = SearchConfig(sims=20, max_steps=12)
    ours = search(before, CITY, PLACES, planner=planner, sims=20, rng=rng(), config=config)
    plain = run_search({t: before.belief(t) for t in "AB"}, CITY, PLACES, planner=planner,
                       config=config, rng=rng(), keep_beliefs=True)  # fmt: skip
    assert ours.to_json() == plain.to_json()
    for target in "AB":
        np.testing.assert_allclose(
            ours.posterior.belief(target), plain.beliefs[-1][target], atol=1e-12
        )


@given(st.permutations(["seen A", "seen B", "said", "seen A later"]), st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_the_order_of_what_is_seen_and_said_is_irrelevant(order, seed):
    draw = np.random.default_rng(seed)
    tables = {
        "seen A": {"A": np.log(draw.uniform(0.05, 1, CITY.grid.shape))},
        "seen B": {"B": np.log(draw.uniform(0.05, 1, CITY.grid.shape))},
        "seen A later": {"A": np.log(draw.uniform(0.05, 1, CITY.grid.shape))},
    }

    def after(names):
        tracker = BeliefTracker(posterior(), {}, rng=rng())
        for name in names:
            tracker.update(MORE) if name == "said" else tracker.observe(tables[name])
        return tracker.posterior

    expected = after(["said", *tables])
    got = after(order)
    for target in "AB":
        np.testing.assert_allclose(got.belief(target), expected.belief(target), atol=1e-12)
    assert float(got.log_evidence) == pytest.approx(float(expected.log_evidence), abs=1e-9)


@pytest.mark.parametrize("step", [0, 3])
def test_what_is_said_on_the_way_counts_from_then_on(step):
    config = SearchConfig(max_steps=5)
    options = {"config": config, "planner": "greedy", "start": (-25.0, 0.0, 90.0)}
    silent = search(posterior(OWN), CITY, PLACES, rng=rng(), keep_beliefs=True, **options)
    told = search(posterior(OWN), CITY, PLACES, rng=rng(), keep_beliefs=True,
                  said={step: MORE}, **options)  # fmt: skip
    same = [
        np.allclose(a["B"], b["B"], atol=1e-9)
        for a, b in zip(silent.beliefs, told.beliefs, strict=False)
    ]
    assert same.index(False) == step
    assert told.utterances == {step: MORE}
    np.testing.assert_allclose(told.beliefs[-1]["B"], found(told)["B"], atol=1e-12)


def test_what_is_said_after_the_end_is_named():
    told = search(posterior(OWN), CITY, PLACES, planner="random", rng=rng(),
                  said={150: MORE}, config=SearchConfig(max_steps=3))  # fmt: skip
    assert told.pending_steps == (150,)
    assert told.utterances == {}


def test_an_episode_can_be_told_more_and_go_on():
    first = search(posterior(), CITY, PLACES, planner="greedy", rng=rng(),
                   start=(-30.0, -30.0, 180.0), config=SearchConfig(max_steps=2))  # fmt: skip
    told = first.update(MORE)
    assert first.utterances == {}
    assert told.utterances == {2: MORE}
    expected = first.posterior.update(MORE)
    np.testing.assert_array_equal(told.posterior.belief("B"), expected.belief("B"))
    whole = told.go_on(40, rng=rng(1))
    assert whole.poses[:3] == first.poses
    assert whole.actions[:2] == first.actions
    assert len(whole.views) == len(whole.poses) == whole.steps + 1 == len(whole.info) + 1
    assert whole.found_targets == ("A", "B")
    assert whole.go_on(rng=rng()) is whole
    assert whole.config == first.config


def test_one_target_after_the_other():
    steps = []
    episode = search(posterior(), CITY, PLACES, planner="greedy", rng=rng(),
                     one_at_a_time=True, on_step=steps.append, keep_beliefs=True)  # fmt: skip
    assert episode.found_targets == ("A", "B")
    assert [s.index for s in steps] == list(range(episode.steps))
    assert steps[-1].found_targets == ("A", "B")
    change = next(i for i, s in enumerate(steps) if s.found_targets) + 1
    assert all(seen["B"] is None for seen in episode.observations[:change])
    assert all(set(b) == {"A", "B"} for b in episode.beliefs)
    assert episode.poses[change] == steps[change - 1].pose


def test_ctrl_c_keeps_the_posterior_and_all_legs():
    def stop(step):
        if "A" in step.found_targets and not step.action.startswith("find"):
            raise KeyboardInterrupt

    with pytest.raises(SearchInterrupted) as stopped:
        search(posterior(), CITY, {"A": PLACES["A"]}, planner="greedy", rng=rng(),
               one_at_a_time=True, on_step=stop)  # fmt: skip
    episode = stopped.value.episode
    assert episode.found_targets == ("A",)
    assert episode.imagined == ("B",)
    assert episode.posterior.belief("A").max() == pytest.approx(1)


def test_an_impossible_sight_can_be_recovered_from():
    nowhere = {"A": np.where(np.arange(15)[:, None] < 3, 0.0, -np.inf) + np.zeros((15, 15))}
    there = {"A": np.where(np.arange(15)[:, None] > 10, 0.0, -np.inf) + np.zeros((15, 15))}
    strict = BeliefTracker(posterior(), {}, rng=rng())
    strict.observe(nowhere)
    with pytest.raises(BeliefCollapse):
        strict.observe(there)
    lenient = BeliefTracker(posterior(), {}, recovery_weight=0.1, rng=rng())
    lenient.observe(nowhere)
    lenient.observe(there)
    belief, start = lenient.posterior.belief("A"), posterior().belief("A")
    np.testing.assert_allclose(belief[11:], start[11:] / start[11:].sum(), atol=1e-12)


def test_imagined_places_agree_on_the_front_they_share():
    """In front of and behind one house lie on opposite sides, so drawn together they differ."""

    def opposite(before):
        drawn = [imagined_places(before, {}, rng=rng(seed)) for seed in range(40)]
        return sum(float(np.dot(places["A"], places["B"])) < 0 for places in drawn)

    assert opposite(posterior()) >= 30 > 27 > opposite(posterior(OWN))


def test_mistakes_are_told_in_one_line():
    with pytest.raises(InputError, match=r"^Words for step -1 are given; expected a step of at"):
        search(posterior(), CITY, PLACES, rng=rng(), said={-1: MORE})
    with pytest.raises(NoRelationFound):
        search(posterior(), CITY, PLACES, rng=rng(), said={1: "hello"})
    with pytest.raises(InputError, match=r"^'C' has no belief; expected a place for each of: A, B"):
        search(posterior(), CITY, {"C": (0.0, 0.0)}, rng=rng())
