"""The part of a street, a crossing or a block that a text names goes to the right relation."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from reading_cases import ReadingCase, cases, city

from sloop_ppl.language import Description, SpatialRelation, StreetPart, parse

Part = tuple[frozenset[str], str, float | None, int | None]


def parts(text: str, where: str, **options) -> list[Part]:
    """Return grounds, kind, bearing in degrees and number of each part that is read."""
    found = []
    for relation in parse(text, city(where), **options).relations:
        part = relation.part
        if part is not None:
            bearing = None if part.bearing_rad is None else round(math.degrees(part.bearing_rad), 6)
            found.append((frozenset(relation.grounds), part.kind, bearing, part.number))
    return sorted(found, key=str)


def wanted(case: ReadingCase) -> list[Part]:
    found: list[Part] = []
    for one in filter(None, (p.strip() for p in case.wanted.split(";"))):
        grounds, kind, *rest = one.split()
        bearing = None if not rest or rest[0] == "?" else float(rest[0])
        number = int(rest[1]) if len(rest) > 1 else None
        found.append((frozenset(grounds.split("+")), kind, bearing, number))
    return sorted(found, key=str)


@pytest.mark.parametrize("case", cases("street_parts"), ids=lambda case: case.text)
def test_a_part_is_read_with_its_street(case):
    assert parts(case.text, case.map) == wanted(case)


@pytest.mark.parametrize("case", cases("street_words"), ids=lambda case: case.text)
def test_a_word_alone_makes_no_part(case):
    assert parts(case.text, case.map) == []


def holders(text: str, where: str = "denver", **options) -> list[tuple[str, bool, str | None]]:
    """Return word, polarity and kind of part of each relation."""
    relations = parse(text, city(where), **options).relations
    return [(r.relation, r.negated, r.part.kind if r.part else None) for r in relations]


def test_of_two_relations_the_one_with_the_direction_has_the_corner():
    assert holders("I'm on the SW corner of Grant Street and East 12th Avenue") == [
        ("on", False, None),
        ("southwest", False, "corner"),
    ]
    # Colfax Avenue is not on the map.
    assert holders("I'm on the SW corner of Grant Street and Colfax Avenue") == [
        ("on", False, None),
        ("southwest", False, "corner"),
    ]
    assert holders("The red bike is on Grant Street, near the corner") == [
        ("on", False, None),
        ("near", False, "corner"),
    ]


def test_a_denied_corner_does_not_deny_its_street():
    assert holders("The red bike is on Grant Street, not near a corner") == [
        ("on", False, "mid-block"),
        ("near", True, "corner"),
    ]
    assert holders("The red bike is not at the corner of Grant Street and East 12th Avenue") == [
        ("at", True, "corner"),
    ]


def test_a_part_is_not_of_a_street_of_another_object():
    text = "The red bike is on Grant Street. The green Toyota is mid-block."
    assert parts(text, "denver") == []
    text = "The red bike is on Grant Street. It is mid-block."
    assert parts(text, "denver") == [(frozenset({"GrantSt"}), "mid-block", None, None)]
    text = "The red bike is on Grant Street. It is a nice day. We are mid-block."
    assert parts(text, "denver") == []


def test_a_relation_said_twice_keeps_its_part():
    text = "The red bike is on Grant Street, on the odd side of Grant Street"
    assert holders(text) == [("on", False, "side")]


def test_a_part_moves_no_relation():
    plain = "The red bike is on West 6th Street, near Velvet Dog"
    told = "The red bike is on West 6th Street, mid-block, near Velvet Dog"
    one, other = (parse(text, city("cleveland")).relations for text in (plain, told))
    bare = [(r.figure, r.relation, r.grounds, r.candidates) for r in one]
    assert bare == [(r.figure, r.relation, r.grounds, r.candidates) for r in other]


def test_a_block_measures_and_is_a_part():
    assert holders("The red bike is within a block of Velvet Dog", "cleveland") == [
        ("near", False, None)
    ]
    assert holders("The red bike is within the block of Velvet Dog", "cleveland") == [
        ("near", False, "block")
    ]


def test_a_number_is_a_part_only_where_the_map_lacks_the_house():
    assert parts("The red bike is at 1143 Logan Street", "denver") == []
    number = (frozenset({"LoganSt"}), "number", None, 1144)
    assert parts("The red bike is at 1144 Logan Street", "denver") == [number]
    assert parts("The red bike is at 12345678 Logan Street", "denver") == []
    assert parts("The red bike is at 0 Logan Street", "denver") == []


def test_upper_is_no_north_to_who_stands_there():
    text = "The red bike is on the upper left corner of Grant Street and East 12th Avenue"
    grounds = frozenset({"GrantSt", "East12thAvenue"})
    assert parts(text, "denver") == [(grounds, "corner", 135.0, None)]
    assert parts(text, "denver", viewpoint="ground") == [(grounds, "corner", None, None)]
    text = "The red bike is on the top side of East 12th Avenue"
    street = frozenset({"East12thAvenue"})
    assert parts(text, "denver") == [(street, "side", 90.0, None)]
    assert parts(text, "denver", viewpoint="ground") == []
    northern = SpatialRelation("RedBike", "above", ("GrantSt",), part=StreetPart("side", 1.0))
    seen = Description("", "denver", (), (northern,), viewpoint="ground").relations
    assert seen == (replace(northern, relation="at"),)


def test_a_slip_of_the_pen_is_no_other_side():
    slip = "northern".replace("r", "", 1)
    side = (frozenset({"GrantSt"}), "side", math.degrees(math.pi / 2), None)
    assert parts(f"Meet me on the {slip} side of Grant Street.", "denver") == [side]


def test_reading_parts_takes_time_linear_in_the_text():
    again = "I'm on Grant Street on the odd side mid-block near the corner "
    found = parse(again * 2000, city("denver"))
    assert [r.part.kind for r in found.relations if r.part] != []
