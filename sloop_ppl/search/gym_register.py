"""Register the Gymnasium environment; gymnasium calls this through an entry point."""

from __future__ import annotations

__all__ = ["ENVIRONMENT", "register"]

ENVIRONMENT = "sloop_ppl/Search-v0"
"""Id of the environment."""


def register() -> None:
    """Make ``gymnasium.make("sloop_ppl/Search-v0")`` work; doing it twice does no harm."""
    import gymnasium

    if ENVIRONMENT not in gymnasium.registry:
        gymnasium.register(ENVIRONMENT, entry_point="sloop_ppl.search.gym_env:SearchEnv")
