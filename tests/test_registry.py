"""Looking things up by name."""

import sys

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


@pytest.fixture
def later(tmp_path, monkeypatch):
    """A registry whose second entry lies in a module that is not imported yet."""
    (tmp_path / "registry_home.py").write_text("THREE = 3\n")
    monkeypatch.syspath_prepend(tmp_path)
    registry = Registry("model")
    registry.add("sloop", 1)
    registry.add_later("mine", "registry_home", "THREE")
    registry.add("bayes", 2)
    yield registry
    sys.modules.pop("registry_home", None)


def test_an_entry_may_be_loaded_when_it_is_looked_up(later):
    assert (list(later), len(later), "mine" in later) == (["sloop", "mine", "bayes"], 3, True)
    with pytest.raises(UnknownName, match="expected one of sloop, mine, bayes"):
        later["yours"]
    with pytest.raises(ValueError, match=r"^model 'mine' is registered already; choose another"):
        later.add("mine", 4)
    assert "registry_home" not in sys.modules
    assert dict(later) == {"sloop": 1, "mine": 3, "bayes": 2}
    assert list(later) == ["sloop", "mine", "bayes"]


def test_a_name_is_announced_once(later):
    with pytest.raises(ValueError, match=r"^model 'bayes' is registered already; choose another"):
        later.add_later("bayes", "registry_home", "THREE")


def test_an_entry_can_be_taken_out_and_put_in_anew(models):
    before, changes = list(models), models.changes
    entry = models.remove(before[0])
    assert list(models) == before[1:]
    assert models.add(before[0], entry) is entry
    assert list(models) == [*before[1:], before[0]]
    assert models.changes == changes + 2
    with pytest.raises(UnknownName):
        models.remove("nothing of the kind")
