from dataclasses import replace

import pytest

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval import bundled_examples, crossval
from sloop_ppl.eval._quality_files import score_quality
from sloop_ppl.eval.crossval import refitted
from sloop_ppl.models import preset


@pytest.fixture
def descriptions():
    chosen = [s for s in bundled_examples() if s.map in ("austin", "cleveland")]
    return [s for s in chosen if s.id.endswith(("01", "02"))]


def test_a_city_is_left_out_of_its_own_fit(descriptions, monkeypatch):
    seen = []

    def spy(examples, model, **options):
        seen.append({example.city.name for example in examples})
        return real(examples, model, **{**options, "learn": ["lapse"]})

    real = crossval.fit
    monkeypatch.setattr(crossval, "fit", spy)
    model = replace(preset("bayes"), lapse=0.1)
    found = refitted(descriptions, model, iterations=5)
    assert seen == [{"cleveland"}, {"austin"}]
    assert list(found) == ["austin", "cleveland"]
    assert found["austin"].lapse != found["cleveland"].lapse


def test_one_city_cannot_be_left_out(descriptions):
    with pytest.raises(InputError, match=r"are of one map \(austin\); expected at least two"):
        refitted([s for s in descriptions if s.map == "austin"], preset("bayes"))


def test_an_unknown_fold_is_refused(tmp_path):
    with pytest.raises(UnknownName, match="'street' is unknown; expected one of city"):
        score_quality([tmp_path / "none.jsonl"], cv="street")
