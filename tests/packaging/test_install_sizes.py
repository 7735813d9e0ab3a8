"""The table of what an install brings names each dependency, with its reason."""

from __future__ import annotations

import importlib.util
import re
import tomllib

from support.tree import ROOT

_SPEC = importlib.util.spec_from_file_location(
    "install_sizes", ROOT / "tests" / "tools" / "install_sizes.py"
)
sizes = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(sizes)
ASKED = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
PAGE = (ROOT / "docs" / "installing.md").read_text(encoding="utf-8")


def test_each_dependency_has_a_reason():
    assert set(sizes.REASONS) == {sizes.name_of(one) for one in ASKED}


def test_the_page_lists_each_with_its_reason():
    rows = dict(re.findall(r"^\| ([\w-]+) \| \d+ \| .*? \| (.+) \|$", PAGE, re.MULTILINE))
    rows.pop("sloop-ppl", None)
    assert {name: rows.get(name) for name in sizes.REASONS} == sizes.REASONS


def test_what_a_distribution_brings_has_no_extras():
    brought = sizes.closure("rich")
    assert set(brought) == {"rich", "markdown-it-py", "mdurl", "pygments"}


def test_every_extra_is_described():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    told = set(re.findall(r"`(\w+)`", PAGE.split("| extra |")[1].split("\n\n")[0]))
    assert set(extras["optional-dependencies"]) - {"dev", "mutants"} <= told
