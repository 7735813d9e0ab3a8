"""The planner ``fast``, and compiling all that it runs before it is needed."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from sloop_ppl.planning._search_kernel import NativeSearch
from sloop_ppl.planning._tree_kernel import grow
from sloop_ppl.planning.belief import GridBelief
from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.native_pouct import NativePouct
from sloop_ppl.planning.path_search import PathSearch, RunningPathSearch
from sloop_ppl.planning.planners import RunningPlanner, overridden
from sloop_ppl.planning.space import SearchSpace
from sloop_ppl.planning.values import SearchObservation

__all__ = ["Fast", "WarmUp", "warm_up"]


@dataclass(frozen=True)
class Fast:
    """Plan in machine code: `PathSearch`, or `NativePouct` where a rollout is asked for.

    A sensor that sees no mask is neither's: then ``pomdp_py.POUCT`` plans, and the notes of
    `PlanInfo` say so.

    Parameters
    ----------
    sims, depth, exploration, discount, rollout, hedge, tree_depth
        As in `SearchConfig`, whose values count where None is given.
    """

    sims: int | None = None
    depth: int | None = None
    exploration: float | None = None
    discount: float | None = None
    rollout: str | None = None
    hedge: float | None = None
    tree_depth: int | None = None

    name = "fast"

    def settings(self, config: SearchConfig) -> SearchConfig:
        """Return the settings of the search with the planner's own in their places."""
        return overridden(config, self)

    def begin(self, space: SearchSpace, *, rng: np.random.Generator) -> RunningPlanner:
        """Return a planner for one search; simulations draw from `rng`."""
        if space.config.rollout in (None, "informed"):
            return PathSearch().begin(space, rng=rng)
        return NativePouct().begin(space, rng=rng)


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
    # A small search with every kind of array: buildings make `blocked` and `around` non-empty.
    tall = np.zeros((9, 9), dtype=bool)
    tall[4, 4] = True
    space = SearchSpace((9, 9), ("T",), SearchConfig(sims=50, no_fly=True), tall)
    belief = GridBelief(space, {"T": np.ones((9, 9))}, space.robot(0), rng=np.random.default_rng(0))
    agent: Any = SimpleNamespace(belief=belief, history=())
    # numba compiles for types, and these are the same for all maps and settings.
    searching = RunningPathSearch(space)
    searching.plan(agent)
    searching.path_return(belief, 1.0)
    planner = NativePouct(NativeSearch(space), sims=50, rng=np.random.default_rng(0))
    planner.plan(agent)
    planner.update(agent, space.moves[1], SearchObservation((-1,), 0))
    untyped: Any = grow
    folder = untyped.stats.cache_path
    return WarmUp(time.perf_counter() - begun, Path(folder) if folder else None)
