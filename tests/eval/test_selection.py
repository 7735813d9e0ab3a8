import json
from dataclasses import replace

import pytest
import torch

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import _selection as selection
from sloop_ppl.eval import bundled_examples
from sloop_ppl.eval._candidates import CANDIDATES, FAMILIES
from sloop_ppl.eval._fit_files import candidates_named, fit_files
from sloop_ppl.eval._selection import NESTED, select_model
from sloop_ppl.inference.learning import Fitted
from sloop_ppl.models import BAYES, UNFITTED_BAYES, preset, unfitted

MAPS = ("austin", "cleveland", "denver")


@pytest.fixture
def descriptions():
    chosen = [s for s in bundled_examples() if s.map in MAPS]
    return [next(s for s in chosen if s.map == name) for name in MAPS]


@pytest.fixture
def told(monkeypatch):
    """Scores by (candidate, maps fitted to, map scored), and a fit that only notes its maps."""
    scores = {}

    def note(examples, model, **_):
        used = frozenset(example.city.name for example in examples)
        fitted = Fitted(
            model.name, {}, provenance={"mean_log_score_after": 0.0, "moved": {}, "used": used}
        )
        object.__setattr__(fitted, "apply", lambda own: replace(own, name=(own.name, used)))
        return fitted

    def score(examples, model):
        candidate, used = model.name
        (city,) = {example.city.name for example in examples}
        assert city not in used, "scored on what it was fitted to"
        number = len([t for example in examples for t in example.cells])
        return torch.full((number,), scores[candidate, used, city])

    monkeypatch.setattr(selection, "fit", note)
    monkeypatch.setattr(selection, "log_scores", score)
    monkeypatch.setattr(selection, "score_beliefs", lambda _scenes, models, *_, **__: models)
    return scores


def test_the_choice_never_sees_the_map_it_is_scored_on(descriptions, told):
    a, b = replace(preset("sloop-m4"), name="a"), replace(preset("sloop-m4"), name="b")
    for left_out in MAPS:
        rest = frozenset(MAPS) - {left_out}
        # With all but one map b is far better; inside the folds a is.
        told["a", rest, left_out], told["b", rest, left_out] = -9.0, -1.0
        for scored in rest:
            told["a", rest - {scored}, scored] = -1.0
            told["b", rest - {scored}, scored] = -2.0
    found = select_model(descriptions, {"a": a, "b": b})
    assert found.chosen == dict.fromkeys(MAPS, "a")
    assert found.winner == "b"
    assert found.fitted.provenance["used"] == frozenset(MAPS)
    for left_out in MAPS:
        assert found.inner[left_out] == pytest.approx({"a": -1.0, "b": -2.0})
        assert found.quality[NESTED][left_out].name == ("a", frozenset(MAPS) - {left_out})
        assert found.quality["b"][left_out].name == ("b", frozenset(MAPS) - {left_out})


def test_a_choice_takes_three_maps(descriptions):
    two = {name: CANDIDATES[name] for name in FAMILIES[:2]}
    with pytest.raises(InputError, match="2 models to fit and descriptions of 2 maps; expected"):
        select_model(descriptions[:2], two)


def test_the_fit_of_bayes_starts_where_no_map_was_seen():
    assert unfitted(BAYES) is UNFITTED_BAYES
    assert candidates_named("bayes")["bayes"] is UNFITTED_BAYES
    other = replace(BAYES, lapse=0.3)
    assert unfitted(other) is other
    for model in candidates_named(None).values():
        assert (model.lapse, model.temper) == (UNFITTED_BAYES.lapse, UNFITTED_BAYES.temper)


def test_candidates_are_named_once_and_known():
    with pytest.raises(InputError, match="name one twice"):
        candidates_named("bayes,bayes")
    with pytest.raises(UnknownName, match="'bayess' is unknown"):
        candidates_named("bayess")


def test_what_was_fitted_says_how(tmp_path, monkeypatch):
    from sloop_ppl.eval import _fit_files as files_module

    lines = [s for s in bundled_examples() if s.map in MAPS[:2]]
    kept = [next(s for s in lines if s.map == name) for name in MAPS[:2]]
    monkeypatch.setattr(files_module, "read_descriptions", lambda *_: kept)
    source = tmp_path / "said.jsonl"
    source.write_text("{}\n")
    out = tmp_path / "numbers.json"
    found, fitted = fit_files([source], out=out, models="student-vonmises")
    kept_numbers = json.loads(out.read_text())
    assert kept_numbers["parameters"] == fitted.parameters
    told = kept_numbers["provenance"]
    assert told["selection"]["winner"] == found.winner == "student-vonmises"
    assert set(told["descriptions"]) == {"said.jsonl"}
    sections = fitted.parameters.items()
    names = {f"weights:{n}" if section == "weights" else n for section, s in sections for n in s}
    assert set(told["moved"]) == names
    # One candidate: what the folds choose is that candidate.
    scores = told["selection"]["left_out"]
    assert scores[NESTED] == scores["student-vonmises"]
    # Nothing said in two descriptions tells of "across": its number stays in the middle.
    assert told["moved"]["across_m"] == pytest.approx(0.0, abs=1e-3)


def test_nothing_is_fitted_for_an_ending_that_cannot_be_written(tmp_path):
    with pytest.raises(Exception, match=r"\.json"):
        fit_files([tmp_path / "none.jsonl"], out=tmp_path / "numbers.toml")
