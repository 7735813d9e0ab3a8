"""What is in a set of descriptions."""

import json

import pytest
from support.small_sweeps import LINES, write_lines

from sloop_ppl.cli import main
from sloop_ppl.errors import InputError
from sloop_ppl.eval.describe import describe_set


def test_a_set_is_counted(capsys, tmp_path):
    third = LINES[1] | {"id": "three", "text": "hello", "relations": [], "speaker": "S"}
    file = write_lines(tmp_path / "said.jsonl", *LINES, third)
    with pytest.raises(SystemExit) as done:
        main(["eval", "describe", str(file), "--json"])
    assert done.value.code == 0
    told = json.loads(capsys.readouterr().out)
    counts = {k: v for k, v in told.items() if isinstance(v, int)}
    assert counts == {
        "descriptions": 3, "targets": 4, "configurations": 2, "speakers": 1,
        "targets_with_relation": 3, "targets_read": 3, "descriptions_read": 2,
        "good_frames": 0, "bad_frames": 1,
    }  # fmt: skip
    assert told["relations"] == {"near": 2, "behind": 1, "east": 1}
    assert told["relations_per_target"] == {"0": 1, "1": 2, "2": 1}
    assert told["descriptions_per_configuration"] == {"1": 1, "2": 1}
    assert told["targets_per_configuration"] == {"1": 1, "2": 1}
    with pytest.raises(SystemExit):
        main(["eval", "describe", str(file)])
    out = capsys.readouterr().out
    assert "configurations of objects" in out
    assert "██████" in out


def test_no_description():
    with pytest.raises(InputError, match="no description to describe; expected at least one"):
        describe_set([])
