import pickle
from importlib.metadata import entry_points

import pytest
import spacy
from spacy.tokens import Doc, DocBin

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.language import load_pipeline, parse
from sloop_ppl.language.pipeline import COMPONENTS
from sloop_ppl.maps import load_map

TEXT = "The red bike is behind Velvet Dog.  The green\n\ncar isn't near Rumor!!"


def triples(doc):
    return [(r.figure, r.relation, r.ground) for r in doc._.spatial_relations]


def test_relations_are_an_attribute_of_the_text():
    doc = load_pipeline("cleveland")(TEXT)
    assert triples(doc) == [
        ("RedBike", "behind", "VelvetDog"),
        ("GreenToyota", "near", "Rumor"),
    ]
    assert doc._.sloop_description.map == "cleveland"


@pytest.mark.parametrize("text", [TEXT, "", " ", "\n a\t\tb ", "x" * 100, "\ud800 a", ",,,,a,,"])
def test_the_tokenizer_keeps_every_character(text):
    doc = load_pipeline("cleveland").make_doc(text)
    assert len(doc.text) == len(text)
    assert doc.text == text.replace("\ud800", "?")


def test_components_work_in_a_pipeline_of_ones_own():
    nlp = spacy.blank("en")
    nlp.add_pipe("sloop_landmarks", config={"map": "cleveland"})
    for name in COMPONENTS[1:]:
        nlp.add_pipe(name)
    assert triples(nlp(TEXT)) == triples(load_pipeline("cleveland")(TEXT))


def test_texts_can_be_read_in_a_stream():
    nlp = load_pipeline("cleveland")
    assert [len(triples(doc)) for doc in nlp.pipe([TEXT, "nothing", TEXT])] == [2, 0, 2]


def test_targets_come_from_a_file(tmp_path):
    path = tmp_path / "targets.json"
    path.write_text('[{"id": "Tom", "names": ["tom"]}]')
    assert triples(load_pipeline("cleveland", str(path))("Tom is near Ivy")) == [
        ("Tom", "near", "Ivy")
    ]


def test_a_pipeline_without_map_says_what_to_do():
    with pytest.raises(InputError, match="The component 'sloop_landmarks' has no map; add it"):
        load_pipeline()(TEXT)


def test_components_in_the_wrong_order_say_what_is_missing():
    nlp = spacy.blank("en")
    nlp.add_pipe("sloop_cues")
    with pytest.raises(InputError, match="'sloop_cues' found no landmarks read; add 'sloop_landm"):
        nlp(TEXT)


def test_an_unknown_map_is_refused_when_the_pipeline_is_made():
    with pytest.raises(UnknownName, match="Map 'atlantis' is unknown"):
        load_pipeline("atlantis")


def test_factories_are_declared_to_spacy():
    declared = {e.name: e.value for e in entry_points(group="spacy_factories")}
    if "sloop_landmarks" not in declared:
        pytest.skip("the project was installed before its factories were declared")
    assert {*COMPONENTS, "dependency_paths"} <= set(declared)
    for name in (*COMPONENTS, "dependency_paths"):
        module, _, attribute = declared[name].partition(":")
        assert module.startswith("sloop_ppl.language.")
        assert attribute.startswith("make_")


TEXTS = [
    "The red bike is behind Velvet Dog",
    "The food truck is near a bank, 50 m north of Hoyt Block",
]


def test_what_is_recognised_stands_in_spans():
    doc = load_pipeline("cleveland")(TEXTS[1])
    (landmark,) = doc.spans["sloop_landmarks"]
    assert (landmark.text, landmark.label_, landmark.kb_id_) == (
        "Hoyt Block",
        "LANDMARK",
        "HoytBlock",
    )
    (thing,) = doc.spans["sloop_objects"]
    assert (thing.text, thing.label_, thing.kb_id_) == ("food truck", "OBJECT", "FoodTruck")
    (kind,) = doc.spans["sloop_kinds"]
    assert (kind.text, kind.label_) == ("bank", "KIND")
    cues = {(span.text, span.label_, span.kb_id_) for span in doc.spans["sloop_cues"]}
    assert ("near", "RELATION", "near") in cues
    assert ("north", "RELATION", "north") in cues


def test_documents_are_saved_with_their_description(tmp_path):
    nlp = load_pipeline("cleveland")
    doc = nlp(TEXTS[0])
    again = Doc(nlp.vocab).from_bytes(doc.to_bytes())
    assert again._.sloop_description == doc._.sloop_description
    kept = DocBin(store_user_data=True, docs=[doc])
    kept.to_disk(tmp_path / "docs.spacy")
    (read,) = DocBin(store_user_data=True).from_disk(tmp_path / "docs.spacy").get_docs(nlp.vocab)
    assert read._.spatial_relations == doc._.spatial_relations


def test_a_pipeline_of_a_map_is_pickled_and_runs_in_several_processes():
    nlp = load_pipeline(load_map("cleveland"))
    alone = [doc._.sloop_description for doc in nlp.pipe(TEXTS)]
    assert [d.relations for d in alone] == [
        parse(text, load_map("cleveland")).relations for text in TEXTS
    ]
    assert [doc._.sloop_description for doc in pickle.loads(pickle.dumps(nlp)).pipe(TEXTS)] == alone
    assert [doc._.sloop_description for doc in nlp.pipe(TEXTS, n_process=2)] == alone


def test_a_pipeline_is_saved_with_its_map(tmp_path):
    nlp = load_pipeline(load_map("cleveland"))
    nlp.to_disk(tmp_path / "pipeline")
    read = load_pipeline()
    read.from_disk(tmp_path / "pipeline")
    assert read(TEXTS[0])._.sloop_description == nlp(TEXTS[0])._.sloop_description


@pytest.mark.parametrize(
    "saved",
    [b"", b"\xff", b"[]", b"{}", b"[" * 100_000, b'{"map": {}, "targets": null}',
     b'{"map": null, "targets": [{"id": 7}]}'],
)  # fmt: skip
def test_a_damaged_pipeline_is_refused_in_one_line(tmp_path, saved):
    load_pipeline(load_map("cleveland")).to_disk(tmp_path / "pipeline")
    (tmp_path / "pipeline" / "sloop_landmarks").write_bytes(saved)
    with pytest.raises(InputError) as caught:
        load_pipeline().from_disk(tmp_path / "pipeline")
    assert "\n" not in str(caught.value)
