import pytest

from sloop_ppl.language import coloured_text, html_page, parse, roles
from sloop_ppl.maps import load_map

CITY = load_map("cleveland")
TEXT = "The red bike & the green car are behind Ivy, not near the <Hotel> Ritz"


def test_roles_are_in_order_and_do_not_overlap():
    parts = roles(parse(TEXT, CITY))
    assert [(TEXT[p.start : p.end], p.role) for p in parts] == [
        ("red bike & the green car", "figure"),
        ("behind", "relation"),
        ("Ivy", "ground"),
        ("Hotel", "unresolved"),  # this map holds none
    ]
    assert parts[0].label == "RedBike, GreenToyota"
    ends = [0, *(p.end for p in parts)]
    assert all(p.start >= end for p, end in zip(parts, ends, strict=False))


def test_terminal_text_is_the_text():
    text = coloured_text(parse(TEXT, CITY))
    assert text.plain == TEXT
    assert len(text.spans) == 4


def test_page_names_the_part_of_a_street():
    page = html_page(parse("The red bike is on the north side of West Lakeside Avenue", CITY))
    assert "<td>north</td><td>north side of WestLakesideAvenue</td>" in page


@pytest.mark.parametrize("text", [TEXT, "", "<script>alert(1)</script> \ud800 the red bike"])
def test_page_escapes_the_text(text):
    page = html_page(parse(text, CITY))
    assert "<script>" not in page
    assert "<Hotel>" not in page
    page.encode("utf-8")
    if text == TEXT:
        assert "<td>RedBike</td><td>behind</td><td>Ivy</td>" in page
        assert "&lt;" in page
