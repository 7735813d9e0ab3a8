import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval._corruption import merge_maps, misspell
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.eval.parsing import score_parser
from sloop_ppl.language import Description, SpatialRelation, TargetObject
from sloop_ppl.maps import bundled_maps, load_map

CLEVELAND = load_map("cleveland")
GOLD = (
    SpatialRelation("RedBike", "on", ("West6thSt",)),
    SpatialRelation("RedBike", "near", ("Ivy",)),
    SpatialRelation("GreenToyota", "between", ("Rumor", "Ivy")),
)
SCENE = AnnotatedDescription("one", "cleveland", "one", "some text", relations=GOLD)


def says(*relations):
    def parser(text, city, targets):
        told = tuple(SpatialRelation(f, r, g) for f, r, g in relations)
        return Description(text, city.name, (TargetObject("RedBike"),), told)

    return parser


def test_f1_of_a_case_counted_by_hand():
    score = score_parser(
        [SCENE],
        parser=says(
            ("RedBike", "at", ("West6thSt",)),  # same class, other word
            ("RedBike", "near", ("Ivy",)),
            ("RedBike", "near", ("Ivy",)),  # said twice, counted once
            ("GreenToyota", "north", ("Rumor",)),  # the pair is right
        ),
    )
    assert score.n == 1
    assert (score.precision, score.recall) == (round(1 / 3, 6), 0.25)
    assert score.tuple_f1 == round(2 * 1 / (3 + 4), 6)
    assert score.class_f1 == round(2 * 2 / (3 + 4), 6)
    assert score.pair_f1 == round(2 * 3 / (3 + 4), 6)
    assert score.per_relation["near"] == {"n": 1, "precision": 1.0, "recall": 1.0, "f1": 1.0}
    assert score.per_relation["north"] == {"n": 0, "precision": 0.0, "recall": 0.0, "f1": 0.0}
    (miss,) = score.misses  # another word of the same class is none
    assert miss.missed == (("GreenToyota", "between", "Ivy"), ("GreenToyota", "between", "Rumor"))
    assert miss.spurious == (("GreenToyota", "north", "Rumor"),)


def test_rates_have_six_decimals():
    three = (*GOLD[:2], SpatialRelation("GreenToyota", "near", ("Rumor",)))
    scene = AnnotatedDescription("one", "cleveland", "one", "some text", relations=three)
    score = score_parser([scene], parser=says(("RedBike", "near", ("Ivy",))))
    assert (score.precision, score.recall, score.tuple_f1) == (1.0, 0.333333, 0.5)
    assert score.per_relation["near"] == {"n": 2, "precision": 1.0, "recall": 0.5, "f1": 0.666667}


def test_json_has_the_agreed_keys():
    told = score_parser([SCENE], parser=says()).to_json()
    assert list(told) == [
        "n", "tuple_f1", "class_f1", "pair_f1", "precision", "recall", "per_relation",
        "polarity_f1", "linking_recall", "wholly_right", "false_positives", "not_scored",
        "statuses", "phenomena",
    ]  # fmt: skip
    assert told["tuple_f1"] == 0.0


def test_nothing_to_find_and_nothing_found_is_perfect():
    empty = AnnotatedDescription("two", "cleveland", "two", "hello")
    assert score_parser([empty], parser=says()).tuple_f1 == 1.0


def test_declared_targets_are_handed_to_the_parser():
    seen = []

    def parser(text, city, targets):
        seen.append(targets)
        return Description(text, city.name, (), ())

    from sloop_ppl.eval.descriptions import Place

    declared = AnnotatedDescription(
        "three", "cleveland", "three", "x", targets={"RedHonda": Place(0.0, 0.0, (20, 20))}
    )
    score_parser([declared, SCENE], parser=parser)
    assert [t.id for t in seen[0]] == ["RedHonda"]
    assert seen[1] is None


def test_maps_are_merged_under_their_names():
    both = merge_maps([CLEVELAND, load_map("austin")])
    assert {"cleveland/West6thSt", "austin/West6thSt"} <= {m.id for m in both.landmarks}
    assert both.landmark("cleveland/Ivy").within == "cleveland/TheBradley"


def test_a_name_that_two_maps_share_is_read_on_the_map_spoken_of():
    descriptions = [
        AnnotatedDescription(
            city,
            city,
            city,
            f"The red bike is on West 6th Street near {near}",
            relations=(
                SpatialRelation("RedBike", "on", ("West6thSt",)),
                SpatialRelation("RedBike", "near", (place,)),
            ),
        )
        for city, near, place in (
            ("cleveland", "Velvet Dog", "VelvetDog"),
            ("austin", "Norwood Tower", "NorwoodTower"),
        )
    ]
    merged = [load_map(name) for name in bundled_maps()]
    assert score_parser(descriptions, merged=merged).tuple_f1 == 1.0


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_misspelling_edits_long_words_once(share):
    text = "Behind the Velvet Dog stands a bicycle " * 20
    told = misspell(text, share, rng=np.random.default_rng(3))
    assert told == misspell(text, share, rng=np.random.default_rng(3))
    before, after = text.split(), told.split()
    assert len(before) == len(after)
    changed = [a != b for a, b in zip(before, after, strict=True)]
    assert all(len(a) >= 5 for a, c in zip(before, changed, strict=True) if c)
    long = sum(len(w) >= 5 for w in before)
    # 80 long words: outside four standard deviations one time in 16,000
    assert abs(sum(changed) - share * long) <= 4 * (long * share * (1 - share)) ** 0.5
    assert all(abs(len(a) - len(b)) <= 1 for a, b in zip(before, after, strict=True))


def test_spelling_does_not_depend_on_the_other_descriptions():
    texts = {}

    def parser(text, city, targets):
        texts.setdefault(len(texts), text)
        return Description(text, city.name, (), ())

    long = "behind the building across from another building " * 5
    descriptions = [AnnotatedDescription(i, "cleveland", i, long) for i in ("a", "b")]
    for some in (descriptions, descriptions[1:]):
        score_parser(some, parser=parser, misspelt=0.5, rng=np.random.default_rng(0))
    assert texts[1] == texts[2] != texts[0]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"descriptions": []}, "There is no description to score; expected at least one"),
        (
            {"misspelt": 1.5, "rng": np.random.default_rng(0)},
            "The share of misspelt words is 1.5; expected 0 to 1",
        ),
        ({"misspelt": 0.1}, "Misspelling draws at random and no rng was given; give one"),
        ({"merged": []}, "The maps to merge are none; expected at least one, each with a name"),
    ],
)
def test_bad_arguments(given, message):
    with pytest.raises(InputError) as caught:
        score_parser(**({"descriptions": [SCENE]} | given))
    assert str(caught.value).startswith(message)
