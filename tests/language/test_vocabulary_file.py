"""Every surface form of the vocabulary file is read as its relation."""

import json
from importlib.resources import files

import pytest

from sloop_ppl.language import FRAME_RELATIONS, RELATION_CLASSES, RELATIONS, parse
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.maps import load_map

CITY = load_map("cleveland")
ENTRIES = json.loads((files("sloop_ppl") / "data" / "cues.json").read_text("utf-8"))["cues"]
FORMS = [(form, entry) for entry in ENTRIES for form in entry["forms"]]


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda e: e["relation"])
def test_class_and_flags_agree_with_the_vocabulary(entry):
    assert entry["class"] == RELATIONS[entry["relation"]]
    assert entry["frame"] == (entry["class"] in FRAME_RELATIONS)
    assert entry["two_grounds"] == (entry["class"] == "between")


@pytest.mark.parametrize(("form", "entry"), FORMS, ids=[form for form, _ in FORMS])
def test_form_is_read(form, entry):
    ground = "Ivy and Rumor" if entry["two_grounds"] else "Rumor"
    (relation,) = parse(f"The red bike is {form} {ground}.", CITY).relations
    assert (relation.figure, relation.relation) == ("RedBike", entry["relation"])
    assert relation.negated == entry.get("negated", False)
    assert relation.grounds[-1] == "Rumor"


@pytest.mark.parametrize("word", lexicon().directions)
def test_direction_is_read(word):
    (relation,) = parse(f"The red bike is to the {word} of Rumor.", CITY).relations
    assert relation.relation == lexicon().directions[word]


def test_every_canonical_word_can_be_said():
    said = {entry["relation"] for entry in ENTRIES} | set(lexicon().directions.values())
    assert {w for words in RELATION_CLASSES.values() for w in words} - said == {"by"}
