"""What one description says of one target, weighed under a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.language import Description
from sloop_ppl.models import RelationTerm, SharedFrames

__all__ = ["Said"]


@dataclass(frozen=True, eq=False)
class Said:
    """What one description says of one target, weighed.

    Parameters
    ----------
    description : the description.
    components : names of the mixture's components, length K.
    log_factor : log of component weight times likelihood in each setting of the frames that the
        description shares between phrases, shape (C, K, S); C is 1 when none is shared.
    terms : the relations of the target, grounded.
    shared : the frames that are shared.
    """

    description: Description
    components: tuple[str, ...]
    log_factor: NDArray[np.float64]
    terms: tuple[RelationTerm, ...]
    shared: SharedFrames
