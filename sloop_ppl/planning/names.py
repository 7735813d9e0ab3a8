"""Names of the planners, without the cost of importing them."""

from __future__ import annotations

from sloop_ppl.errors import UnknownName

__all__ = ["NOT_SIMULATING", "PLANNER_NAMES", "check_planner", "list_planners"]

PLANNER_NAMES = ("pouct", "pomcp", "fast", "greedy", "random")
"""Every planner, in the order in which they are listed."""

NOT_SIMULATING = ("greedy", "random")
"""Those that run no simulations, so that their number and their rollout say nothing."""


def list_planners() -> list[str]:
    """Return the names of the planners.

    Examples
    --------
    >>> "pouct" in list_planners()
    True
    """
    return list(PLANNER_NAMES)


def check_planner(name: str) -> None:
    """Refuse a name that no planner has.

    Raises
    ------
    UnknownName : when there is no such planner; the message lists them.
    """
    if name not in PLANNER_NAMES:
        raise UnknownName("planner", name, PLANNER_NAMES)
