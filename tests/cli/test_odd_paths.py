"""Paths that can be nothing are refused in one line; what editors add to files is passed over."""

from __future__ import annotations

import json

import pytest

from sloop_ppl.cli import main
from tests.cli.test_bad_input import SEARCH, refused

LONG = "x" * 300
LINE = {
    "id": "one", "map": "cleveland", "text": "The red bike is near the Ivy.",
    "targets": {"RedBike": {"east_m": 10.0, "north_m": 5.0}},
    "relations": [{"figure": "RedBike", "relation": "near", "ground": "Ivy"}],
}  # fmt: skip


@pytest.fixture
def lines(tmp_path):
    path = tmp_path / "said.jsonl"
    path.write_text(json.dumps(LINE) + "\n")
    return path


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["eval", "quality", "LINES", "--maps", LONG], "is no folder"),
        (["eval", "quality", "LINES", "--models", "bayes", "--cv", "city", "--fits", LONG],
         "File name too long"),
        (["eval", "frames", "--maps", LONG], "is no folder"),
        (["frames", "train", "--maps", LONG, "--out", "w.safetensors"], "is no folder"),
        (["map", "import", "a.osm", "--all", "--out", f"{LONG}.geojson"], "File name too long"),
        ([*SEARCH, "--answers", LONG], "are no file"),
    ],
    ids=lambda value: " ".join(value[:2]) if isinstance(value, list) else "",
)  # fmt: skip
def test_names_that_can_be_no_file(command, said, capsys, lines, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = [str(lines) if word == "LINES" else word for word in command]
    assert said in refused(capsys, command)


def test_a_link_to_itself(capsys, tmp_path):
    link = tmp_path / "a.jsonl"
    link.symlink_to(link)
    for command in (
        ["eval", "quality", link],
        ["eval", "quality", link, "--learn-from", link],
        ["infer", "the red bike is near the ivy", "--map", "cleveland", "--targets", link],
    ):
        assert "Too many levels of symbolic links" in refused(capsys, command)


def test_an_episode_with_a_byte_order_mark_is_drawn(capsys, tmp_path):
    episode = tmp_path / "e.json"
    start = [*SEARCH, "--planner", "greedy", "--out", str(episode)]
    with pytest.raises(SystemExit) as stopped:
        main(start)
    assert stopped.value.code == 0
    episode.write_bytes(b"\xef\xbb\xbf" + episode.read_bytes())
    capsys.readouterr()
    with pytest.raises(SystemExit) as stopped:
        main(["search", "--replay", str(episode), "--json"])
    assert stopped.value.code == 0
    assert json.loads(capsys.readouterr().out)["map"] == "cleveland"
