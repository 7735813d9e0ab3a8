import pytest
from hypothesis import given
from hypothesis import strategies as st

from sloop_ppl.language.words import split_words


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Hall.Red bike", ["hall", ".", "red", "bike"]),
        ("W. 6th St", ["w", ".", "6th", "st"]),
        ("50ft", ["50", "ft"]),
        ("isn’t", ["isn't"]),
        ("HatFactory", ["hat", "factory"]),
        ("Café", ["cafe"]),
        ("wait.....", ["wait", "."]),
        ("", []),
    ],
)
def test_words_of_small_texts(text, words):
    assert [w.low for w in split_words(text)] == words


@given(st.text())
def test_words_lie_in_order_and_leave_only_white_space_out(text):
    at = 0
    for word in split_words(text):
        assert text[at : word.start].strip() == ""
        assert at <= word.start < word.end <= len(text)
        at = word.end
    assert text[at:].strip() == ""


def test_a_million_commas_are_one_word():
    (word,) = split_words("," * 1_000_000)
    assert (word.start, word.end) == (0, 1_000_000)
