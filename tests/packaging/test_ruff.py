"""Ruff refuses the bare names of the top-level folders."""

import json
import subprocess
import sys

import pytest
from support.tree import ROOT


def banned(code):
    """Return the lines of `code` in which ruff, as the project sets it, finds a banned import."""
    done = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "--select", "TID251", "--output-format", "json",
         "--stdin-filename", str(ROOT / "models" / "example.py"), "-"],
        input=code, cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return [fault["location"]["row"] for fault in json.loads(done.stdout)]


@pytest.mark.parametrize("folder", ["models", "inference", "eval"])
def test_bare_imports_are_banned(folder):
    assert banned(f"import {folder}\nfrom {folder} import x\nfrom {folder}.y import z\n") == [
        1, 2, 3,
    ]  # fmt: skip


@pytest.mark.parametrize("folder", ["models", "inference", "eval"])
def test_the_full_names_are_allowed(folder):
    assert banned(f"import sloop_ppl.{folder}\nfrom sloop_ppl.{folder}.y import z\n") == []
