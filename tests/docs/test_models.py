"""The picture of docs/models.md shows what the page says."""

import importlib.util
from pathlib import Path

import sloop_ppl as sloop

ROOT = Path(__file__).parents[2]


def test_one_sentence_under_three_models(tmp_path):
    path = ROOT / "examples" / "paper_code_ours.py"
    spec = importlib.util.spec_from_file_location("example_paper_code_ours", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    beliefs = example.main(tmp_path / "a.png")
    text, code, ours = beliefs.values()
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert 0.5 * abs(text - code).sum() > 0.2
    assert 0.5 * abs(ours - code).sum() > 0.2
    said = sloop.parse(example.TEXT, city := sloop.load_map("cleveland"))
    turned = sloop.parse(example.TEXT.replace("behind", "in front of"), city)
    apart = {
        name: 0.5
        * abs(beliefs[name] - sloop.infer(turned, city, model).belief("GreenToyota")).sum()
        for name, model in example.MODELS.items()
    }
    assert apart["the paper's text"] < 1e-9
    assert min(apart["its published code"], apart["ours (bayes)"]) > 0.1
    assert said.relations != turned.relations
