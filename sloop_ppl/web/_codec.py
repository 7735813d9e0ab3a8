"""Tables over cells as short texts: float16 with a scale, and bits."""

from __future__ import annotations

from base64 import b64encode
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["packed_bits", "packed_floats"]


def packed_floats(table: NDArray[np.float64]) -> dict[str, Any]:
    """Return a table of numbers of at least 0 as float16 shares of its greatest.

    Returns
    -------
    dict
        ``peak``, the greatest number, and ``f16``: little-endian float16, row by row from the
        south, in base64. A number of a millionth of the peak is off by less than 4 %.
    """
    peak = float(table.max())
    shares = (table / peak if peak > 0 else table).astype("<f2")
    return {"peak": peak, "f16": b64encode(shares.tobytes()).decode()}


def packed_bits(mask: NDArray[np.bool_]) -> str:
    """Return a mask as bits, row by row from the south, the first in the highest, in base64."""
    return b64encode(np.packbits(mask).tobytes()).decode()
