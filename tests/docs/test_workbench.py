"""The Python of docs/workbench.md runs, and its pictures and commands are there."""

from __future__ import annotations

import re
import shlex

import pytest
from support.tree import ROOT
from typer.main import get_command

from sloop_ppl.cli.app import app

PAGE = (ROOT / "docs" / "workbench.md").read_text(encoding="utf-8")


def test_the_python_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(blocks) == 2
    exec(compile("\n".join(blocks), "workbench.md", "exec"), {})
    assert (tmp_path / "search.html").stat().st_size > 50_000


def test_every_picture_is_there():
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", PAGE)
    assert len(pictures) >= 6
    for picture in pictures:
        assert (ROOT / "docs" / picture).stat().st_size > 10_000


def commands():
    blocks = re.findall(r"```\n(.*?)```", PAGE, re.DOTALL)
    lines = [line.partition(" #")[0] for block in blocks for line in block.splitlines()]
    return [shlex.split(line) for line in lines if line.startswith("sloop ")]


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_every_option_of_a_command_is_known(words):
    command, rest = get_command(app), words[1:]
    while hasattr(command, "commands"):
        command, rest = command.commands[rest[0]], rest[1:]
    known = {name for parameter in command.params for name in parameter.opts}
    assert {word for word in rest if word.startswith("--")} <= known
