"""The numbers of relations, distances, candidates and readings are checked where they are made."""

import math

import numpy as np
import pytest

from sloop_ppl.errors import DescriptionError
from sloop_ppl.language import SpatialRelation
from sloop_ppl.language.values import Candidate, Distance, Reading

NO_NUMBERS = (math.nan, "5", None, True, [1.0])


def relation(**changes):
    return SpatialRelation("RedBike", "near", ("Ivy",), **changes)


@pytest.mark.parametrize("value", [math.nan, -1, -0.5, math.inf, -math.inf, "5", True, [1.0]])
def test_a_distance_is_a_finite_number_of_at_least_0(value):
    with pytest.raises(DescriptionError) as caught:
        relation(distance_m=value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("low", [*NO_NUMBERS, -1, 51, math.inf])
def test_the_lower_bound_of_a_distance(low):
    with pytest.raises(DescriptionError):
        Distance(low, 50)


@pytest.mark.parametrize("high", [*NO_NUMBERS, -1, 49])
def test_the_upper_bound_of_a_distance(high):
    with pytest.raises(DescriptionError):
        Distance(50, high)


@pytest.mark.parametrize("vagueness", [*NO_NUMBERS, 0, -0.1, 2.1, math.inf])
def test_the_vagueness_of_a_distance(vagueness):
    with pytest.raises(DescriptionError, match="vagueness"):
        Distance(0, 50, vagueness)


@pytest.mark.parametrize("share", [*NO_NUMBERS, -0.1, 1.5, math.inf])
def test_a_share_is_in_0_to_1(share):
    for make in (
        lambda: relation(confidence=share),
        lambda: Candidate("Ivy", share),
        lambda: Reading(share),
    ):
        with pytest.raises(DescriptionError, match=r"expected a (number|share in \[0, 1\])"):
            make()


@pytest.mark.parametrize(
    "changes",
    [{"mentions": (-1,)}, {"mentions": (0.5,)}, {"either": (0, -1)}, {"either": (0,)}],
)
def test_numbers_that_tell_things_apart_are_whole(changes):
    with pytest.raises(DescriptionError, match="Relation 'near' of 'RedBike' has"):
        relation(**changes)


def test_sound_numbers_are_taken_as_they_are():
    made = relation(distance_m=np.float64(12.5), confidence=np.float32(0.5), mentions=(3,))
    assert (made.distance, made.confidence) == (Distance(12.5, 12.5), 0.5)
    assert Distance(50, math.inf).stated_m is None
    assert relation(distance_m=0).distance == Distance(0, 0)
