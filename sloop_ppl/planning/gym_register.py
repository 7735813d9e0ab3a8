"""Register the Gymnasium environment when this module is imported.

So ``gymnasium.make("sloop_ppl.planning.gym_register:sloop_ppl/Search-v0")`` works by itself, and
``gymnasium.make("sloop_ppl/Search-v0")`` after an import of this module; an import of
`sloop_ppl.planning` does it too, where gymnasium was imported before.
"""

from __future__ import annotations

from gymnasium.envs import registration

__all__ = ["ENVIRONMENT", "register"]

ENVIRONMENT = "sloop_ppl/Search-v0"
"""Id of the environment."""


def register() -> None:
    """Register the environment; doing it twice does no harm."""
    if ENVIRONMENT not in registration.registry:
        registration.register(ENVIRONMENT, entry_point="sloop_ppl.planning.gym_env:SearchEnv")


register()
