"""Scores of gold with alternatives, each counted by hand."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval._gold import GoldEntry
from sloop_ppl.eval._matching import ReadEntry, is_right, match
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.eval.parsing import score_parser
from sloop_ppl.language import (
    NOT_ON_MAP,
    Candidate,
    Description,
    RelationSpans,
    SpatialRelation,
    StreetPart,
    Unresolved,
)

FIGURE = "RedBike"


def gold(relation, ground="Ivy", **more):
    return GoldEntry(FIGURE, relation, ground, **more)


def line(*entries, name="one", **more):
    return AnnotatedDescription(name, "cleveland", name, f"text {name}", entries=entries, **more)


def said(relation, *grounds, **more):
    return SpatialRelation(FIGURE, relation, grounds or ("Ivy",), **more)


def score(lines, *relations, unresolved=(), **more):
    def parser(text, city, targets):
        return Description(text, city.name, (), relations, unresolved)

    return score_parser(lines if isinstance(lines, list) else [lines], parser=parser, **more)


def test_each_accepted_ground_is_right():
    one = line(gold("near", "Ivy", also=("Rumor", "Spirits")))
    for ground in ("Ivy", "Rumor", "Spirits"):
        assert score(one, said("near", ground)).tuple_f1 == 1
    wrong = score(one, said("near", "HoytBlock"))
    assert (wrong.tuple_f1, wrong.false_positives) == (0, 1)
    # Both read: only one of them is wanted.
    assert score(one, said("near", "Ivy"), said("near", "Rumor")).precision == 0.5


def test_what_was_read_is_assigned_so_that_most_is_right():
    # Taken in turn, the first entry would take Ivy, and the second would go without.
    one = line(gold("near", "Ivy", also=("Rumor",)), gold("near", "Ivy", also=("Spirits",)))
    assert score(one, said("near", "Ivy"), said("near", "Rumor")).tuple_f1 == 1


def test_the_assignment_is_the_best_of_all():
    rng = np.random.default_rng(0)
    for _ in range(200):
        entries = [
            GoldEntry(
                FIGURE,
                "near",
                f"G{i}",
                also=tuple(f"R{j}" for j in range(4) if rng.random() < 0.4),
                optional=bool(rng.random() < 0.4),
            )
            for i in range(4)
        ]
        read = [ReadEntry(FIGURE, "near", f"R{j}") for j in range(4)]
        found = match(entries, read, lambda e: e.figure, lambda e: e.figure)
        best = max(
            _value(entries, read, order) for order in itertools.permutations(range(len(read)))
        )
        assert (len(found.right), -len(found.wrong)) == best


def _value(entries, read, order):
    pairs = [(entries[i], read[j]) for i, j in enumerate(order) if is_right(entries[i], read[j])]
    required = sum(not entry.optional for entry, _ in pairs)
    return required, len(pairs) - len(read)


def test_an_optional_entry_is_neither_hit_nor_miss():
    one = line(gold("near"), gold("at", "Rumor", optional=True))
    for relations in ([said("near")], [said("near"), said("at", "Rumor")]):
        found = score(one, *relations)
        assert (found.tuple_f1, found.class_f1, found.polarity_f1) == (1, 1, 1)
        assert (found.wholly_right, found.per_relation.keys()) == (1, {"near"})
    unread = score(one, said("at", "Rumor"))
    assert (unread.precision, unread.recall) == (0, 0)
    assert unread.misses[0].spurious == ()


def test_two_entries_alike_are_required_when_one_is():
    one = line(gold("near"), gold("beside", optional=True))  # one pair
    assert score(one).pair_f1 == 0
    assert score(one, said("near"), said("beside")).pair_f1 == 1


def test_polarity_counts_what_is_denied():
    one = line(gold("near", negated=True, status="denied"))
    found = score(one, said("near"))
    assert (found.tuple_f1, found.polarity_f1, found.wholly_right) == (1, 0, 0)
    assert found.misses[0].missed == ((FIGURE, "not near", "Ivy"),)
    assert found.misses[0].spurious == ((FIGURE, "near", "Ivy"),)
    assert score(one, said("beside", negated=True)).polarity_f1 == 1


def test_a_word_of_the_same_class_is_wholly_right():
    found = score(line(gold("on", "West6thSt")), said("at", "West6thSt"))
    assert (found.tuple_f1, found.polarity_f1, found.wholly_right) == (0, 1, 1)


@pytest.mark.parametrize("status", ["asked", "retracted", "past", "route", "other"])
def test_what_is_not_to_be_read_is_wrong_when_read(status):
    one = line(gold("near"), gold("at", "Rumor", status=status))
    left = score(one, said("near"))
    assert (left.tuple_f1, left.wholly_right, left.false_positives) == (1, 1, 0)
    assert left.statuses[status] == {"n": 1, "read": 0}
    read = score(one, said("near"), said("at", "Rumor"))
    assert (read.precision, read.recall, read.false_positives) == (0.5, 1, 1)
    assert read.statuses[status] == {"n": 1, "read": 1}
    may = line(gold("near"), gold("at", "Rumor", status=status, optional=True))
    assert score(may, said("near"), said("at", "Rumor")).false_positives == 0


def test_alternatives_have_a_status_of_their_own():
    one = line(
        gold("at", "Ivy", status="alternative"),
        gold("at", "Rumor", status="alternative"),
        gold("on", "West6thSt"),
    )
    both = [said("at", "Ivy", either=(0, 0)), said("at", "Rumor", either=(0, 1))]
    right = score(one, *both, said("on", "West6thSt"))
    assert right.statuses["alternative"] == {"n": 2, "precision": 1, "recall": 1, "f1": 1}
    product = score(one, *(replace(r, either=None) for r in both), said("on", "West6thSt"))
    assert product.polarity_f1 == 1
    assert product.statuses["alternative"]["recall"] == 0
    assert product.statuses["asserted"]["precision"] == round(1 / 3, 6)


def with_words(text, phrase, ground, *candidates):
    """Return a parser that reads RedBike east of what a phrase of the text names."""
    start = text.index(phrase)
    spans = RelationSpans((0, 1), (0, 1), ((start, start + len(phrase)),))
    slots = (tuple(Candidate(c, 1 / len(candidates)) for c in candidates),) if candidates else ()

    def parser(given, city, targets):
        relation = SpatialRelation(FIGURE, "east", (ground,), spans=spans, candidates=slots)
        return Description(text, city.name, (), (relation,))

    return parser


@pytest.mark.parametrize(
    ("phrase", "ground", "right"),
    [
        ("a primary school", NOT_ON_MAP, True),
        ("a primary school", "Ivy", True),  # whatever the map has of the kind
        ("it", NOT_ON_MAP, True),
        ("it", "Ivy", False),
        ("the bakery", NOT_ON_MAP, False),
        ("the bakery", "Ivy", False),
    ],
)
def test_a_ground_without_id_is_right_by_its_words(phrase, ground, right):
    one = line(gold("east", None, kind="elementary schools"))
    text = "east of a primary school, it lies by the bakery"
    assert score_parser([one], parser=with_words(text, phrase, ground)).tuple_f1 == right


def test_the_head_of_a_kind_stands_before_of():
    one = line(gold("east", None, kind="corner of the block"))
    for phrase, right in (("corner", True), ("block", False)):
        parser = with_words("the corner of a block", phrase, "Ivy")
        assert score_parser([one], parser=parser).tuple_f1 == right


def test_of_an_unnamed_kind_one_right_candidate_is_enough():
    one = line(gold("east", "Ivy", kind="bar", also=("Rumor",)))
    named = line(gold("east", "Ivy", also=("Rumor",)))
    parser = with_words("a bar", "a bar", "Spirits", "Spirits", "Rumor")
    assert score_parser([one], parser=parser).tuple_f1 == 1
    assert score_parser([named], parser=parser).tuple_f1 == 0


def test_places_that_are_not_on_the_map_are_told_apart_by_their_words():
    text = "east of a school and of a park"
    grounds = [(text.index(w), text.index(w) + len(w)) for w in ("a school", "a park")]

    def parser(given, city, targets):
        relations = [
            SpatialRelation(
                FIGURE, "east", (NOT_ON_MAP,), spans=RelationSpans((0, 1), (0, 1), (span,))
            )
            for span in grounds
        ]
        return Description(text, city.name, (), tuple(relations))

    one = line(gold("east", None, kind="park"), gold("east", None, kind="school"))
    assert score_parser([one], parser=parser).tuple_f1 == 1


def test_a_denied_kind_takes_all_its_places():
    one = line(gold("near", "Ivy", kind="bar", also=("Rumor", "Spirits"), negated=True))
    every = said("near", "Ivy", "Rumor", "Spirits", negated=True, each=True)
    assert score(one, every).polarity_f1 == 1
    assert score(one, replace(every, each=False)).precision == round(1 / 3, 6)


def test_linking_recall_counts_places_in_whatever_relation():
    one = line(
        gold("near", "Ivy"),
        gold("at", "Rumor", also=("Spirits",)),
        gold("in", "HoytBlock"),
        gold("behind", "CortBuilding"),
        gold("on", "West6thSt", optional=True),
        gold("north", None, kind="school"),
    )
    bars = ((Candidate("Ivy", 0.6), Candidate("Spirits", 0.4)),)
    found = score(
        one,
        said("south", "Ivy", candidates=bars),
        unresolved=(Unresolved("hoyt", (0, 1), ("HoytBlock",)),),
    )
    assert found.linking_recall == 0.75
    assert score(line()).linking_recall == 1


def test_phenomena_are_counted_apart():
    lines = [
        line(gold("near"), name="one", phenomena=("lists", "hedges")),
        line(gold("near"), gold("at", "Rumor"), name="two", phenomena=("lists",)),
        line(gold("near"), name="three"),
    ]
    found = score(lines, said("near"), said("in", "HoytBlock"))
    assert found.phenomena == {
        "hedges": {"n": 1, "wholly_right": 0, "f1": round(2 / 3, 6), "false_positives": 1},
        "lists": {"n": 2, "wholly_right": 0, "f1": round(4 / 7, 6), "false_positives": 2},
    }
    assert (found.wholly_right, found.false_positives) == (0, 3)


def test_lines_without_gold_are_counted_and_not_scored():
    lines = [line(gold("near")), line(name="two", has_gold=False)]
    found = score(lines, said("near"))
    assert (found.n, found.not_scored, found.tuple_f1) == (1, 1, 1)
    with pytest.raises(
        InputError, match=r"^No description says what is to be read in it; expected"
    ):
        score(lines[1:])


def test_classes_of_grounds_are_told_apart():
    one = line(
        gold("near", ground_class="named"),
        gold("at", "Rumor", ground_class="named"),
        gold("north", "Hearer", ground_class="hearer"),
        gold("in", "HoytBlock", ground_class="other", optional=True),
    )
    found = score(one, said("near"), said("in", "HoytBlock"), said("south", "Ivy"))
    assert found.classes == {
        "hearer": {"n": 1, "read_right": 0},
        "named": {"n": 2, "read_right": 0.5},
        "all": {"n": 3, "read_right": 0.333333, "wrong_among_read": 0.333333},
    }
    assert score(one).classes["all"]["wrong_among_read"] == 0
    assert "classes" not in score(line(gold("near"))).to_json()


def test_parts_are_scored_where_the_gold_gives_them():
    north, northeast = (StreetPart("side", math.radians(a)) for a in (90, 45))
    one = line(
        gold("near", part=north),
        gold("at", "Rumor", part=StreetPart("number", number=12)),
        gold("in", "HoytBlock"),
    )
    right = said("near", part=StreetPart("side", math.radians(80)))
    found = score(one, right, said("at", "Rumor"), said("in", "HoytBlock", part=north))
    assert (found.tuple_f1, found.wholly_right) == (1, 1)  # parts move no other score
    assert found.parts == {
        "side": {"n": 1, "read_right": 1},
        "number": {"n": 1, "read_right": 0},
        "all": {"n": 2, "read_right": 0.5},
    }
    for wrong in (northeast, StreetPart("side"), StreetPart("end", math.pi / 2), None):
        assert score(one, said("near", part=wrong)).parts["side"]["read_right"] == 0
    assert score(line(gold("near", part=StreetPart("side"))), right).parts["all"]["read_right"] == 0
    assert score(one).parts["all"] == {"n": 2, "read_right": 0}
    assert "parts" not in score(line(gold("near")), right).to_json()


def test_confidence_is_judged_relation_by_relation():
    one = line(gold("near"), gold("between", "Ivy", group=0), gold("between", "Rumor", group=0))
    relations = [
        said("near", confidence=0.9),
        said("between", "Ivy", "Rumor", confidence=0.8),
        said("between", "Ivy", "Spirits", confidence=0.3),
    ]
    found = score(one, *relations, confidence=True, rng=np.random.default_rng(0)).confidence
    assert (found.n, found.right, found.auc) == (3, pytest.approx(2 / 3), 1)
    told = score(one, *relations, confidence=True, rng=np.random.default_rng(0)).to_json()
    assert told["confidence"]["n"] == 3
    with pytest.raises(InputError, match=r"^Intervals are drawn at random and no rng was given"):
        score(one, *relations, confidence=True)
