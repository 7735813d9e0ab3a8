"""What errors say, and what they can be caught as."""

import pytest

from sloop_ppl import errors
from sloop_ppl.errors import (
    BeliefCollapse,
    MapError,
    OutputError,
    SloopError,
    UnknownName,
    nearest_names,
)


@pytest.mark.parametrize(
    "name", [n for n in errors.__all__ if n not in ("SloopError", "nearest_names", "on_one_line")]
)
def test_every_error_is_of_the_family_and_of_a_built_in(name):
    kind = getattr(errors, name)
    assert issubclass(kind, SloopError)
    assert issubclass(kind, OSError if kind is OutputError else ValueError)


def test_an_unknown_name_lists_what_there_is_and_guesses():
    error = UnknownName("relation", "behnd", ["front", "behind"])
    assert str(error) == (
        "Relation 'behnd' is unknown; expected one of front, behind; did you mean 'behind'?"
    )
    assert (error.kind, error.found, error.expected) == ("relation", "behnd", ("front", "behind"))


def test_it_does_not_guess_at_random():
    assert str(UnknownName("model", "xyz", ["sloop", "bayes"])) == (
        "Model 'xyz' is unknown; expected one of sloop, bayes"
    )
    assert str(UnknownName("model", "xyz", [])) == "Model 'xyz' is unknown; expected one of nothing"


def test_of_many_names_the_nearest_are_told():
    names = [f"Building{i}" for i in range(300)]
    assert str(UnknownName("landmark", "Bilding12", names)) == (
        "Landmark 'Bilding12' is unknown; expected one of 300 names; did you mean 'Building12'?"
    )
    assert str(UnknownName("landmark", "?", names)) == (
        "Landmark '?' is unknown; expected one of 300 names, such as Building0, Building1, "
        "Building10"
    )


def test_nearest_names_ignore_case_and_keep_spelling():
    known = ["HoytBlock", "StoneBlock", "VelvetDog"]
    assert nearest_names("hoytblock", known)[0] == "HoytBlock"
    assert nearest_names("velvet dog", known) == ["VelvetDog"]
    assert nearest_names("zzz", known) == []


def test_errors_carry_what_they_are_about():
    error = MapError("text", feature="Hall", field="kind")
    assert (error.feature, error.field) == ("Hall", "kind")
    collapse = BeliefCollapse("text", prior=1, observation=2)
    assert (collapse.prior, collapse.observation) == (1, 2)
