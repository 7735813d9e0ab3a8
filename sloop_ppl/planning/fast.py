"""The planner ``fast``: POUCT in machine code, or the path search, by the rollout asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sloop_ppl.planning.config import SearchConfig
from sloop_ppl.planning.native_pouct import NativePouct
from sloop_ppl.planning.path_search import PathSearch
from sloop_ppl.planning.planners import RunningPlanner, overridden
from sloop_ppl.planning.space import SearchSpace

__all__ = ["Fast"]


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
