import tarfile
from pathlib import Path

import pytest
import spacy
from spacy.tokens import Doc

from sloop_ppl.errors import InputError
from sloop_ppl.language import dependency_parser, parse
from sloop_ppl.language.dependency import check_parser
from sloop_ppl.language.paths import relations_on_paths
from sloop_ppl.maps import load_map

MODEL = Path(__file__).parents[3] / "shared" / "models" / "en_ud_clear_sm.tar.gz"
BLANK = spacy.blank("en")


def doc(*tokens):
    """Build a parsed text of (word, head, label)."""
    words, heads, deps = zip(*tokens, strict=True)
    return Doc(BLANK.vocab, words=list(words), heads=list(heads), deps=list(deps))


def told(parsed, figures, grounds, **options):
    found = relations_on_paths(parsed, figures, grounds, **options)
    return [(r.figure, ("not " if r.negated else "") + r.relation, r.ground) for r in found]


SIMPLE = doc(
    ("bike", 1, "nsubj"),
    ("is", 1, "ROOT"),
    ("in", 1, "prep"),
    ("front", 2, "pobj"),
    ("of", 3, "prep"),
    ("Rome", 4, "pobj"),
    ("and", 5, "cc"),
    ("Paris", 5, "conj"),
)
TWO_CLAUSES = doc(
    ("bike", 1, "nsubj"),
    ("is", 1, "ROOT"),
    ("behind", 1, "prep"),
    ("Rome", 2, "pobj"),
    ("and", 1, "cc"),
    ("car", 6, "nsubj"),
    ("is", 1, "conj"),
    ("not", 6, "neg"),
    ("near", 6, "prep"),
    ("Paris", 8, "pobj"),
)
SIDE = doc(
    ("car", 1, "nsubj"),
    ("is", 1, "ROOT"),
    ("on", 1, "prep"),
    ("the", 6, "det"),
    ("upper", 6, "amod"),
    ("left", 6, "amod"),
    ("corner", 2, "pobj"),
    ("of", 6, "prep"),
    ("Rome", 7, "pobj"),
)


def test_cue_of_several_words_and_coordinated_grounds():
    assert told(SIMPLE, [0], [5, 7]) == [(0, "front", 5), (0, "front", 7)]


def test_paths_into_another_clause_count_only_when_every_path_does():
    assert told(TWO_CLAUSES, [0, 5], [3, 9]) == [(0, "behind", 3), (5, "not near", 9)]
    every = told(TWO_CLAUSES, [0, 5], [3, 9], every_path=True)
    assert (0, "not near", 9) in every
    assert (5, "not behind", 3) in every


def test_directions_of_a_part_count_instead_of_the_preposition():
    assert told(SIDE, [0], [8]) == [(0, "top", 8), (0, "left", 8)]


def pipeline(*labels):
    nlp = spacy.blank("en")
    parser = nlp.add_pipe("parser")
    for label in labels:
        parser.add_label(label)
    return nlp


def test_ud_labels_are_refused_with_the_reason():
    with pytest.raises(InputError) as caught:
        check_parser(pipeline("nsubj", "obl", "case", "nmod"))
    assert str(caught.value) == (
        "The parser of the spaCy pipeline 'en_pipeline' gives UD labels (case, nmod, obl); the "
        "rule dependency_paths follows prep and pobj and needs CLEAR labels, such as those of "
        "en_core_web_md"
    )


def test_a_pipeline_without_parser_is_refused():
    with pytest.raises(InputError, match="has no dependency parser; the rule dependency_paths"):
        dependency_parser(spacy.blank("en"))


def test_a_pipeline_that_cannot_be_loaded_is_said_in_one_line():
    with pytest.raises(InputError) as caught:
        dependency_parser("no_such_pipeline")
    assert str(caught.value).startswith("The spaCy pipeline 'no_such_pipeline' cannot be loaded")
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(not MODEL.exists(), reason="the small parser of ../shared is absent")
def test_a_real_parser_reads_plain_sentences(tmp_path):
    with tarfile.open(MODEL) as archive:
        archive.extractall(tmp_path, filter="data")
    (folder,) = (p.parent for p in tmp_path.rglob("config.cfg"))
    city = load_map("cleveland")
    parser = dependency_parser(folder)
    text = "The red bike is behind the Velvet Dog and the green car is in front of Rumor."
    said = parse(text, city, parser=parser)
    assert {(r.figure, r.relation, r.ground) for r in said.relations} == {
        ("RedBike", "behind", "VelvetDog"),
        ("GreenToyota", "front", "Rumor"),
    }
    first = said.relations[0].spans
    assert text[slice(*first.figure)] == "red bike"
    assert text[slice(*first.grounds[0])] == "Velvet Dog"
    nlp = spacy.load(folder)
    nlp.add_pipe("dependency_paths", config={"map": "cleveland"})
    assert {r.ground for r in nlp(text)._.spatial_relations} == {"VelvetDog", "Rumor"}
