"""The tree of our packages, and Python run on it from another folder."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOTS = {
    "sloop_ppl": ROOT / "sloop_ppl",
    "sloop_ppl.models": ROOT / "models",
    "sloop_ppl.inference": ROOT / "inference",
    "sloop_ppl.eval": ROOT / "eval",
}


def package_names():
    """Return the name of every folder of ours that holds an ``__init__.py``."""
    return sorted(
        ".".join([name, *path.parent.relative_to(folder).parts])
        for name, folder in ROOTS.items()
        for path in folder.rglob("__init__.py")
    )


def module_names():
    """Return the name of every module and package of ours."""
    names = set()
    for name, folder in ROOTS.items():
        for path in folder.rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            names.add(".".join([name, *(parts[:-1] if parts[-1] == "__init__" else parts)]))
    return sorted(names)


def run_python(code, cwd, *arguments, site=None):
    """Run Python code in a fresh process from another folder and return what it prints."""
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    if site is not None:
        env["PYTHONPATH"] = str(site)
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=cwd,
        env=env,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
