"""`sloop ask`, `sloop infer --ask`, `sloop search --answers`: what they print and refuse."""

from __future__ import annotations

import io
import json

import pytest

from sloop_ppl.cli import main

TEXT = "the red bike is by the bar"


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main(list(arguments))
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def test_ask_prints_questions(capsys):
    code, out, _ = run(capsys, "ask", TEXT, "--map", "cleveland", "--n", "2", "--json")
    assert code == 0
    told = json.loads(out)
    assert list(told) == ["questions"]
    assert len(told["questions"]) == 2
    for question in told["questions"]:
        assert {"text", "about", "bits", "answers"} <= set(question)
        assert sum(a["p"] for a in question["answers"]) == pytest.approx(1)
    again = run(capsys, "ask", TEXT, "--map", "cleveland", "--n", "2", "--json")[1]
    assert again == out
    words = run(capsys, "ask", TEXT, "--map", "cleveland", "--kind", "referent")[1]
    assert "Which place do you mean by “bar”: " in words
    assert "settles, in bits: ground_" in words


def test_ask_goes_on_from_a_saved_posterior(capsys, tmp_path):
    path = str(tmp_path / "p.nc")
    run(capsys, "infer", TEXT, "--map", "cleveland", "--out", path)
    first = run(capsys, "ask", "--posterior", path, "--json")[1]
    assert first == run(capsys, "ask", TEXT, "--map", "cleveland", "--json")[1]


def test_a_dialogue_at_the_terminal(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("sys.stdin", io.StringIO("purple\nI don't know\nstop\n"))
    code, out, err = run(capsys, "infer", TEXT, "--map", "cleveland", "--ask", "--json")
    assert code == 0
    told = json.loads(out)
    assert [q["answer"] for q in told["questions"]] == ["I don't know"]
    assert "Answer 'purple' was not understood" in err
    assert "no more is asked: the person stopped" in err
    (tmp_path / "a.txt").write_text("no idea\nno idea\n")
    code, out, err = run(
        capsys, "infer", TEXT, "--map", "cleveland", "--ask", "--answers", str(tmp_path / "a.txt"),
        "--figure", str(tmp_path / "talk.png"),
    )  # fmt: skip
    assert code == 0
    assert (tmp_path / "talk.png").stat().st_size > 50_000


def test_a_search_that_asks_is_shown_and_replayed(capsys, tmp_path):
    episode, picture = str(tmp_path / "e.json"), tmp_path / "e.png"
    common = ["--map", "cleveland", "--place", "RedBike=12,30", "--start=-60,-60"]
    code, out, err = run(
        capsys, "search", TEXT, *common, "--answers", "simulated", "--questions", "2",
        "--question-cost", "5", "--answer-error", "0", "--explain", "--out", episode, "--json",
        "--sims", "100",
    )  # fmt: skip
    assert code == 0
    told = json.loads(out)
    assert told["questions"]
    assert {"step", "text", "answer"} <= set(told["questions"][0])
    assert "it was worth asking: " in err
    code, out, _ = run(
        capsys, "search", "--replay", episode, "--figure", str(picture), "--json",
        "--animation", str(tmp_path / "e.gif"),
    )  # fmt: skip
    assert json.loads(out)["questions"] == told["questions"]
    assert picture.stat().st_size > 50_000
    line = run(capsys, "search", "--replay", episode)[1]
    assert f"asked {len(told['questions'])} (cost " in line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ask", TEXT], "Missing option '--map'"),
        (["ask", "--map", "cleveland"], "Missing argument 'TEXT'"),
        (["ask", TEXT, "--map", "cleveland", "--n", "0"], "n is 0; expected at least one question"),
        (["ask", TEXT, "--map", "cleveland", "--kind", "smell"],
         "Kind of question 'smell' is unknown"),
        (["ask", TEXT, "--map", "cleveland", "--answer-error", "1"], "error of the answerer is 1"),
        (["search", TEXT, "--map", "cleveland", "--answers", "nobody.txt"],
         "Answers 'nobody.txt' are no file; expected human, simulated, or a file of answers"),
        (["search", TEXT, "--map", "cleveland", "--questions", "2"],
         "--questions does not go with a search without --answers"),
        (["search", TEXT, "--map", "cleveland", "--answers", "human", "--question-cost", "-1"],
         "cost of a dialogue is -1.0; expected >= 0"),
        (["infer", TEXT, "--map", "cleveland", "--answers", "a.txt"],
         "--answers does not go without --ask"),
        (["eval", "search", "x.jsonl", "--out", "o", "--answerer", "z"],
         "Answerer 'z' is unknown; expected one of a, b, c"),
    ],
)  # fmt: skip
def test_mistakes(capsys, arguments, message):
    code, out, err = run(capsys, *arguments)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert message in err


def test_nothing_worth_asking(capsys):
    code, out, err = run(
        capsys, "ask", TEXT, "--map", "cleveland", "--kind", "inside", "--answer-error", "0.5",
        "--json",
    )  # fmt: skip
    assert code == 0
    assert json.loads(out) == {"questions": []}
    assert "nothing is worth asking" in err
