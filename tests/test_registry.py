"""Looking things up by name."""

import pytest

from sloop_ppl.errors import UnknownName
from sloop_ppl.registry import Registry


@pytest.fixture
def models():
    registry = Registry("model")
    registry.add("sloop", 1)
    registry.add("bayes", 2)
    return registry


def test_entries_keep_their_order(models):
    assert list(models) == ["sloop", "bayes"]
    assert (models["bayes"], len(models), "sloop" in models, "loop" in models) == (
        2,
        2,
        True,
        False,
    )


def test_an_unknown_name_is_told(models):
    with pytest.raises(UnknownName) as caught:
        models["bayse"]
    assert str(caught.value) == (
        "Model 'bayse' is unknown; expected one of sloop, bayes; did you mean 'bayes'?"
    )


def test_a_name_is_taken_once(models):
    with pytest.raises(ValueError, match=r"^model 'sloop' is registered already; choose another"):
        models.add("sloop", 3)
    assert models["sloop"] == 1
