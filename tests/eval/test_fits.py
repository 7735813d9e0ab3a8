"""Refitted models are kept, and made anew when anything they depend on changed."""

import json
import pickle
from dataclasses import replace

import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.eval import _fits as fits
from sloop_ppl.eval import bundled_examples
from sloop_ppl.inference.learning import Fitted
from sloop_ppl.maps import load_map
from sloop_ppl.models import preset


@pytest.fixture
def asked(monkeypatch):
    calls = []

    def refits(descriptions, model, find_map, *, progress=None):
        calls.append(model.name)
        numbers = {"model": {"lapse": 0.25 + 1e-17, "temper": 1 / 3}}
        return {annotated.map: Fitted(model.name, numbers) for annotated in descriptions}

    monkeypatch.setattr(fits, "refits", refits)
    monkeypatch.setattr(fits, "git_state", lambda: "abc")
    return calls


def test_what_is_kept_is_not_made_again(asked, tmp_path):
    descriptions, models = bundled_examples(), {"bayes": preset("bayes")}
    kept, told = tmp_path / "fits.json", []

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


def test_nothing_is_kept_unless_asked(asked, tmp_path):
    models = {"bayes": preset("bayes")}
    for _ in range(2):
        fits.cross_validated(bundled_examples(), models, load_map)
    assert asked == ["bayes"] * 2


class _Bomb:
    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return type(self.path).touch, (self.path,)


@pytest.mark.parametrize("change", ["pickle", "text", "number", "model", "map", "nan", "deep"])
def test_what_is_no_file_of_fits_is_refused_and_runs_nothing(asked, tmp_path, change):
    kept, ran = tmp_path / "fits.json", tmp_path / "ran"

    def ask():
        return fits.cross_validated(bundled_examples(), models, load_map, kept=kept)

    models = {"bayes": preset("bayes")}
    ask()
    record = json.loads(kept.read_text("utf-8"))
    if change == "number":
        record["fits"]["bayes"]["austin"]["model"]["lapse"] = 7
    elif change == "nan":
        record["fits"]["bayes"]["austin"]["model"]["lapse"] = float("nan")
    elif change == "model":
        record["fits"] = {}
    elif change == "map":
        del record["fits"]["bayes"]["austin"]
    kept.write_text(json.dumps(record), "utf-8")
    if change == "pickle":
        kept.write_bytes(pickle.dumps(_Bomb(ran)))
    elif change in ("text", "deep"):
        kept.write_text("something else" if change == "text" else "[" * 100_000, "utf-8")
    with pytest.raises(InputError, match="fits") as caught:
        ask()
    assert str(kept) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert asked == ["bayes"]
    assert not ran.exists()
