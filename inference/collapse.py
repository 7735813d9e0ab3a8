"""Notice that a target has nowhere left to be, and name what excludes it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import BeliefCollapse

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["check_possible"]


def check_possible(
    posterior: Posterior, observation: object, before: Posterior | None = None
) -> Posterior:
    """Return a posterior unless some target has nowhere left to be.

    Parameters
    ----------
    posterior : what is believed now.
    observation : what was said or sensed last.
    before : what was believed before that; None when nothing was known but the prior.

    Raises
    ------
    BeliefCollapse : when no cell of a target is possible; it names what excludes them.
    """
    for target in posterior.targets:
        if posterior._coupling.possible(target):
            continue
        culprits = _culprits(posterior, target)
        told = "; ".join(culprits)
        raise BeliefCollapse(
            f"Nothing that was believed about '{target}' is possible after this observation: "
            f"{told}, with no cell in common; check it, or start from a prior without zeros",
            prior=posterior.log_prior[target] if before is None else before.belief(target),
            observation=observation,
            culprits=culprits,
        )
    return posterior


def _culprits(posterior: Posterior, target: str) -> tuple[str, ...]:
    """Return what excludes cells of a target, with the number each leaves."""
    weighed: list[tuple[str, NDArray[np.float64]]] = [
        ("its prior", posterior.log_prior[target]),
        ("what was sensed", posterior.log_sensed[target]),
    ]
    for said in posterior.said[target]:
        phrases = [f"{term.relation} {' and '.join(term.grounds)}" for term in said.terms]
        weighed.append((f"'{', '.join(phrases)}'", said.log_factor.max((0, 1))))
    left = [(name, int(np.isfinite(table).sum()), table.size) for name, table in weighed]
    return tuple(f"{name} leaves {n} of {size} cells" for name, n, size in left if n < size)
