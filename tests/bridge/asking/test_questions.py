"""Which questions are worth asking: information by hand, words, salience, kinds from outside."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

import sloop_ppl as sloop
from sloop_ppl.bridge.asking import (
    QUESTION_KINDS,
    AnswererModel,
    CandidateQuestions,
    Proposal,
    ask,
    salience,
)
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.inference import infer_description
from sloop_ppl.maps import CityMap, Landmark
from sloop_ppl.planning.information import AnswerTables, expected_bits
from tests.scenes import TARGET, relation, said, symmetric_grid

GRID = symmetric_grid(21)


def city(*more):
    named = [
        Landmark("Tower", "building", shapely.box(-4, -4, 4, 4), name="Old Tower"),
        Landmark("Mill", "building", shapely.box(30, 20, 45, 40), name="Mill"),
        Landmark("Shed", "building", shapely.box(-40, -40, -30, -30)),
        *more,
    ]
    return CityMap("toy", GRID, tuple(named))


CITY = city()
EXACT = AnswererModel.exact(0.1)


def uniform(where=CITY, prior=None):
    """Return a posterior that knows nothing, whatever was said."""
    return infer_description(said(relation("near", "Tower")), where, "uniform", prior=prior)[0]


def entropy(*p):
    return -sum(x * math.log2(x) for x in p if x)


def test_information_by_hand():
    # Quarters of a square about its middle: four answers as probable, noise of an error of 0.1.
    (question,) = ask(uniform(), CITY, 1, kinds=["side"], person=EXACT, landmarks=["Tower"])
    assert question.text == ("On which side of Old Tower is RedCar: north, east, south or west?")
    noise = entropy(0.9, *[0.1 / 3] * 3)
    assert [a.text for a in question.answers] == ["north", "east", "south", "west"]
    p = [a.p for a in question.answers]
    assert sum(p) == pytest.approx(1)
    assert question.bits == pytest.approx(entropy(*p) - noise, abs=1e-9)
    assert question.bits == pytest.approx(2 - noise, abs=0.01)


def test_information_is_the_mean_gain_of_the_belief_in_the_true_cell():
    post = infer_description(said(relation("near", "Tower")), CITY, "bayes")[0]
    (question,) = ask(post, CITY, 1, kinds=["nearer"], person=EXACT)
    before, table = post.belief(TARGET), question.p_answer()[:2]
    gain = 0.0
    for option in question.options:
        after = post.update(question.answer(option)).belief(TARGET)
        p = table[question.options.index(option)]
        gain += float((before * p * np.log2(np.maximum(after, 1e-300) / before)).sum())
    assert question.bits == pytest.approx(gain, abs=1e-9)


def test_an_answer_that_tells_nothing_is_worth_nothing():
    sure = np.zeros(GRID.shape)
    sure[3, 4] = 1.0
    assert ask(uniform(prior=sure), CITY, 3) == ()
    guessing = AnswererModel(guess=1.0)
    assert ask(uniform(), CITY, 3, person=guessing) == ()
    not_knowing = AnswererModel(error=0.0, dont_know=0.0)
    more = ask(uniform(), CITY, 1, person=not_knowing)[0].bits
    half = ask(uniform(), CITY, 1, person=AnswererModel(error=0.0, dont_know=0.1))[0]
    assert half.bits == pytest.approx((1 - half.dont_know) * more)


def test_the_winner_is_exact_and_the_same_on_a_map_too_large_to_compare_everywhere():
    fine = CITY.with_grid(type(GRID)(*GRID.extent_m[:2], *GRID.extent_m[2:], 1.5))
    assert fine.grid.size > 2000
    post = infer_description(said(relation("near", "Tower")), fine, "bayes")[0]
    candidates = CandidateQuestions(post, TARGET)
    assert len(candidates.cells) <= 2000
    exact = [candidates.question(k).bits for k in range(len(candidates))]
    np.testing.assert_allclose(candidates.bits(), exact, atol=0.03)
    best = ask(post, fine, 1)[0]
    flat = best.p_answer().reshape(len(best.p_answer()), -1)
    assert best.bits == pytest.approx(expected_bits(flat, post.belief(TARGET).ravel()))
    assert best.bits == pytest.approx(max(exact), abs=0.03)


def test_bits_follow_the_belief_of_later():
    post = uniform()
    candidates = CandidateQuestions(post, TARGET, person=EXACT, kinds=["side"])
    tower = next(k for k, text in enumerate(candidates.texts()) if "Tower" in text)
    assert candidates.bits()[tower] > 1
    north = np.zeros(GRID.shape)
    north[15:, 10] = 1 / 6
    assert candidates.bits(north)[tower] == pytest.approx(0, abs=1e-3)


def test_stacked_tables_are_those_of_each_alone():
    rng = np.random.default_rng(0)
    tables = [rng.dirichlet(np.ones(k), 50).T for k in (2, 4, 3)]
    belief = rng.dirichlet(np.ones(50))
    together = AnswerTables(tables).bits(belief)
    np.testing.assert_allclose(together, [expected_bits(t, belief) for t in tables], atol=1e-12)
    with pytest.raises(InputError, match="of different cells, or there is none"):
        AnswerTables([])


def test_distances_are_seen_with_an_error_each():
    seen = AnswererModel(distance_share=0.3)
    metres = np.array([[20.0, 10.0, 40.0], [20.0, 40.0, 10.0], [1e6, 40.0, 10.0]])
    p = seen.nearest(np.log(metres))
    np.testing.assert_allclose(p.sum(0), 1)
    np.testing.assert_allclose(p[:2, 0], 0.5, atol=1e-6)
    # Two of them by drawing what is seen: a logit is near a probit of the same spread.
    rng = np.random.default_rng(0)
    off = rng.gumbel(scale=0.3 * math.sqrt(6) / math.pi, size=(3, 40_000))
    drawn = np.argmin(np.log(metres)[:, 1, None] - off, axis=0)
    np.testing.assert_allclose(p[:, 1], np.bincount(drawn, minlength=3) / 40_000, atol=0.01)
    exact = AnswererModel.exact().nearest(np.log(metres))
    np.testing.assert_array_equal(exact, [[1, 1, 0], [0, 0, 1], [0, 0, 0]])
    scene = CandidateQuestions(uniform(), TARGET).scene
    second, middle = scene.nearer_to_other("Tower", "Mill"), []
    errors = rng.normal(scale=0.3, size=(2, 40_000))
    cell = 21 * 12 + 14
    for part in (0, 1):
        one, other = (scene._log_distances(m)[part][cell] for m in ("Tower", "Mill"))
        middle.append(np.mean(one + errors[0] > other + errors[1]))
    assert second[cell] == pytest.approx(np.mean(middle), abs=0.01)


def test_a_cell_that_a_place_half_covers_is_half_inside():
    half = Landmark("Half", "building", shapely.box(-12.4, -12.4, 12.4, 10.0), name="Half")
    where = city(half)
    covered = CandidateQuestions(uniform(where), TARGET).scene.covered("Half")
    inside = where.cells("Half")
    assert not covered.reshape(inside.shape)[~inside].any()
    assert covered.max() == 1
    assert 0 < covered[covered > 0].min() < 1
    assert covered.sum() == pytest.approx(24.8 * 22.4 / 25)
    exact = CandidateQuestions(uniform(where), TARGET, person=EXACT).scene.covered("Half")
    np.testing.assert_array_equal(exact.reshape(inside.shape), inside)


def test_directions_between_the_tabulated_ones_are_as_good():
    for sigma in (1.0, 10.0, 90.0):
        person = AnswererModel(angle_deg=sigma)
        bearing = np.random.default_rng(0).uniform(-7, 7, 500)
        off = bearing - np.radians([90.0, 0.0, -90.0, 180.0])[:, None]
        off = np.abs((off + np.pi) % (2 * np.pi) - np.pi)
        each = np.array([[math.erfc(-v / math.sqrt(2)) for v in row]
                         for row in (np.pi / 4 - off) / np.radians(sigma)])  # fmt: skip
        np.testing.assert_allclose(person.quarters(bearing), each / each.sum(0), atol=2e-5)
    assert AnswererModel().quarters(np.array([-1e-18, 2 * np.pi])).shape == (4, 2)


def test_turning_the_map_turns_the_answers():
    """North of the tower becomes west of it when all is turned by a quarter."""
    post = uniform(prior=np.random.default_rng(2).uniform(0.1, 1, GRID.shape))
    (question,) = ask(post, CITY, 1, kinds=["side"], landmarks=["Tower"], person=AnswererModel())
    table = question.p_answer()
    turned = np.rot90(table, -1, axes=(1, 2))  # rows run north: this is anticlockwise
    away = np.ones(GRID.shape, dtype=bool)
    away[10, 10] = False  # the middle itself, which is in no direction
    north, east, south, west = range(4)
    for old, new in ((west, north), (south, west), (north, east)):
        np.testing.assert_allclose(turned[new][away], table[old][away], atol=1e-9)


@pytest.mark.parametrize(
    ("text", "option"),
    [
        ("north", "north"),
        ("On the north side!", "north"),
        ("it's to the South of it", "south"),
        ("2", "east"),
        ("I think west", "west"),
    ],
)
def test_answers_in_other_words(text, option):
    (question,) = ask(uniform(), CITY, 1, kinds=["side"], landmarks=["Tower"])
    place = question.options.index(option)
    answer = question.answer(text)
    np.testing.assert_array_equal(answer.likelihood, question.answer(option).likelihood)
    assert answer.likelihood.argmax() in np.flatnonzero(question.truth[place] > 0.5)


def test_not_knowing_neither_and_not():
    (side,) = ask(uniform(), CITY, 1, kinds=["side"], landmarks=["Tower"])
    for words in ("I don't know", "no idea, sorry", "not sure", "dunno", "I do not remember"):
        assert side.answer(words).informs is False
    denied, said_so = side.answer("not north").likelihood, side.answer("north").likelihood
    np.testing.assert_allclose(denied + said_so, 1 - side.dont_know, atol=1e-12)
    (nearer,) = ask(uniform(), CITY, 1, kinds=["nearer"], landmarks=["Tower", "Mill"])
    neither = nearer.answer("neither").likelihood.reshape(GRID.shape)
    gap = np.abs(CITY.fields("Tower").distance_m - CITY.fields("Mill").distance_m)
    assert neither.argmax() == gap.argmin()  # as far from one as from the other
    assert neither[GRID.cell_at(0, -50)] < 0.3 * neither.max()


def test_unforeseen_answers_are_read_like_any_sentence():
    where = sloop.load_map("cleveland")
    post = sloop.infer("the red bike is near Ivy", where)
    question = ask(post, where, 1)[0]
    free = question.answer("it is next to the Bradley")
    assert not free.informs
    assert [(r.relation, r.grounds) for r in free.description.relations] == [
        ("next", ("TheBradley",))
    ]
    after = post.update(free)
    np.testing.assert_allclose(
        after.belief("RedBike"), post.update(free.description).belief("RedBike"), atol=1e-14
    )
    side = ask(post, where, 1, kinds=["side"], landmarks=["Ivy"])[0]
    assert not side.answer("south of the Bradley").informs  # it is not south of Ivy that was meant
    assert side.answer("definitely south").informs
    both = question.answer(f"{question.options[0]}, on West 6th Street")
    assert both.informs
    assert both.description.relations[0].grounds == ("West6thSt",)


@pytest.mark.parametrize("words", ["", "  ", "purple", "because of the weather"])
def test_an_answer_that_says_nothing_is_refused(words):
    (question,) = ask(uniform(), CITY, 1, kinds=["side"], landmarks=["Tower"])
    with pytest.raises(InputError) as caught:
        question.answer(words)
    assert str(caught.value).endswith(
        "expected one of: north, east, south, west, I don't know; or a sentence that says where "
        "it is"
    )


def test_salience_is_by_name_kind_and_size():
    twin = city(
        Landmark("A", "park", shapely.box(-50, 0, -20, 30), name="Green"),
        Landmark("B", "poi", shapely.Point(5, 40), name="Bank"),
        Landmark("C", "poi", shapely.Point(-5, 40), name="Bank"),
        Landmark(
            "D",
            "building",
            shapely.box(0, 40, 8, 48),
            name="Guess",
            properties={"name_is_guess": True},
        ),
    )
    assert salience(twin, "Shed") == 0
    assert salience(twin, "A") == 1.0
    assert salience(twin, "B") < 0.5 * 0.8
    assert salience(twin, "D") < salience(twin, "Tower") < salience(twin, "Mill")
    asked = ask(uniform(twin), twin, 9)
    assert not any("Shed" in q.text for q in asked)
    with pytest.raises(UnknownName):
        salience(twin, "Nowhere")


def test_a_kind_from_outside():
    def halves(scene):
        def table(at):
            return np.stack([at.x_m < 0, at.x_m >= 0]).astype(float)

        yield Proposal("West or east of the middle?", ("west", "east"), table)

    QUESTION_KINDS.add("halves", halves)
    try:
        (question,) = ask(uniform(), CITY, 1, kinds=["halves"], person=EXACT)
        assert question.bits == pytest.approx(1 - entropy(0.9, 0.1), abs=0.01)
        assert ask(uniform(), CITY, 30)
    finally:
        QUESTION_KINDS.remove("halves")


def test_a_kind_from_outside_whose_table_is_none():
    def broken(_scene):
        yield Proposal("Hm?", ("a", "b"), lambda at: np.stack([at.x_m > 0, at.y_m > 9]) * 1.0)

    QUESTION_KINDS.add("broken", broken)
    try:
        with pytest.raises(InputError, match="expected probabilities of its 2 options"):
            ask(uniform(), CITY, 1, kinds=["broken"])
    finally:
        QUESTION_KINDS.remove("broken")


def test_questions_are_asked_once_and_vary():
    post = uniform()
    asked = ask(post, CITY, 4)
    assert len({q.kind for q in asked}) == len(asked)
    assert [q.bits for q in asked] == sorted((q.bits for q in asked), reverse=True)
    again = ask(post, CITY, 4, without=[asked[0].text])
    assert asked[0].text not in {q.text for q in again}


def test_what_a_question_settles():
    where = sloop.load_map("cleveland")
    post = sloop.infer("the red bike is by the bar", where)
    (question,) = ask(post, where, 1, kinds=["referent"])
    assert question.about == "referent"
    assert question.settles[question.latent] > question.bits > 0.1
    side = ask(post, where, 1, kinds=["nearer"])[0]
    assert side.settles["cell"] == side.bits
    assert question.latent in side.settles  # where it is tells which bar was meant


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"n": 0}, "n is 0; expected at least one question"),
        ({"kinds": ["smell"]}, "Kind of question 'smell' is unknown"),
        ({"target": "Bus"}, "Target 'Bus' is unknown"),
        ({"landmarks": ["Nowhere"]}, "Landmark of map toy 'Nowhere' is unknown"),
    ],
)
def test_bad_requests(options, message):
    with pytest.raises(InputError) as caught:
        ask(uniform(), CITY, **options)
    assert str(caught.value).startswith(message)


def test_a_posterior_of_another_map_is_refused():
    with pytest.raises(InputError, match="was made on another map"):
        ask(uniform(), sloop.load_map("cleveland"))


@pytest.mark.parametrize(
    "values", [{"error": 1.0}, {"guess": 1.5}, {"dont_know": -0.1}, {"angle_deg": 100}]
)
def test_a_person_that_cannot_be(values):
    with pytest.raises(InputError, match="of the answerer is"):
        AnswererModel(**values)


def test_the_value_of_a_question_in_bits_and_in_reward():
    post = uniform()
    (question,) = ask(post, CITY, 1, person=EXACT)
    free, dear = post.value_of(question), post.value_of(question, cost=40.0)
    assert free.bits == pytest.approx(question.bits)
    assert free.reward - dear.reward == pytest.approx(40)
    assert free.reward > 0
    assert post.value_of(question, start=(0.0, 0.0)).reward != free.reward
    with pytest.raises(InputError, match="The question is a str; expected one of"):
        post.value_of("where?")
