"""Places are called what who spoke calls them."""

from __future__ import annotations

import pytest
import shapely

from sloop_ppl.bridge._formatting import belief_lines, belief_report
from sloop_ppl.bridge.explain import explain_lines
from sloop_ppl.bridge.facade import infer, parse
from sloop_ppl.errors import NoRelationFound
from sloop_ppl.language import (
    Description,
    RelationSpans,
    SpatialRelation,
    TargetObject,
    no_relation_found,
)
from sloop_ppl.language._place_names import PlaceNames
from sloop_ppl.maps import CityMap, Grid, Landmark


def shop(id_, x, name, *aliases):
    return Landmark(id_, "building", shapely.box(x, -8, x + 16, 8), name, aliases)


CITY = CityMap(
    "harbour",
    Grid.square(60, centre=(35.0, 139.0)),
    (
        shop("A", -55, "Северный маяк", "Severny Mayak", "Northern Light"),
        shop("B", -10, "青い塔", "Aoi To"),
        shop("C", 35, "Rowan Bakery", "Old Oven"),
        shop("D", 0, "Кафе без имени"),
    ),
)


def names(text):
    given = PlaceNames(CITY, [parse(text, CITY)])
    return {m.id: given.of(m.id) for m in CITY.landmarks}


def test_without_words_the_names_are_the_map_s():
    given = PlaceNames(CITY)
    assert [given.of(m.id) for m in CITY.landmarks] == [m.name for m in CITY.landmarks]


def test_the_alias_that_was_used():
    assert names("The red bike is near the Northern Light.")["A"] == "Northern Light"
    assert names("The red bike is near Severny Mayak.")["A"] == "Severny Mayak"
    assert names("The red bike is near the old oven.")["C"] == "Old Oven"
    assert names("The red bike is near Rowan Bakery.")["C"] == "Rowan Bakery"
    assert names("The red bike is near Severny Mayk.")["A"] == "Severny Mayak"  # a slip


def test_what_is_no_name_changes_none():
    assert names("The red bike is near the bakery.")["C"] == "Rowan Bakery"


def test_a_part_of_an_alias_is_answered_with_the_alias():
    text = "the red bike is near the Light"
    spans = RelationSpans((0, 12), (16, 20), ((21, 30),))
    near = SpatialRelation("RedBike", "near", ("A",), spans=spans)
    one = Description(text, CITY.name, (TargetObject("RedBike"),), (near,))
    assert PlaceNames(CITY, [one]).of("A") == "Northern Light"


def test_others_are_in_the_script_that_was_used():
    latin = names("The red bike is near the old oven.")
    assert (latin["A"], latin["B"]) == ("Severny Mayak", "Aoi To")
    assert latin["D"] == "Кафе без имени"  # it has no other
    theirs = names("The red bike is near 青い塔.")
    assert (theirs["A"], theirs["B"]) == ("Северный маяк", "青い塔")


@pytest.mark.parametrize(
    ("used", "not_used"), [("Northern Light", "Северный"), ("Северный маяк", "Northern")]
)
def test_answers_take_the_same_name(used, not_used):
    posterior = infer(f"the red bike is behind {used}", CITY)
    for lines in (belief_lines(posterior), explain_lines(posterior)):
        text = "\n".join(lines)
        assert used in text
        assert not_used not in text
    assert belief_report(posterior)["targets"]["RedBike"]["nearest"] in CITY  # ids stay ids


def test_what_was_not_found_is_answered_in_the_speaker_s_script():
    text = "The red bike is near Aosta Tower."
    with pytest.raises(NoRelationFound) as caught:
        raise no_relation_found(parse(text, CITY), CITY)
    assert "nearest: Aoi To)" in str(caught.value)
    assert "青" not in str(caught.value)
