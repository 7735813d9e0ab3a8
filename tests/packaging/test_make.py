"""The Makefile and the CI script, without running what they would run."""

import os
import shutil
import stat
import subprocess

import pytest
from support.tree import ROOT

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


def planned(*arguments):
    """Return the commands that make would run, one a line, were nothing made yet."""
    env = {
        k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS", "VENV", "LOCK"))
    }
    done = subprocess.run(
        ["make", "--dry-run", "--always-make", *arguments],
        cwd=ROOT, env=env, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.replace("\\\n", "").splitlines()


def position(commands, *words):
    """Return where the one command that holds all the words stands."""
    (found,) = [i for i, c in enumerate(commands) if all(w in c for w in words)]
    return found


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("demo", ("sloop demo", "--out out")),
        ("test", ("-m pytest",)),
        ("check", ("mypy", "--strict", "-p sloop_ppl", "cd build/check/site")),
        ("check", ("ruff format --check",)),
        ("check", ("codespell",)),
        ("docs", ("-m mkdocs build",)),
        ("tutorials", ("docs/site_tools/tutorials.py",)),
        ("gallery", ("examples/gallery.py", "--out docs")),
    ],
)
def test_a_target_first_makes_the_environment(target, words):
    commands = planned(target)
    made = position(commands, "-m venv .venv")
    torch = position(commands, "pip install", "torch==2.13.0")
    ours = position(commands, "pip install", "--editable", ".[dev]")
    assert made < torch < ours < position(commands, *words)


def test_options_for_torch_go_to_its_own_call_only():
    commands = planned("venv", "TORCH_PIP_OPTIONS=--find-links=here", "TORCH=torch==2.6.0")
    (found,) = [c for c in commands if "--find-links=here" in c]
    assert '"torch==2.6.0"' in found
    assert "[dev]" not in found


def test_another_interpreter_and_another_place_may_be_named():
    commands = planned("test", "PYTHON=python3.12", "VENV=elsewhere")
    assert "python3.12 -m venv elsewhere" in commands
    assert not [c for c in commands if ".venv" in c]


def test_every_target_is_in_the_help_at_the_top():
    lines = (ROOT / "Makefile").read_text().splitlines()
    (phony,) = [line for line in lines if line.startswith(".PHONY: ")]
    head = "\n".join(line for line in lines[: lines.index("")] if line.startswith("#"))
    assert [name for name in phony.split()[1:] if f"make {name} " not in head] == []


def test_the_default_is_the_demo():
    assert planned() == planned("demo")


def test_ci_can_be_run():
    script = ROOT / ".ci" / "run"
    assert script.stat().st_mode & stat.S_IXUSR
    lines = script.read_text().splitlines()
    assert "set -euo pipefail" in lines
    assert [line for line in lines if line.startswith("make ")] == [
        "make venv", "make check", "make demo", "make graphics", "make test-web",
        'make test PYTEST_OPTIONS="-n auto --dist loadgroup --ignore=tests/web"',
    ]  # fmt: skip


def test_the_lock_is_installed_between_torch_and_ours_where_one_is_named():
    commands = planned("venv", "LOCK=requirements.lock")
    torch = position(commands, "pip install", "torch==2.13.0")
    lock = position(commands, "--require-hashes", "--no-deps", "requirements.lock")
    assert torch < lock < position(commands, "pip install", "--editable", ".[dev]")
    assert not [c for c in planned("venv") if "--require-hashes" in c]
    assert "export LOCK=requirements.lock" in (ROOT / ".ci" / "run").read_text()
