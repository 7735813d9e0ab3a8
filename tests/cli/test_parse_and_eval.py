"""`sloop parse --html` and `sloop eval parse`."""

from __future__ import annotations

import json

import pytest

from sloop_ppl.cli import main

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
    ]  # fmt: skip
    assert told["tuple_f1"] == 1.0
    words = ("--merge-maps", "--misspell", "0.15", "--seed", "0")
    out, _ = run(capsys, 0, "eval", "parse", file, *words)
    assert "1 descriptions: tuple F1" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("parse", "x", "--map", "cleveland", "--html", "a.png"), "Output 'a.png' ends in '.png'"),
        (("parse", "x", "--map", "cleveland", "--nlp", "nope"), "The spaCy pipeline 'nope' cannot"),
        (("eval", "parse"), "Missing argument 'files'"),
        (("eval", "parse", "nowhere.jsonl"), "Description file 'nowhere.jsonl' cannot be read"),
    ],
)
def test_mistakes_are_one_line(capsys, arguments, message):
    _, err = run(capsys, 2, *arguments)
    assert message in err
    assert err.count("\n") == 1
