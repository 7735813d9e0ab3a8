"""Every way to say a relation is read as it, and the records agree with one another."""

import math
import re

import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.language import (
    RELATIONS,
    Relation,
    SpatialRelation,
    TargetObject,
    parse,
    words_by_class,
)
from sloop_ppl.maps import load_map
from sloop_ppl.models._vocabulary import in_english, speaker_words

CITY = load_map("cleveland")
FORMS = [
    pytest.param(form, word, denies, id=form)
    for word, record in RELATIONS.items()
    for forms, denies in ((record.forms, False), (record.denied_forms, True))
    for form in forms
]
DIRECTIONS = [(form, word) for word, record in RELATIONS.items() for form in record.directions]


@pytest.mark.parametrize(("form", "word", "denies"), FORMS)
def test_form_is_read(form, word, denies):
    ground = "Ivy and Rumor" if RELATIONS[word].grounds == "several" else "Rumor"
    (relation,) = parse(f"The red bike is {form} {ground}.", CITY).relations
    assert (relation.figure, relation.relation) == ("RedBike", word)
    assert relation.negated == denies
    assert relation.grounds[-1] == "Rumor"


@pytest.mark.parametrize(("form", "word"), DIRECTIONS)
def test_direction_is_read(form, word):
    (relation,) = parse(f"The red bike is to the {form} of Rumor.", CITY).relations
    assert relation.relation == word


def test_what_a_speaker_says_is_read_back():
    """All but "by", which is read as near: people tell the two apart no more than they do."""
    for word, record in RELATIONS.items():
        grounds = ("Ivy", "Rumor") if record.grounds == "several" else ("Ivy",)
        said = [SpatialRelation("RedBike", word, grounds)]
        text = in_english(said, [TargetObject("RedBike", ("red bike",))], CITY)
        (read,) = parse(text, CITY).relations
        assert (read.relation, read.grounds) == ("near" if word == "by" else word, grounds)


def test_no_two_words_have_one_form():
    forms = [form for r in RELATIONS.values() for form in (*r.forms, *r.denied_forms)]
    assert len(forms) == len(set(forms))


@pytest.mark.parametrize("word", RELATIONS)
def test_words_that_a_record_names_have_records(word):
    record = RELATIONS[word]
    for other in (record.converse, record.of_map, record.from_ground):
        assert other is None or other in RELATIONS
    if record.converse is not None:
        turned = RELATIONS[record.converse]
        assert RELATIONS[turned.converse].relation_class == record.relation_class
        if record.is_compass:
            apart = turned.bearing_rad - record.bearing_rad
            assert math.cos(apart) == pytest.approx(-1)
        if record.needs_frame:
            assert math.cos(turned.offset_rad - record.offset_rad) == pytest.approx(-1)


def test_classes_are_those_that_evaluation_merges():
    assert words_by_class() == {
        "contact": ("on", "at", "in", "inside", "along", "within", "middle", "side", "adjacent"),
        "proximity": (
            "near", "beside", "next", "by", "around", "close", "outside", "towards", "against",
            "off", "beyond",
        ),
        "between": ("between",),
        "north": ("north", "above", "up", "top"),
        "south": ("south", "below", "down", "under"),
        **{
            word: (word,)
            for word in (
                "east", "west", "northeast", "northwest", "southeast", "southwest", "front",
                "behind", "left", "right", "across",
            )
        },
    }  # fmt: skip
    framed = [word for word, record in RELATIONS.items() if record.needs_frame]
    assert framed == ["front", "behind", "left", "right"]


def test_a_speaker_chooses_among_the_same_words_in_the_same_order():
    assert speaker_words() == (
        "at", "near", "north", "northeast", "east", "southeast", "south", "southwest", "west",
        "northwest", "front", "behind", "left", "right",
    )  # fmt: skip


def test_bad_records_are_refused():
    with pytest.raises(InputError, match="has no words; expected forms, or a phrase to say it by"):
        Relation("corner")
    message = "A relation of class 'north' has a bearing and an offset; expected one direction"
    with pytest.raises(InputError, match=re.escape(message)):
        Relation("north", phrase="north of", bearing_rad=1.0, offset_rad=0.0)
    with pytest.raises(ValueError, match="relation 'near' is registered already"):
        RELATIONS.add("near", Relation("proximity", phrase="near"))
    with pytest.raises(UnknownName, match=r"Relation 'behnd' is unknown; .*'behind'"):
        SpatialRelation("RedBike", "behnd", ("Ivy",))
