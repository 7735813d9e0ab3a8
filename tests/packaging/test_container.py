"""The Containerfile copies what the wheel needs, and runs commands that there are."""

from __future__ import annotations

import re

from support.tree import ROOT, ROOTS

LINES = (ROOT / "Containerfile").read_text(encoding="utf-8").splitlines()


def test_it_copies_what_the_wheel_is_built_of():
    copied = {
        name
        for line in LINES
        if line.startswith("COPY ") and "--from" not in line
        for name in line.split()[1:-1]
    }
    assert copied == {"pyproject.toml", "README.md", "LICENSE", *(p.name for p in ROOTS.values())}
    kept = (ROOT / ".dockerignore").read_text().splitlines()
    assert {line.removeprefix("!") for line in kept if line.startswith("!")} == copied


def test_it_takes_the_pytorch_of_the_makefile_and_no_cuda():
    (torch,) = re.findall(r"^TORCH \?= (\S+)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert f"ARG TORCH={torch}" in LINES
    assert any("torch.version.cuda is None" in line for line in LINES)


def test_it_is_debian_slim_and_runs_as_a_user():
    assert [line for line in LINES if line.startswith("FROM ")] == [
        "FROM debian:bookworm-slim AS build",
        "FROM debian:bookworm-slim",
    ]
    assert "USER sloop" in LINES
    assert 'ENTRYPOINT ["sloop"]' in LINES


def test_it_names_no_package_index():
    assert not [line for line in LINES if "http" in line]
