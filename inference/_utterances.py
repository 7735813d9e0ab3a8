"""What would be said of a target, as far as is known where it is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.language import TargetObject
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel
from sloop_ppl.models.simulation import SPEAKER, Simulated, simulate
from sloop_ppl.rng import child

__all__ = ["utterances_about"]


def utterances_about(
    target: str | TargetObject,
    belief: NDArray[np.float64],
    city: CityMap,
    n: int,
    *,
    rng: np.random.Generator,
    speaker: str | ObservationModel = SPEAKER,
    phrases: int | tuple[int, int] = 1,
    grounds: Sequence[str] | None = None,
) -> tuple[Simulated, ...]:
    """Draw descriptions from the posterior predictive of a target.

    Parameters
    ----------
    target
        The object, or its id.
    belief
        Where it is believed to be, shape (H, W).
    n
        How many, > 0.
    rng
        Where places and words are drawn from; each description has a stream of its own.
    speaker
        A model's name, or an ObservationModel, as a speaker; see `sloop_ppl.models.speaker_of`.
    phrases
        Phrases of each: a number, or the least and the most.
    grounds
        Ids of the landmarks that may be spoken of; those with a name when None.

    Returns
    -------
    tuple of Simulated
        Descriptions with the place each was drawn for.

    Raises
    ------
    InputError
        When `n` is not positive, or the speaker cannot be run forward.

    Notes
    -----
    The cell is drawn from the belief; component, fronts and slips anew from the speaker's priors,
    since they belong to a description and not to the target.
    """
    if n < 1:
        raise InputError(f"n is {n}; expected at least one utterance")
    return tuple(
        simulate(
            city,
            [target],
            child(rng, "utterance", i),
            model=speaker,
            phrases=phrases,
            grounds=grounds,
            prior=belief,
        )
        for i in range(n)
    )
