"""The colours in which AirSim's clients expect the objects of a segmentation, by their numbers."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

__all__ = ["MAX_OBJECTS", "object_colours"]

# The first values of a channel in the colour map of Cosys-AirSim's client, in its order.
_VALUES = (255, 127, 191, 95, 159, 223, 79, 110, 143, 175)

MAX_OBJECTS = len(_VALUES) ** 3
"""How many objects have a colour of their own."""


@cache
def object_colours() -> NDArray[np.uint8]:
    """Return red, green and blue of the first objects, shape (`MAX_OBJECTS`, 3).

    Notes
    -----
    The same as the head of ``simGetSegmentationColorMap()`` of the client, which is a file of 33 MB
    there: level n has all colours whose brightest new value is the n-th, in seven groups by which
    of the channels have it.
    """
    colours: list[tuple[int, ...]] = []
    for n, value in enumerate(_VALUES):
        for group in range(1, 8):
            channels = [(value,) if group & bit else _VALUES[:n] for bit in (4, 2, 1)]
            colours += product(*channels)
    return np.array(colours, dtype=np.uint8)
