"""Any text gives a description, whose spans lie in the text, with work linear in its length."""

import json
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.language import NOT_ON_MAP, RELATIONS, WHOLE_MAP, parse
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.maps import load_map

CITY = load_map("denver")
WORDS = (
    *sorted(lexicon().closed),
    *(m.name for m in CITY.landmarks if m.name),
    *("red bike", "green toyota", "the", "my", "dog", "xyzzy", "6th", "🚲", "сад", "<b>", "&amp;"),
)  # fmt: skip
MARKS = (
    "", " ", " ", " ", " ", ". ", ", ", "; ", "\n", "-", "'s ", "\t", "\0", "\u200f", "!!", '"',
)  # fmt: skip


def check(text):
    said = parse(text, CITY)
    assert said.text == text
    spoken = {t.id for t in said.targets}
    for relation in said.relations:
        assert relation.relation in RELATIONS
        assert relation.figure in spoken
        named = {WHOLE_MAP, NOT_ON_MAP, *spoken}
        assert all(ground in CITY or ground in named for ground in relation.grounds)
        assert 0.0 <= relation.confidence <= 1.0
        spans = relation.spans
        for start, end in (spans.figure, spans.relation, *spans.grounds):
            assert 0 <= start < end <= len(text)
    for loose in said.unresolved:
        assert text[slice(*loose.span)] == loose.text
        assert all(candidate in CITY for candidate in loose.candidates)
    json.dumps(said.to_json())


@settings(max_examples=150, deadline=None)
@given(st.text(max_size=200))
def test_any_characters(text):
    check(text)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(WORDS), st.sampled_from(MARKS)), max_size=40))
def test_any_words(pieces):
    check("".join(word + mark for word, mark in pieces))


@pytest.mark.parametrize(
    "words", ["northernmost building Zorba", "southern building Zorba", "western street Zorba it"]
)
def test_no_place_is_the_farthest_of_none(words):
    """A building that none of the map's fits: it is none of them, and has no northernmost one."""
    check(f"red bike near {words}")
    assert parse(f"red bike near {words}", CITY).relations == ()


def nonsense(rng):
    words = rng.integers(len(WORDS), size=int(rng.integers(1, 10)))
    marks = rng.integers(len(MARKS), size=len(words))
    text = "".join(WORDS[w] + MARKS[m] for w, m in zip(words, marks, strict=True))
    if rng.random() < 0.3:
        at = int(rng.integers(len(text) + 1))
        text = text[:at] + chr(int(rng.integers(1, 0xD000))) + text[at:]
    return text


def test_nonsense():
    rng = np.random.default_rng(1)
    for _ in range(2_000):
        check(nonsense(rng))


@pytest.mark.slow
def test_a_hundred_thousand_strings_of_nonsense():
    rng = np.random.default_rng(0)
    for _ in range(100_000):
        check(nonsense(rng))


@pytest.mark.parametrize(
    "unit",
    [
        ",", "!?", "corner of ", "the building of ", "Logan and ", "between ", "a", "within 5 m ",
        "red bike near Logan Street ", "it is there too ", "my dog is ", "the same ", "near abc ",
    ],
)  # fmt: skip
def test_work_grows_with_the_length_not_its_square(unit):
    short, long = (lines_run(unit * (n // len(unit))) for n in (1_000, 8_000))
    # eight times the text; its square would take 64 times the work
    assert long < 12 * short


def lines_run(text):
    """Count the lines of Python that reading a text runs, caches warm."""
    count = 0

    def trace(frame, event, argument):
        nonlocal count
        count += 1
        return trace

    parse(text, CITY)
    before = sys.gettrace()
    sys.settrace(trace)
    try:
        parse(text, CITY)
    finally:
        sys.settrace(before)
    return count


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", ["," * 1_000_000, "The red bike is near Ivy. " * 60_000, "é" * 10**6]
)
def test_megabytes(text):
    check(text)
