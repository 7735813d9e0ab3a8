"""Keep the tree of one decision and write it as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sloop_ppl.errors import InputError
from sloop_ppl.outputs import check_output, written_whole
from sloop_ppl.planning.planners import NOT_SIMULATING

if TYPE_CHECKING:
    from sloop_ppl.planning import Step

__all__ = ["TREE_DEPTH", "TreeKeeper", "check_tree"]

TREE_DEPTH = 3
"""Levels of a tree that are written, unless ``--set tree_depth=N`` asks for others."""


def check_tree(path: Path | None, step: int | None, planner: str) -> None:
    """Refuse what no tree can be written for, before the search.

    Parameters
    ----------
    path
        Where the tree goes; None when none is wanted.
    step
        Number of the decision, from 1; the last that was made with a tree when None.

    Raises
    ------
    InputError
        When the planner grows no tree, or the step makes no sense.
    OutputError
        When the file cannot be written.
    """
    if path is None:
        if step is not None:
            raise InputError("--tree-step says which tree; say where it goes with --tree FILE.json")
        return
    if planner in NOT_SIMULATING:
        raise InputError(
            f"Planner '{planner}' grows no tree; leave --tree out, or plan "
            "with fast, pouct or pomcp"
        )
    if step is not None and step < 1:
        raise InputError(f"Step {step} is given to --tree-step; expected at least 1, the first")
    check_output(path, (".json",))


class TreeKeeper:
    """The tree of one decision.

    Parameters
    ----------
    step
        Number of the decision, from 1; the last that was made with a tree when None.
    """

    def __init__(self, path: Path, step: int | None = None) -> None:
        self._path, self._step = path, step
        self._taken = 0
        self.kept: dict[str, Any] | None = None

    def keep(self, step: Step) -> None:
        """Keep the tree of a step, if it is the one that is wanted."""
        self._taken = step.index + 1
        if step.info.tree is None or self._step not in (None, self._taken):
            return
        self.kept = {
            "planner": step.info.planner,
            "step": self._taken,
            "action": step.action,
            "sims": step.info.sims,
            "tree": step.info.tree,
        }

    def write(self) -> None:
        """Write the tree.

        Raises
        ------
        InputError
            When the step that was wanted has none.
        """
        if self.kept is None:
            which = "No step" if self._step is None else f"Step {self._step}"
            raise InputError(
                f"{which} was decided by a tree, in {self._taken} steps; a find of what is seen "
                "needs none: give another --tree-step"
            )
        with written_whole(self._path) as path:
            path.write_text(json.dumps(self.kept, allow_nan=False) + "\n", encoding="utf-8")
