"""`sloop parse --html`, `sloop eval parse` and `sloop eval quality`."""

from __future__ import annotations

import json
import math

import pytest

from sloop_ppl.cli import main
from sloop_ppl.language import parse
from sloop_ppl.maps import load_map

LINE = {
    "id": "a",
    "map": "cleveland",
    "text": "The red bike is near Ivy",
    "relations": [{"figure": "RedBike", "relation": "near", "ground": "Ivy"}],
}


def run(capsys, code, *arguments):
    with pytest.raises(SystemExit) as done:
        main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    assert done.value.code == code, err
    return out, err


def test_parse_writes_a_page(capsys, tmp_path):
    page = tmp_path / "said.html"
    out, _ = run(capsys, 0, "parse", LINE["text"], "--map", "cleveland", "--html", page)
    assert out.startswith(LINE["text"])
    assert "<td>Ivy</td>" in page.read_text()


def test_eval_parse_prints_the_agreed_keys(capsys, tmp_path):
    file = tmp_path / "said.jsonl"
    file.write_text(json.dumps(LINE))
    out, _ = run(capsys, 0, "eval", "parse", file, "--json")
    told = json.loads(out)
    assert list(told) == [
        "n", "tuple_f1", "class_f1", "pair_f1", "precision", "recall", "per_relation",
        "polarity_f1", "linking_recall", "wholly_right", "false_positives", "not_scored",
        "statuses", "phenomena",
    ]  # fmt: skip
    assert told["tuple_f1"] == 1.0
    words = ("--merge-maps", "--misspell", "0.15", "--seed", "0")
    out, _ = run(capsys, 0, "eval", "parse", file, *words)
    assert "1 descriptions: tuple F1" in out


def test_eval_parse_judges_confidence_and_tells_misses(capsys, tmp_path):
    file = tmp_path / "said.jsonl"
    wrong = {**LINE, "id": "b", "text": "The red bike is near Rumor"}
    file.write_text(f"{json.dumps(LINE)}\n{json.dumps(wrong)}")
    out, _ = run(capsys, 0, "eval", "parse", file, "--misses", "--confidence")
    assert "  missed  RedBike near Ivy\n  wrong   RedBike near Rumor\n" in out
    assert "confidence of 2 relations, 0.500 of them right" in out
    out, _ = run(capsys, 0, "eval", "parse", file, "--confidence", "--json")
    assert list(json.loads(out)["confidence"]) == [
        "n", "right", "slope", "slope_ci95", "brier", "brier_constant", "auc", "bins",
    ]  # fmt: skip


def test_eval_quality_without_gold_scores_what_is_read(capsys, tmp_path):
    place = {"RedBike": {"east_m": 2.5, "north_m": 2.5}}
    line = {"id": "a", "map": "cleveland", "text": LINE["text"], "targets": place}
    file = tmp_path / "said.jsonl"
    file.write_text(json.dumps(line))
    words = ("eval", "quality", file, "--models", "uniform")
    out, _ = run(capsys, 0, *words, "--parsed", "--json")
    assert json.loads(out)["models"]["uniform"]["n"] == 1
    _, err = run(capsys, 2, *words)
    assert err == (
        "sloop: No description has gold 'relations'; score what the parser reads with --parsed\n"
    )
    both = [line, {**line, "id": "b", "relations": []}]
    file.write_text("\n".join(map(json.dumps, both)))
    _, err = run(capsys, 0, *words)
    assert err.splitlines()[0] == "1 lines without gold relations passed over"


def test_eval_quality_prints_the_agreed_keys(capsys, tmp_path):
    place = {"GreenToyota": {"east_m": 2.5, "north_m": 2.5}}
    relation = {"figure": "GreenToyota", "relation": "near", "ground": "Ivy"}
    text = "The green Toyota is near Ivy"
    line = {"id": "a", "map": "cleveland", "text": text, "targets": place, "relations": [relation]}
    file = tmp_path / "said.jsonl"
    file.write_text(json.dumps(line))
    told = {}
    for mode in ("gold", "parsed"):
        words = ("eval", "quality", file, "--models", "bayes,uniform", f"--{mode}", "--json")
        out, err = run(capsys, 0, *words)
        told[mode] = json.loads(out)
        assert told[mode]["relations"] == mode
        assert list(told[mode]["models"]["bayes"])[:7] == [
            "n", "mean_log_score", "ci95", "median_rank", "expected_distance_m", "mass_15m",
            "hpd90_coverage",
        ]  # fmt: skip
        assert list(told[mode]["paired"]) == ["bayes-uniform"]
        assert err.splitlines() == ["bayes: 1 targets scored", "uniform: 1 targets scored"]
    gold, parsed = (told[mode]["models"] for mode in ("gold", "parsed"))
    assert gold["uniform"] == parsed["uniform"]
    # Near takes no frame, so what was read is right with p, and says nothing with 1 - p.
    p = parse(text, load_map("cleveland")).readings[0].probability
    log_score, log_nothing = (gold[name]["mean_log_score"] for name in ("bayes", "uniform"))
    mixed = math.log(p * math.exp(log_score) + (1 - p) * math.exp(log_nothing))
    assert parsed["bayes"]["mean_log_score"] == pytest.approx(mixed, abs=1e-4)
    out, _ = run(capsys, 0, "eval", "quality", file, "--models", "bayes,uniform")
    assert "bayes-uniform" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("parse", "x", "--map", "cleveland", "--html", "a.png"), "Output 'a.png' ends in '.png'"),
        (("parse", "x", "--map", "cleveland", "--nlp", "nope"), "The spaCy pipeline 'nope' cannot"),
        (("eval", "quality", "x.jsonl", "--models", "bays"), "Model 'bays' is unknown"),
        (("eval", "parse"), "Missing argument 'files'"),
        (("eval", "parse", "nowhere.jsonl"), "Description file 'nowhere.jsonl' cannot be read"),
    ],
)
def test_mistakes_are_one_line(capsys, arguments, message):
    _, err = run(capsys, 2, *arguments)
    assert message in err
    assert err.count("\n") == 1
