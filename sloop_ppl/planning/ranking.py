"""A heap of numbers in place, the highest score first; of equal scores the lower number."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import inlined

__all__ = ["lift_last", "sink_first"]


@inlined
def _above(score: NDArray[np.float64], a: int, b: int) -> bool:
    return bool(score[a] > score[b] or (score[a] == score[b] and a < b))


@inlined
def lift_last(heap: NDArray[np.int32], score: NDArray[np.float64], size: int) -> None:
    """Bring the last of the heap to its place."""
    place = size - 1
    item = heap[place]
    while place > 0:
        up = (place - 1) // 2
        if not _above(score, item, heap[up]):
            break
        heap[place] = heap[up]
        place = up
    heap[place] = item


@inlined
def sink_first(heap: NDArray[np.int32], score: NDArray[np.float64], size: int) -> None:
    """Take the first off the heap, which then has one less."""
    item = heap[size - 1]
    place, down, last = 0, 1, size - 1
    while down < last:
        if down + 1 < last and _above(score, heap[down + 1], heap[down]):
            down += 1
        if not _above(score, heap[down], item):
            break
        heap[place] = heap[down]
        place, down = down, 2 * down + 1
    heap[place] = item
