"""What can be listed: the names that cost nothing are those of the registries."""

from importlib import import_module

import pytest

from sloop_ppl.bridge._catalogue import CATALOGUE, names_of
from sloop_ppl.errors import UnknownName
from sloop_ppl.inference import ENGINES, Exact
from sloop_ppl.registry import Registry


def names(module, name):
    found = getattr(import_module(module), name)
    return list(found() if callable(found) else found)


@pytest.mark.parametrize("what", CATALOGUE)
def test_the_names_are_those_of_the_registry(what):
    listed = CATALOGUE[what]
    assert names(*listed.names) == names(*listed.registry) == names_of(what)


def test_what_a_user_adds_is_listed(monkeypatch):
    registry = Registry("engine")
    for name, engine in ENGINES.items():
        registry.add(name, engine)
    registry.add("mine", Exact())
    monkeypatch.setattr("sloop_ppl.inference.engines.ENGINES", registry)
    assert names_of("engines") == [*ENGINES, "mine"]


def test_what_cannot_be_listed_is_refused():
    with pytest.raises(UnknownName, match="List 'colours' is unknown; expected one of models, "):
        names_of("colours")
