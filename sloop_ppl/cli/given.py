"""Which options were typed, and which of them say nothing."""

from __future__ import annotations

import typer

__all__ = ["as_typed", "given", "unused_options"]


def given(context: typer.Context) -> list[str]:
    """Return the names of the parameters that were typed."""
    return [n for n in context.params if str(context.get_parameter_source(n)).endswith("LINE")]


def as_typed(name: str) -> str:
    """Return how a parameter is typed."""
    return "TEXT" if name == "text" else f"--{name.strip('_').replace('_', '-')}"


def unused_options(context: typer.Context, planner: str) -> list[str]:
    """Return a line for each option that was typed although the planner does not use it."""
    from sloop_ppl.planning.planners import NOT_SIMULATING

    if planner not in NOT_SIMULATING:
        return []
    return [
        f"note: planner '{planner}' runs no simulations, so {as_typed(name)} is not used"
        for name in given(context)
        if name in ("sims", "rollout")
    ]
