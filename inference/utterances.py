"""What would be said of a target, as far as is known where it is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.models import Preset
from sloop_ppl.models.simulate import SPEAKER, Simulated, simulate
from sloop_ppl.rng import child

if TYPE_CHECKING:
    from sloop_ppl.inference.posterior import Posterior

__all__ = ["utterances_about"]


def utterances_about(
    posterior: Posterior,
    target: str,
    n: int,
    *,
    rng: np.random.Generator,
    speaker: Preset = SPEAKER,
    phrases: int | tuple[int, int] = 1,
    grounds: Sequence[str] | None = None,
) -> tuple[Simulated, ...]:
    """Draw descriptions from the posterior predictive of a target.

    Parameters
    ----------
    posterior : where it is believed to be.
    target : id of the target.
    n : how many, > 0.
    rng : where places and words are drawn from; each description has a stream of its own.
    speaker : a model with ``speaker`` normalisation.
    phrases : phrases of each: a number, or the least and the most.
    grounds : ids of the landmarks that may be spoken of; those with a name when None.

    Returns
    -------
    tuple of Simulated
        Descriptions with the place each was drawn for.

    Raises
    ------
    InputError : when `n` is not positive, or the speaker cannot be run forward.

    Notes
    -----
    The cell is drawn from the belief; component, fronts and slips anew from the speaker's priors,
    since they belong to a description and not to the target.
    """
    if n < 1:
        raise InputError(f"n is {n}; expected at least one utterance")
    belief = posterior.belief(target)
    known = {t.id: t for d in posterior.descriptions for t in d.targets}
    return tuple(
        simulate(
            posterior.city,
            [known.get(target, target)],
            child(rng, "utterance", i),
            model=speaker,
            phrases=phrases,
            grounds=grounds,
            prior=belief,
        )
        for i in range(n)
    )
