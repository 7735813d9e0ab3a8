"""The rule parser reads the same with and without spaCy: relations, spans, what is unresolved."""

import ast
import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
import spacy
from hypothesis import example, given, settings
from hypothesis import strategies as st
from support.tree import ROOT, run_python

from sloop_ppl.eval import bundled_examples, read_descriptions
from sloop_ppl.language import load_pipeline, parse
from sloop_ppl.language.pipeline import COMPONENTS
from sloop_ppl.maps import bundled_maps, load_map

DATA = Path(__file__).parent / "data"
QUOTED = re.compile(r'"([^"\n]{8,})"|`([^`\n]{8,})`|“([^”\n]{8,})”')


@cache
def ours(name):
    """The pipeline with a tokenizer of our own."""
    return load_pipeline(name)


@cache
def blank(name):
    """The components in a pipeline with spaCy's own tokenizer."""
    nlp = spacy.blank("en")
    nlp.max_length = 10**9
    nlp.add_pipe(COMPONENTS[0], config={"map": name})
    for component in COMPONENTS[1:]:
        nlp.add_pipe(component)
    return nlp


@cache
def city(name):
    return load_map(name)


def check(text, name, pipelines=(ours, blank)):
    """Compare all that is read, and return it."""
    read = parse(text, city(name))
    for pipeline in pipelines:
        found = pipeline(name)(text.encode("utf-8", "replace").decode())._.sloop_description
        assert replace(found, text=text) == read
    return read


def test_bundled_examples():
    read = [check(annotated.text, annotated.map) for annotated in bundled_examples()]
    assert sum(len(said.relations) for said in read) >= 50


@pytest.mark.parametrize("file", ["hard_dev.jsonl", "hard_scored.jsonl"])
def test_the_hard_set(file):
    descriptions = read_descriptions(DATA / file)
    assert len(descriptions) >= 60
    for annotated in descriptions:
        check(annotated.text, annotated.map)


def quoted_in_docs():
    """What is quoted in the pages, and so every sentence that they read."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    found = (m for page in pages for m in QUOTED.finditer(page.read_text("utf-8")))
    return sorted({next(filter(None, match.groups())) for match in found})


def texts_in_tests():
    """The strings of several words in the tests and examples, and so every sentence there."""
    strings = set()
    for folder in ("tests", "examples"):
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    strings.add(node.value)
    return sorted(s for s in strings if len(s.split()) > 2)


@pytest.mark.parametrize(("texts", "relations"), [(quoted_in_docs, 10), (texts_in_tests, 50)])
def test_texts_of_the_project(texts, relations):
    found = texts()
    assert len(found) > 300
    read = [check(text, "cleveland", [ours]) for text in found]
    assert sum(len(said.relations) for said in read) >= relations


@pytest.mark.parametrize("name", bundled_maps())
def test_every_landmark_of_the_maps(name):
    for landmark in city(name).landmarks:
        called = landmark.name or landmark.id
        check(f"The red bike's behind {called}, 2.5 m from it; it isn't on St. X.", name)


NAMES = (
    *(m.name for m in city("denver").landmarks if m.name),
    *("red bike", "green toyota", "the SUV", "my dog", "Dr. Who", "O'Brien's", "tom’s car"),
)  # fmt: skip
WORDS = (
    *(
        "is",
        "isn't",
        "ain't",
        "it's",
        "in front of",
        "behind",
        "between",
        "and",
        "at the corner of",
    ),
    *("within", "not near", "on the left side of", "to its left", "NE of", "across from", "or"),
    *("the", "of", "they're", "who's", "that", "other one", "can't", "gonna", "y'all", "'tis"),
    *("W.", "E 9th St.", "Ave", "Blvd.", "St.", "Mt.", "Jr.", "U.S.", "p.m.", "e.g.", "No. 5"),
    *("50 m", "3.5km", "1,200 feet", "6th", "21st", "2", "10-20 m", "½", "100%", "$5", "#3"),
    *("a/b", "x@y.org", "http://z.de/q?a=1", ":-)", "<b>", "🚲", "naïve", "сад", "\ud800", "\0"),
)
MARKS = (" ", " ", " ", " ", "", ". ", ", ", "; ", "'s ", "’s ", "-", "—", "...", "!?", '"', "(",
         ") ", "\n", "\t", "  ", "\u200f", "\xa0")  # fmt: skip


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(NAMES + WORDS), st.sampled_from(MARKS)), max_size=30))
@example([(" ", ""), ("is", " "), ("red bike", "\n")])
@example([])
def test_mixtures_of_names_marks_abbreviations_and_numbers(pieces):
    check("".join(word + mark for word, mark in pieces), "denver")


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=120))
def test_any_characters(text):
    check(text, "denver", [ours])


def test_reading_loads_no_spacy(tmp_path):
    code = (
        "import json, sys, sloop_ppl\n"
        "said = sloop_ppl.parse('the red bike is behind ivy', 'cleveland')\n"
        "print(json.dumps([len(said.relations), 'spacy' in sys.modules, 'torch' in sys.modules]))"
    )
    assert json.loads(run_python(code, tmp_path)) == [1, False, False]
