"""Compile everything that the planner ``fast`` runs, before it is needed."""

from __future__ import annotations

import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from sloop_ppl.planning._search_kernel import NativeSearch
from sloop_ppl.planning._tree_kernel import grow
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.native_pouct import NativePouct
from sloop_ppl.planning.path_search import RunningPathSearch
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchObservation

__all__ = ["WarmUp", "warm_up"]


class WarmUp(NamedTuple):
    """What `warm_up` did.

    Attributes
    ----------
    seconds
        How long it took.
    folder
        Where the machine code is kept; None where no folder can be written, so that it is made
        anew in every process.
    """

    seconds: float
    folder: Path | None


def warm_up() -> WarmUp:
    """Compile every function of the planner ``fast``: the path search and both rollouts.

    Machine code that is kept already is only loaded. There is one version of each function,
    whatever the settings, the map and the number of targets.
    """
    begun = time.perf_counter()
    tall = np.zeros((9, 9), dtype=bool)
    tall[4, 4] = True
    space = SearchSpace((9, 9), ("T",), SearchConfig(sims=50, no_fly=True), tall)
    belief = GridBelief(space, {"T": np.ones((9, 9))}, space.robot(0), rng=np.random.default_rng(0))
    agent: Any = SimpleNamespace(belief=belief, history=())
    RunningPathSearch(space).plan(agent)
    planner = NativePouct(NativeSearch(space), sims=50, rng=np.random.default_rng(0))
    planner.plan(agent)
    planner.update(agent, space.moves[1], SearchObservation((-1,), 0))
    untyped: Any = grow
    folder = untyped.stats.cache_path
    return WarmUp(time.perf_counter() - begun, Path(folder) if folder else None)
