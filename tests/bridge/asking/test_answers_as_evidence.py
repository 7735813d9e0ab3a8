"""An answer is a factor over named latents: by hand, by brute force, in any order, and saved."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from sloop_ppl.bridge.asking import AnswererModel, ask
from sloop_ppl.errors import BeliefCollapse, InputError
from sloop_ppl.inference import AnswerFactor, Posterior, infer_description
from sloop_ppl.language import Candidate, Reading
from sloop_ppl.maps import CityMap, Landmark
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
GRID = CITY.grid
TWO = CityMap(
    "two",
    symmetric_grid(21),
    tuple(
        Landmark(name, "poi", shapely.Point(x, 0.0), name=name)
        for name, x in (("West", -30.0), ("East", 30.0))
    ),
)


def posterior(description=None, city=CITY, model="bayes", **options):
    description = description or said(relation("near", "House"))
    return infer_description(description, city, model, **options)[0]


def about_cell(p, answer="yes", target=TARGET):
    table = np.asarray(p, dtype=float).reshape(-1)
    return AnswerFactor("Is it?", answer, (f"{target}/cell",), (range(len(table)),), table, table)


def open_ground(word="near"):
    """Return a relation to one of two places, the western one thought likelier."""
    slot = (Candidate("West", 0.7), Candidate("East", 0.2), Candidate(None, 0.1))
    one = relation(word, "West")
    return type(one)(TARGET, word, ("West",), candidates=(slot,), mentions=(0,))


def test_an_answer_about_the_cell_is_bayes_rule():
    before = posterior()
    p = np.random.default_rng(0).uniform(0.1, 1.0, GRID.shape)
    after = before.update(about_cell(p))
    expected = before.belief(TARGET) * p
    np.testing.assert_allclose(after.belief(TARGET), expected / expected.sum(), atol=1e-14)
    evidence = math.log((before.belief(TARGET) * p).sum())
    assert after.joint.log_evidence - before.joint.log_evidence == pytest.approx(evidence)


def test_an_answer_about_the_referent_is_summed_with_its_prior():
    before = posterior(said(open_ground()), TWO)
    (name,) = [n for n in before.joint.latents if n.startswith("ground_")]
    support = tuple(before.joint.support(name))
    likelihood = np.array([{"West": 0.1, "East": 0.8, "NotOnMap": 0.1}[v] for v in support])
    answer = AnswerFactor("Which?", "East", (name,), (support,), likelihood, likelihood * 0.9)
    after = before.update(answer)
    joint = before.joint.probabilities(name, f"{TARGET}/cell") * likelihood[:, None]
    joint /= joint.sum()
    np.testing.assert_allclose(after.belief(TARGET).ravel(), joint.sum(0), atol=1e-14)
    np.testing.assert_allclose(after.joint.probabilities(name), joint.sum(1), atol=1e-14)
    assert dict(zip(support, joint.sum(1), strict=True))["East"] > 0.6
    assert before.grounds(TARGET)[0].candidates[0].ground == "West"
    assert after.grounds(TARGET)[0].candidates[0].ground == "East"


def test_an_answer_about_a_reading_moves_it():
    near = relation("near", "West")
    two = (Reading(0.8, (near,)), Reading(0.2, (relation("near", "East"),)))
    description = said(near)
    description = type(description)("it is so", "", description.targets, (near,), readings=two)
    before = posterior(description, TWO)
    question = next(q for q in ask(before, TWO, 9, kinds=["reading"]) if "West" in q.text)
    assert question.about == "reading"
    assert question.text == "Do you mean that RedCar is near West?"
    after = before.update(question.answer("no"))
    assert before.readings()[0].p > 0.6
    assert after.readings()[0].p < 0.4
    assert after.mode(TARGET)[0] > 0 > before.mode(TARGET)[0]


def test_an_answer_about_the_front_agrees_with_brute_force_over_the_frame():
    before = posterior(said(relation("behind", "House")), model=MIXTURE)
    name = f"{TARGET}/frame_0"
    angles = np.array(before.joint.support(name))
    likelihood = np.where(np.cos(angles) > 0.5, 0.9, 0.1)
    answer = AnswerFactor(
        "Which way?", "east", (name,), (tuple(angles),), likelihood, likelihood * 0.9
    )
    after = before.update(answer)
    joint = before.joint.probabilities(name, f"{TARGET}/cell") * likelihood[:, None]
    joint /= joint.sum()
    np.testing.assert_allclose(after.belief(TARGET).ravel(), joint.sum(0), atol=1e-12)
    np.testing.assert_allclose(after.joint.probabilities(name), joint.sum(1), atol=1e-12)
    # The summaries, which do not go through the joint table, tell the same.
    east_before = before.frame(TARGET, bins=72).sel(angle=0.0, method="nearest")
    east_after = after.frame(TARGET, bins=72).sel(angle=0.0, method="nearest")
    assert float(east_after) > 2 * float(east_before)
    table = after.joint_frame(TARGET, bins=72)
    np.testing.assert_allclose(
        table.sum("angle").values.ravel(), after.belief(TARGET).ravel(), atol=5e-4
    )


def test_answers_commute_among_themselves_and_with_what_is_said_and_seen():
    rng = np.random.default_rng(1)
    answers = [about_cell(rng.uniform(0.05, 1.0, GRID.shape), str(n)) for n in range(3)]
    more = said(relation("north", "House"))
    seen = {TARGET: np.log(rng.uniform(0.1, 1.0, GRID.shape))}
    beliefs = []
    for order in itertools.permutations(range(3)):
        post = posterior()
        for place, n in enumerate(order):
            post = post.update(answers[n])
            post = post.condition(seen) if place == order[0] else post
            post = post.update(more) if place == order[1] else post
        beliefs.append(post.belief(TARGET))
    for belief in beliefs[1:]:
        np.testing.assert_allclose(belief, beliefs[0], atol=1e-14)


def test_an_answer_to_a_question_that_was_not_asked_is_refused():
    asked, other = posterior(said(open_ground()), TWO), posterior()
    (question,) = ask(asked, TWO, 1, kinds=["referent"])
    answer = question.answer(question.options[0])
    with pytest.raises(InputError) as caught:
        other.update(answer)
    assert str(caught.value) == (
        f"Answer '{question.options[0]}' is to a question that was not asked here: it is about "
        "'ground_0', which this posterior does not have; ask again with "
        "sloop_ppl.ask(posterior, city)"
    )
    small = about_cell(np.full(9, 0.5))
    with pytest.raises(InputError, match="'RedCar/cell' has other values in this posterior"):
        other.update(small)
    renamed = AnswerFactor(
        answer.question, "x", answer.latents, answer.supports, answer.likelihood, answer.meant,
        text="another sentence",
    )  # fmt: skip
    with pytest.raises(InputError, match="it is about “another sentence”, which was not said"):
        asked.update(renamed)


def test_of_contradictory_answers_the_less_probable_is_doubted():
    person = AnswererModel.exact(0.1)
    west = np.broadcast_to(GRID.x_m[None, :] < 0, GRID.shape)
    truth = np.stack([west.ravel(), ~west.ravel()]).astype(float)
    p = person.likelihood(truth, 0.0)

    def answered(row, text):
        return AnswerFactor(
            "East or west?",
            text,
            (f"{TARGET}/cell",),
            (range(GRID.size),),
            p[row],
            0.9 * truth[row],
        )

    post = posterior(said(relation("near", "House")))  # which lies in the east
    for row, text in ((0, "west"), (1, "east")):
        post = post.update(answered(row, text))
    doubted, trusted = post.checked_answers()
    assert (doubted.factor.answer, trusted.factor.answer) == ("west", "east")
    assert doubted.p < 0.5 < trusted.p
    assert doubted.p + trusted.p == pytest.approx(1, abs=0.02)  # nearly all mass is 0.9 or 0.1
    east = float(post.belief(TARGET)[~west].sum())
    assert trusted.p == pytest.approx(east * 1.0, abs=1e-9)  # right iff it lies in the east


def test_answers_that_exclude_each_other_name_themselves():
    west = np.broadcast_to(GRID.x_m[None, :] < 0, GRID.shape).astype(float)
    post = posterior().update(about_cell(west, "in the west"))
    with pytest.raises(BeliefCollapse) as caught:
        post.update(about_cell(1 - west, "in the east"))
    assert "the answer 'in the west' to “Is it?” leaves 210 of 441 cells" in str(caught.value)
    assert "the answer 'in the east' to “Is it?” leaves 231 of 441 cells" in str(caught.value)


@pytest.mark.parametrize(
    ("p", "message"),
    [
        (np.full(441, 2.0), "has shape (441,); expected probabilities of shape (441,)"),
        (np.full(440, 0.5), "has shape (440,); expected probabilities of shape (441,)"),
        (np.zeros(441), "Answer 'x' has probability 0 whatever is true"),
    ],
)
def test_a_table_that_is_none(p, message):
    with pytest.raises(InputError) as caught:
        AnswerFactor("Is it?", "x", (f"{TARGET}/cell",), (range(441),), p, p)
    assert message in str(caught.value)


def test_a_posterior_keeps_its_answers_in_its_file(tmp_path):
    grid = replace(TWO.grid, centre=(41.5, -81.7))
    where = replace(TWO, grid=grid, _cache={})
    post = posterior(said(open_ground()), where)
    (referent,) = ask(post, where, 1, kinds=["referent"])
    post = post.update(about_cell(np.linspace(0.1, 1, grid.size)))
    post = post.update(referent.answer("East")).update(referent.answer("I don't know"))
    post.save(tmp_path / "a.nc")
    again = Posterior.load(tmp_path / "a.nc")
    np.testing.assert_array_equal(again.belief(TARGET), post.belief(TARGET))
    assert [a.answer for a in again.answers] == ["yes", "East", "I don't know"]
    more = again.update(referent.answer("West"))  # the question is still known
    assert len(more.answers) == 4


def test_frames_of_later_speakers_keep_their_answers_when_an_earlier_one_says_more():
    ann = said(relation("near", "House"))
    ann = type(ann)("", "", ann.targets, ann.relations, speaker="Ann")
    bo = said(relation("behind", "House"))
    bo = type(bo)("", "", bo.targets, bo.relations, speaker="Bo")
    more = said(relation("near", "MainSt"))
    more = type(more)("", "", more.targets, more.relations, speaker="Ann")
    one = posterior(ann, model=MIXTURE).update(bo)
    name = f"{TARGET}/frame_1"
    angles = tuple(one.joint.support(name))
    likelihood = np.where(np.cos(np.array(angles)) > 0, 0.9, 0.1)
    answer = AnswerFactor("Which way?", "east", (name,), (angles,), likelihood, likelihood)
    early = one.update(answer).update(more)
    assert early.answers[0].latents == (f"{TARGET}/frame_2",)
    together = posterior(ann, model=MIXTURE).update(more).update(bo)
    moved = AnswerFactor(
        "Which way?", "east", (f"{TARGET}/frame_2",), (angles,), likelihood, likelihood
    )
    np.testing.assert_allclose(
        early.belief(TARGET), together.update(moved).belief(TARGET), atol=1e-12
    )
