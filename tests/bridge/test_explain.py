"""What `--explain` says and what `--figure` draws of why a belief is where it is."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.bridge.explain import explain_lines
from sloop_ppl.bridge.relation_text import facing, percent, relations_in_words
from sloop_ppl.bridge.sheets import figure_of, sheet_of
from sloop_ppl.inference import infer_description
from sloop_ppl.language import SpatialRelation, StreetPart
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
BOTH = said(relation("behind", "House"), relation("on", "MainSt"), targets=(TARGET, "RedBike"))


def posterior(description=BOTH, model=MIXTURE, **options):
    return infer_description(description, CITY, model, **options)[0]


def test_relations_are_told_as_they_are_said():
    what = said(
        relation("front", "House"),
        relation("left", "House", negated=True),
        relation("north", "MainSt"),
        relation("top", "MainSt"),
        relation("between", "House", "MainSt"),
        SpatialRelation(TARGET, "near", ("House",), distance_m=12.5),
        relation("front", "House"),
    )
    assert relations_in_words(posterior(what), TARGET) == (
        "in front of House",
        "not to the left of House",
        "north of Main Street",
        "at the top of Main Street",
        "between House and Main Street",
        "12.5 m near House",
        "in front of House (2)",
    )


@pytest.mark.parametrize(
    ("word", "part", "told"),
    [
        ("north", StreetPart("side", np.pi / 2), "on the north side of Main Street"),
        ("top", StreetPart("corner", 3 * np.pi / 4), "on the northwest corner of Main Street"),
        ("east", StreetPart("side", np.pi / 2), "east of the north side of Main Street"),
        ("on", StreetPart("side", number=2), "on the even side of Main Street"),
        ("near", StreetPart("corner"), "near the corner of Main Street"),
        ("on", StreetPart("mid-block"), "on the middle of the block on Main Street"),
        ("at", StreetPart("end"), "at the end of Main Street"),
        ("at", StreetPart("number", number=4400), "at 4400 Main Street"),
        ("near", StreetPart("block"), "near the block of Main Street"),
    ],
)
def test_parts_are_told_with_their_ground(word, part, told):
    what = said(replace(relation(word, "MainSt"), part=part))
    assert relations_in_words(posterior(what), TARGET) == (told,)


def test_directions_are_told_by_the_nearest_compass_word():
    assert [facing(np.radians(a)) for a in (0, 22, 23, 90, 180, 337, 338, -45, 721)] == [
        "east", "east", "northeast", "north", "west", "southeast", "east", "southeast", "east",
    ]  # fmt: skip


def test_it_names_the_phrase_that_matters_most_first():
    lines = explain_lines(posterior())
    start = lines.index("  phrases, by how much the belief owes to each:")
    told = [re.fullmatch(r"    (\S+) bits  “(.*)”", line) for line in lines[start + 1 : start + 3]]
    by_words = {m[2]: float(m[1]) for m in told if m}
    influences = dict(
        zip(("behind House", "on Main Street"), posterior().influence(TARGET), strict=True)
    )
    assert by_words == pytest.approx({w: i.bits for w, i in influences.items()}, abs=0.005)
    assert list(by_words.values()) == sorted(by_words.values(), reverse=True)


def test_it_tells_components_fronts_and_what_would_change_it():
    text = "\n".join(explain_lines(posterior()))
    p = posterior().component(TARGET)["product"]
    assert f"read as: product {p:.0%} (was 60%)" in text
    assert "“behind” takes House to face " in text
    assert "without “on Main Street”: most probably " in text
    assert text.endswith("  nothing was said of it: this is its prior")


def test_a_single_phrase_leaves_nothing_to_leave_out():
    lines = explain_lines(posterior(said(relation("near", "House"))))
    assert lines[-2:] == ["  what would change it:", "    no phrase by itself, and no front"]
    assert not any("without" in line for line in lines)


@pytest.mark.parametrize(
    ("p", "told"), [(0.0, "0%"), (0.001, "<1%"), (0.005, "<1%"), (0.006, "1%"), (1.0, "100%")]
)
def test_what_is_little_is_not_called_nothing(p, told):
    assert percent(p) == told
    assert (percent(0.0005, 1), percent(0.001, 1)) == ("<0.1%", "0.1%")


def test_a_point_is_said_to_be_taken_as_certain():
    text = "\n".join(explain_lines(posterior(model="sloop-m4")))
    assert "“behind” takes House to face north (90° from east), taken as certain" in text
    assert "faced" not in text


def test_components_that_do_not_apply_are_left_out():
    post = posterior(said(relation("behind", "House")))
    assert "no-frame" not in "\n".join(explain_lines(post))
    sheet = sheet_of(post, TARGET)
    assert set(sheet.components) == {"product", "at", "near"}
    assert sheet.component_prior == pytest.approx({"product": 0.8, "at": 2 / 15, "near": 1 / 15})


def test_two_far_places_are_told_apart():
    prior = np.zeros(CITY.grid.shape)
    prior[2, 2], prior[18, 18] = 2, 1
    silent = said(relation("near", "House"), targets=(TARGET, "RedBike"))
    lines = explain_lines(posterior(silent, prior={"RedBike": prior}))
    start = lines.index("    90 % in 2 places:")
    assert lines[start + 1].startswith("      67% ")
    assert lines[start + 2].startswith("      33% ")


def test_a_sheet_holds_everything_that_explains():
    sheet = sheet_of(posterior(), TARGET, (1.0, 2.0))
    assert list(sheet.parts) == list(sheet.influence) == ["behind House", "on Main Street"]
    assert list(sheet.component_maps) == [
        f"{name} ({percent(p)})" for name, p in posterior().component(TARGET).items()
    ]
    for table in (*sheet.parts.values(), *sheet.component_maps.values(), sheet.prior):
        assert table.sum() == pytest.approx(1)
    (rose,) = sheet.roses
    np.testing.assert_allclose(rose.posterior, posterior().frame(TARGET))
    assert sheet.truth == (1.0, 2.0)


def test_a_sheet_is_drawn_for_every_target():
    figure = figure_of(posterior())
    titles = [ax.get_title() for ax in figure.axes if ax.get_title()]
    assert titles[0] == TARGET
    assert titles[-1] == "RedBike"
    assert "behind House" in titles
    assert any(t.startswith("Against the prior: ") for t in titles)


def test_models_that_do_not_listen_have_a_sheet_too():
    truth = {TARGET: (0.0, 0.0), "RedBike": (5.0, 5.0)}
    sheet = sheet_of(posterior(model="informed", truth=truth), TARGET)
    assert (sheet.parts, sheet.influence, sheet.components) == ({}, {}, {})
