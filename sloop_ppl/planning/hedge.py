"""Allow for beliefs that are less sure than they should be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["hedged"]

_SQUARINGS = 3
"""The sharper belief is the belief to the power of 2 to this, which is 8."""


def hedged(table: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Return a belief, a share of which is replaced by the same belief made sharper.

    Parameters
    ----------
    table : belief over cells, >= 0, summing to one; any shape.
    share : how much is replaced, in [0, 1]; 0 returns the belief as it is.

    Returns
    -------
    numpy.ndarray
        Belief over cells, summing to one, shape as `table`. A uniform belief is left as it is, and
        no two cells change their order.

    Notes
    -----
    Not in the paper. A path that takes a belief at its word looks at the slopes on its way to the
    peak; where targets lie nearer to the peaks than the belief says, that is a loss.
    """
    if share == 0.0:
        return table
    sharper = table / table.max()
    for _ in range(_SQUARINGS):
        sharper *= sharper
    mixed: NDArray[np.float64] = (1.0 - share) * table + (share / sharper.sum()) * sharper
    return mixed
