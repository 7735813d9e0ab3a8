"""Whether a frame was predicted as the speaker meant it, on a house and a street."""

import pytest
from scenes import house_and_street, relation, symmetric_grid

from sloop_ppl.eval._facts import facts_of
from sloop_ppl.eval.descriptions import AnnotatedDescription, Place
from sloop_ppl.language import HEARER, NOT_ON_MAP


@pytest.fixture
def block():
    return house_and_street(symmetric_grid(21))  # the house faces the street, north of it


def facts(block, x, y, *relations):
    row, col = block.grid.cell_at(x, y)
    annotated = AnnotatedDescription(
        "s", "block", "c", "", {"RedCar": Place(x, y, (row, col))}, relations
    )
    (told,) = facts_of(annotated, block)
    return told


@pytest.mark.parametrize(
    ("word", "place", "good"),
    [
        ("front", (10, 20), True),
        ("front", (10, -5), False),
        ("behind", (0, -20), True),
        ("behind", (0, 20), False),
        ("right", (20, -30), True),  # right is east, as on the map
        ("left", (20, 0), False),
    ],
)
def test_good_and_bad_by_hand(block, word, place, good):
    told = facts(block, *place, relation(word, "House"))
    assert told.good is good
    assert told.relations[0].good is good


def test_one_bad_relation_makes_a_bad_trial(block):
    said = relation("front", "House"), relation("right", "House"), relation("near", "House")
    told = facts(block, -20, 20, *said)
    assert [r.good for r in told.relations] == [True, False, None]
    assert told.good is False


def test_without_frames_there_is_nothing_to_be_good(block):
    assert facts(block, 5, 5, relation("near", "House")).good is None
    assert facts(block, 5, 5, relation("front", "House", negated=True)).good is None


def test_a_street_has_two_fronts(block):
    for y in (20, 50):
        assert facts(block, 0, y, relation("front", "MainSt")).good is True


@pytest.mark.parametrize("word", ["front", "left", "near"])
@pytest.mark.parametrize("ground", [NOT_ON_MAP, HEARER])
def test_no_side_is_predicted_of_a_ground_that_the_map_does_not_show(block, word, ground):
    told = facts(block, 10, 20, relation(word, ground), relation("right", "House"))
    assert [r.good for r in told.relations] == [None, True]
    assert told.relations[0].grounds == (ground,)
