"""Refitted models are kept, and made anew when anything they depend on changed."""

from dataclasses import replace

import pytest

from sloop_ppl.eval import _fits as fits
from sloop_ppl.eval import bundled_examples
from sloop_ppl.maps import load_map
from sloop_ppl.models import preset


@pytest.fixture
def asked(monkeypatch):
    calls = []

    def refitted(descriptions, model, find_map, *, progress=None):
        calls.append(model.name)
        return {annotated.map: replace(model, lapse=0.25) for annotated in descriptions}

    monkeypatch.setattr(fits, "refitted", refitted)
    monkeypatch.setattr(fits, "git_state", lambda: "abc")
    return calls


def test_what_is_kept_is_not_made_again(asked, tmp_path):
    descriptions, models = bundled_examples(), {"bayes": preset("bayes")}
    kept, told = tmp_path / "fits.pkl", []

    def ask(descriptions=descriptions, models=models):
        return fits.cross_validated(descriptions, models, load_map, kept=kept, progress=told.append)

    first = ask()
    assert first["bayes"]["austin"].lapse == 0.25
    assert ask() == first
    assert asked == ["bayes"]
    assert told == [f"fits taken from {kept}"]
    ask(models={"bayes": replace(preset("bayes"), temper=0.5)})
    assert asked == ["bayes"] * 2
    ask(descriptions=descriptions[1:])
    assert asked == ["bayes"] * 3
    kept.write_bytes(b"something else")
    assert ask() == first
    assert asked == ["bayes"] * 4


def test_nothing_is_kept_unless_asked(asked, tmp_path):
    models = {"bayes": preset("bayes")}
    for _ in range(2):
        fits.cross_validated(bundled_examples(), models, load_map)
    assert asked == ["bayes"] * 2
