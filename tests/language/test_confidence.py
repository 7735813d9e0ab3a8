"""Readings follow from the probability that each phrase was read right."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sloop_ppl.language import SpatialRelation, parse
from sloop_ppl.language._confidence import FEATURES, confidence, readings_of
from sloop_ppl.maps import load_map

CITY = load_map("cleveland")
PLACES = ("Ivy", "Rumor", "HoytBlock", "VelvetDog", "Subway", "Hanabi", "GrandArcade")


def relations(count):
    return [SpatialRelation("RedBike", "near", (place,)) for place in PLACES[:count]]


def held(readings, ground):
    """Return the probability of the readings in which a relation to a ground holds."""
    return sum(h.probability for h in readings if any(r.ground == ground for r in h.relations))


def test_two_phrases_by_hand():
    readings = readings_of(relations(2), [0.9, 0.6])
    assert [(round(h.probability, 3), [r.ground for r in h.relations]) for h in readings] == [
        (0.6, ["Ivy", "Rumor"]),
        (0.3, ["Ivy"]),
        (0.1, []),
    ]


@given(st.lists(st.floats(0.01, 0.99), min_size=1, max_size=7))
def test_readings_are_a_distribution_with_the_confidences_as_marginals(probabilities):
    given_relations = relations(len(probabilities))
    readings = readings_of(given_relations, probabilities)
    assert len(readings) <= 4
    assert sum(h.probability for h in readings) == pytest.approx(1)
    assert all(h.probability >= -1e-12 for h in readings)
    assert readings[-1].relations == ()
    for relation in given_relations:
        stated = next(
            r.confidence for h in readings for r in h.relations if r.ground == relation.ground
        )
        assert held(readings, relation.ground) == pytest.approx(stated, abs=1e-3)
    if len(set(probabilities)) <= 3 and all(
        abs(a - b) >= 0.02 or a == b for a, b in pairwise(sorted(probabilities))
    ):  # nothing was merged
        for relation, probability in zip(given_relations, probabilities, strict=True):
            assert held(readings, relation.ground) == pytest.approx(probability)


@given(st.lists(st.floats(0.01, 0.99), min_size=2, max_size=7))
def test_merged_levels_keep_the_mean(probabilities):
    readings = readings_of(relations(len(probabilities)), probabilities)
    mean = sum(held(readings, PLACES[k]) for k in range(len(probabilities))) / len(probabilities)
    assert mean == pytest.approx(sum(probabilities) / len(probabilities))


def test_the_surer_phrase_holds_whenever_the_less_sure_does():
    readings = readings_of(relations(3), [0.5, 0.9, 0.7])
    grounds = [frozenset(r.ground for r in h.relations) for h in readings]
    for one in grounds:
        for other in grounds:
            assert one <= other or other <= one


def test_a_logistic_function_of_the_features():
    none = [0.0] * len(FEATURES)
    base = confidence(none)
    assert 0.5 < base < 1
    for k in range(len(FEATURES)):
        one = confidence([*none[:k], 1.0, *none[k + 1 :]])
        two = confidence([*none[:k], 2.0, *none[k + 1 :]])
        step = math.log(one / (1 - one)) - math.log(base / (1 - base))
        assert math.log(two / (1 - two)) - math.log(one / (1 - one)) == pytest.approx(
            step, abs=1e-6
        )


def test_confidence_is_what_the_readings_say():
    said = parse(
        "The red bike is behind Rumor and maybe the food truck is near a bank or Ivy", CITY
    )
    for relation in said.relations:
        total = sum(
            h.probability
            for h in said.readings
            if any(
                (r.relation, r.grounds) == (relation.relation, relation.grounds)
                for r in h.relations
            )
        )
        assert relation.confidence == pytest.approx(total, abs=1e-3)


def test_a_plain_sentence_is_surer_than_a_winding_one():
    plain = parse("The red bike is behind Rumor.", CITY).relations[0].confidence
    winding = parse(
        "I'm at Rumor. There is a kiln a bit to the west of it, past the other thing, and across "
        "from here, or somewhat further, you get to see Ivy on the corner of that block.",
        CITY,
    )
    assert winding.relations
    assert all(r.confidence < plain for r in winding.relations)
