"""requirements.lock holds what pyproject.toml asks for, with hashes and nothing of one machine."""

from __future__ import annotations

import re
import tomllib

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from support.tree import ROOT

LOCK = (ROOT / "requirements.lock").read_text()
ENTRIES = re.split(r"\n(?=\S)", LOCK[LOCK.index("\n", LOCK.rindex("# ")) + 1 :].strip())
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
ASKED = [*PYPROJECT["dependencies"], *PYPROJECT["optional-dependencies"]["dev"]]


def pinned():
    found = {}
    for entry in ENTRIES:
        name, version = re.match(r"(\S+)==(\S+)", entry).groups()
        found[canonicalize_name(name)] = version
    return found


@pytest.mark.parametrize("asked", [one for one in ASKED if Requirement(one).name != "torch"])
def test_every_dependency_is_locked_at_a_version_that_it_allows(asked):
    requirement = Requirement(asked)
    version = pinned().get(canonicalize_name(requirement.name))
    assert version is not None, f"{asked}: run make lock"
    assert requirement.specifier.contains(version), f"{asked}: {version} is locked; run make lock"


def test_each_has_hashes_and_nothing_else():
    assert len(ENTRIES) == len(pinned()) > 100
    for entry in ENTRIES:
        lines = entry.replace("\\\n", "\n").split("\n")
        assert re.fullmatch(r"\S+==\S+( ; .*)?", lines[0].strip()), entry
        assert len(lines) > 1
        assert all(re.fullmatch(r"\s+--hash=sha256:[0-9a-f]{64}\s*", line) for line in lines[1:])


def test_pytorch_is_left_to_who_chooses_its_build():
    assert not [name for name in pinned() if re.match("torch$|triton|nvidia|cuda", name)]
