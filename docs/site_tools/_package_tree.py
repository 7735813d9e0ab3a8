"""The package as one folder of links: models, inference and eval lie beside it."""

from __future__ import annotations

import shutil
from pathlib import Path

__all__ = ["link_package"]

ROOMS = ("models", "inference", "eval")


def link_package(root: Path, tree: Path) -> None:
    """Make ``tree/sloop_ppl`` of links, for tools that read sources without importing them.

    Parameters
    ----------
    root
        The repository.
    tree
        Where the package is laid out; what is there is removed.
    """
    shutil.rmtree(tree, ignore_errors=True)
    package = tree / "sloop_ppl"
    package.mkdir(parents=True)
    for child in sorted((root / "sloop_ppl").iterdir()):
        if child.name not in ("__pycache__", "data"):
            (package / child.name).symlink_to(child)
    for room in ROOMS:
        (package / room).symlink_to(root / room)
