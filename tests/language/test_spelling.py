import pytest

from sloop_ppl.language.spelling import mend, split_run_ons
from sloop_ppl.language.words import split_words


@pytest.mark.parametrize(
    ("slip", "word"),
    [("betwen", "between"), ("behidn", "behind"), ("conrer", "corner"), ("nrth", "north")],
)
def test_slips_in_closed_words_are_mended(slip, word):
    assert mend(slip) == word


@pytest.mark.parametrize("word", ["light", "alone", "sout", "7th", "xylophone", "bik"])
def test_words_that_are_no_clear_slip_stay(word):
    assert mend(word) in (word, "south")
    assert mend("light") == "light"


def test_words_run_together_are_cut_with_their_places():
    words = split_run_ons(split_words("theredbike isbehind velvetdog"), {"velvet", "dog"})
    assert [w.low for w in words] == ["the", "red", "bike", "is", "behind", "velvet", "dog"]
    assert [(w.start, w.end) for w in words][-2:] == [(20, 26), (26, 29)]


def test_ordinary_words_are_not_cut():
    words = split_run_ons(split_words("notice another office information"), set())
    assert [w.low for w in words] == ["notice", "another", "office", "information"]
