"""A model whose likelihood was exchanged says what it has of `bayes`, and gives it back."""

from __future__ import annotations

from dataclasses import replace

import pytest

from sloop_ppl.cli import main
from sloop_ppl.models import (
    BAYES,
    LIKELIHOODS,
    PRESETS,
    UNFITTED_BAYES,
    borrowed,
    fitting_note,
    preset,
    unfitted,
)
from sloop_ppl.models.tuning import with_parameters
from sloop_ppl.models.user import load_model
from tests.support.example_lines import write_examples

ALL = ("lapse", "own_lapse", "temper", "kappa", "absolute", "weights")
MINE = "def fading(term, direction_rad):\n    return -term.off_m / 20\n"
SET = """
[model]
lapse = 0.05
own_lapse = 0.05
temper = 0.2
[frames]
kappa = 5.0
absolute = 0.7
[weights]
product = 0.9
"""


@pytest.fixture
def mine(tmp_path):
    (tmp_path / "mine.py").write_text(
        "import torch\n" + MINE.replace("    return ", "    rows = ") + "    return rows if "
        "direction_rad is None else rows.expand(len(direction_rad), -1)\n"
    )
    (tmp_path / "all.toml").write_text(SET)
    return f"{tmp_path / 'mine.py'}:fading"


def test_registered_models_have_their_own():
    assert {borrowed(PRESETS[name]) for name in PRESETS} == {()}
    assert fitting_note(BAYES) is fitting_note(UNFITTED_BAYES) is None
    wider = with_parameters(BAYES, {"likelihood": {"near_m": 30.0}})
    assert borrowed(wider) == ()


def test_an_exchanged_likelihood_is_told_until_its_numbers_are_set(mine):
    for model in (
        load_model(mine),
        preset(replace(preset("bayes"), likelihood=LIKELIHOODS["gaussian-clipped"])),
    ):
        assert borrowed(model) == ALL
        some = with_parameters(
            model, {"model": {"lapse": 0.3, "own_lapse": 0.3}, "weights": {"product": 0.5}}
        )
        assert borrowed(some) == ("temper", "kappa", "absolute")
        assert fitting_note(some).startswith("note: temper, kappa and absolute of ")
        last = with_parameters(some, {"model": {"temper": 0.0}, "frames": {"kappa": 2.0}})
        assert fitting_note(last).startswith("note: absolute of ")
        assert fitting_note(with_parameters(last, {"frames": {"absolute": 0.5}})) is None
    assert "--models mine.py:fading --out" in fitting_note(load_model(mine))


def test_a_fit_of_it_starts_where_no_map_was_seen(mine):
    model = load_model(mine)
    start = unfitted(model)
    assert start == replace(UNFITTED_BAYES, name=model.name, likelihood=model.likelihood)
    set_by_hand = with_parameters(model, {"model": {"lapse": 0.3}})
    assert unfitted(set_by_hand).lapse == 0.3
    assert unfitted(start) is start


@pytest.mark.parametrize(
    "command",
    [
        ["infer", "the red bike is near ivy", "--map", "cleveland", "--model"],
        ["search", "the red bike is near ivy", "--map", "cleveland", "--planner", "greedy",
         "--steps", "2", "--model"],
    ],
    ids=lambda command: command[0],
)  # fmt: skip
def test_commands_say_it_once(command, mine, tmp_path, capsys):
    def notes(*more):
        with pytest.raises(SystemExit) as done:
            main([*command, mine, *more])
        out, err = capsys.readouterr()
        assert done.value.code in (0, None), err
        assert "note:" not in out
        return [line for line in err.splitlines() if line.startswith("note: ")]

    (line,) = notes()
    assert line == fitting_note(load_model(mine))
    assert notes("--params", str(tmp_path / "all.toml")) == []


def test_scores_say_it_too(mine, tmp_path):
    from sloop_ppl.eval._quality_files import score_quality

    said, told = write_examples(tmp_path / "said.jsonl", "austin-ex-04"), []
    score_quality([said], models=f"{mine},uniform", progress=told.append)
    assert [line for line in told if line.startswith("note: ")] == [fitting_note(load_model(mine))]
