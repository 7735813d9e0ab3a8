"""A relation word from outside: parser, likelihoods, engines, speaker and explanation know it."""

import itertools

import numpy as np
import pytest
import shapely
import torch
from shapely import affinity

import sloop_ppl as sloop
from sloop_ppl.bridge.explain import explain_lines
from sloop_ppl.cli import main
from sloop_ppl.errors import InputError
from sloop_ppl.eval import AnnotatedDescription, score_parser
from sloop_ppl.inference import infer_description
from sloop_ppl.language import RELATIONS, Relation, SpatialRelation
from sloop_ppl.maps.rasterise import touched_cells
from sloop_ppl.models import LIKELIHOODS, PRESETS, ground_relations
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.check import check_likelihood
from sloop_ppl.models.simulation import SPEAKER, simulate

CITY = sloop.load_map("austin")
WORD = "kitty-corner"


def turned(city, grounds):
    """The ground turned half a circle about the crossing of two streets that is nearest."""
    shape = city.footprint(grounds[0])
    streets = [mark.geometry for mark in city.landmarks if mark.kind == "street"]
    crossings = [a.intersection(b) for a, b in itertools.combinations(streets, 2)]
    crossings = [crossing.centroid for crossing in crossings if not crossing.is_empty]
    corner = min(crossings, key=shape.distance, default=None)
    return None if corner is None else affinity.rotate(shape, 180, origin=corner)


@pytest.fixture
def kitty_corner():
    before = sloop.parse("The red bike is kitty corner from Norwood Tower", CITY).relations
    record = Relation(
        WORD,
        forms=("kitty-corner from", "kitty-corner to", "kitty corner from", "kitty corner to"),
        converse=WORD,
        width="across",
        region=turned,
        speakable=True,
    )
    yield RELATIONS.add(WORD, record)
    RELATIONS.remove(WORD)
    assert sloop.parse("The red bike is kitty corner from Norwood Tower", CITY).relations == before
    assert before[0].relation == "across"
    assert WORD not in speaker_words()


def said(text):
    return [(r.figure, r.relation, r.grounds) for r in sloop.parse(text, CITY).relations]


def test_the_parser_reads_it(kitty_corner):
    assert said("The red bike is kitty-corner from Norwood Tower") == [
        ("RedBike", WORD, ("NorwoodTower",))
    ]
    assert said("The red bike is kitty corner to Norwood Tower") == [
        ("RedBike", WORD, ("NorwoodTower",))
    ]
    assert said("Norwood Tower is kitty-corner from the red bike") == [
        ("RedBike", WORD, ("NorwoodTower",))
    ]
    # A slip of two letters in a long word is mended, and words of the new forms are known words.
    assert said("The red bike is kitty-cornr from Norwood Tower") == [
        ("RedBike", WORD, ("NorwoodTower",))
    ]


@pytest.mark.parametrize("name", LIKELIHOODS)
@pytest.mark.parametrize("ground", ["NorwoodTower", "West6thSt", "Map"])
def test_every_likelihood_takes_it(kitty_corner, name, ground):
    (term,) = ground_relations((SpatialRelation("RedBike", WORD, (ground,)),), CITY, joint=True)
    log_g = LIKELIHOODS[name].log_g(term, term.directions(None))
    assert log_g.shape == (CITY.grid.size,)
    assert bool(torch.isfinite(log_g).all())
    assert float(log_g.max()) <= 0
    if ground == "NorwoodTower":
        there = touched_cells(CITY.grid, turned(CITY, (ground,))).reshape(-1)
        assert float(log_g[there].mean()) > float(log_g[~there].mean()) + 2


@pytest.mark.parametrize("name", [n for n in LIKELIHOODS if n != "neural"])
def test_every_likelihood_passes_its_check_with_it(kitty_corner, name):
    check_likelihood(LIKELIHOODS[name])


@pytest.mark.parametrize("name", [n for n in PRESETS if n != "informed"])
def test_every_model_weighs_it(kitty_corner, name):
    description = sloop.parse("The red bike is kitty-corner from Norwood Tower", CITY)
    posterior, _ = infer_description(description, CITY, name)
    belief = posterior.belief("RedBike")
    assert belief.sum() == pytest.approx(1)
    if name != "uniform":
        assert belief.max() > 2 / belief.size


def test_its_meaning_is_its_own(kitty_corner):
    kitty = sloop.infer("The red bike is kitty-corner from Norwood Tower", CITY).belief("RedBike")
    over = sloop.infer("The red bike is across from Norwood Tower", CITY).belief("RedBike")
    assert 0.5 * np.abs(kitty - over).sum() > 0.3


def test_the_speaker_says_it_and_is_heard(kitty_corner):
    assert WORD in speaker_words()
    texts = [
        simulate(CITY, ["RedBike"], np.random.default_rng(seed), phrases=3).description
        for seed in range(60)
    ]
    spoken = [d for d in texts if any(r.relation == WORD for r in d.relations)]
    assert spoken
    for description in spoken:
        assert "kitty-corner from" in description.text
        read = sloop.parse(description.text, CITY)
        assert [(r.relation, r.ground) for r in read.relations] == [
            (r.relation, r.ground) for r in description.relations
        ]
    posterior, _ = infer_description(spoken[0], CITY, SPEAKER)
    assert posterior.belief("RedBike").sum() == pytest.approx(1)
    assert WORD in posterior.log_evidence.vocabulary


def test_explanations_say_it(kitty_corner):
    posterior = sloop.infer("The red bike is kitty-corner from Norwood Tower", CITY)
    lines = "\n".join(explain_lines(posterior, rng=np.random.default_rng(0)))
    assert "kitty-corner from Norwood Tower" in lines


def test_it_is_a_class_of_its_own_in_scores(kitty_corner):
    gold = SpatialRelation("RedBike", WORD, ("NorwoodTower",))
    scene = AnnotatedDescription(
        "one", "austin", "one", "The red bike is kitty-corner from Norwood Tower", {}, (gold,)
    )
    score = score_parser([scene])
    assert (score.tuple_f1, score.class_f1) == (1.0, 1.0)
    assert WORD in score.per_relation


FILE = """
from sloop_ppl.language import RELATIONS, Relation
from sloop_ppl.models import preset

RELATIONS.add("catercorner", Relation("catercorner", ("catercorner from",), region="across"))
mine = preset("bayes")
"""


def test_a_file_of_a_model_may_add_one(tmp_path, capsys):
    (tmp_path / "mine.py").write_text(FILE)
    said = "The red bike is catercorner from Norwood Tower"
    typed = ["infer", said, "--map", "austin", "--model", f"{tmp_path}/mine.py:mine", "--explain"]
    try:
        with pytest.raises(SystemExit) as stopped:
            main(typed)
    finally:
        RELATIONS.remove("catercorner")
    assert stopped.value.code == 0
    assert "catercorner from Norwood Tower" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("region", "found"),
    [(lambda city, grounds: shapely.Point(), "empty"), (lambda city, grounds: [1.0], "a list")],
)
def test_a_region_that_is_no_shape_is_refused(region, found):
    RELATIONS.add("nowhere", Relation("nowhere", ("nowhere by",), region=region))
    try:
        with pytest.raises(
            InputError,
            match=f"to NorwoodTower is {found}; expected a shape in metres",
        ):
            sloop.infer("The red bike is nowhere by Norwood Tower", CITY)
    finally:
        RELATIONS.remove("nowhere")
