"""Relations in words: an open mention is not called by one of the places that it may be."""

from __future__ import annotations

import pytest

from sloop_ppl import infer, load_map, parse
from sloop_ppl.bridge import relations_in_words
from sloop_ppl.bridge.relation_text import relation_in_words
from sloop_ppl.language import Candidate, SpatialRelation
from sloop_ppl.language._place_names import PlaceNames

CITY = load_map("cleveland")


def _relation(*candidates: tuple[str | None, float]) -> SpatialRelation:
    first = next(ground for ground, _ in candidates if ground)
    slot = tuple(Candidate(ground, p) for ground, p in candidates)
    return SpatialRelation("Car", "near", (first,), candidates=(slot,))


@pytest.mark.parametrize(
    ("candidates", "words"),
    [
        ([("Ivy", 1.0)], "near Ivy"),
        ([("Ivy", 0.6), (None, 0.4)], "near Ivy"),  # the only place that it may be
        ([("Ivy", 0.5), ("Rumor", 0.5)], "near Ivy or Rumor"),
        ([("Ivy", 0.4), ("Rumor", 0.3), ("HoytBlock", 0.3)], "near Ivy or one of 2 others"),
        ([("Ivy", 0.95), ("Rumor", 0.05)], "near Ivy"),
        ([("Ivy", 0.6), (None, 0.35), ("Rumor", 0.05)], "near Ivy"),  # 12 to 1 of those here
        ([(None, 0.8), ("Ivy", 0.1), ("Rumor", 0.1)], "near Ivy or Rumor"),
    ],
)
def test_a_mention_is_called_by_the_places_that_it_may_be(candidates, words):
    assert relation_in_words(_relation(*candidates), PlaceNames(CITY)) == words


def test_a_bar_is_not_called_by_the_name_of_one_bar():
    posterior = infer(parse("the red car is near a bar", CITY), CITY)
    assert relations_in_words(posterior, "RedCar") == ("near Ivy or Barley House",)
