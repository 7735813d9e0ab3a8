"""What a path of poses shows, one pose after another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.planning.compile import jit
from sloop_ppl.planning.ground import Ground

__all__ = ["sightings"]


@jit
def sightings(
    ground: Ground,
    left: NDArray[np.float64],
    hit: float,
    poses: NDArray[np.int32],
    seen: NDArray[np.float64],
) -> None:
    """Fill in how many targets each pose is expected to be the first to show.

    Parameters
    ----------
    ground : the map.
    left : expected number of targets by cell of the bordered map; what is seen is taken off it.
    hit : probability of detecting what is in view.
    poses : the path.
    seen : all zeros; filled in, shape (poses,).
    """
    for i in range(len(poses)):
        pose = poses[i]
        home, heading = ground.home[pose], pose & 7
        for k in range(ground.sizes[heading]):
            if len(ground.hidden) > 0 and ground.hidden[pose, k]:
                continue
            cell = home + ground.fans[heading, k]
            seen[i] += hit * left[cell]
            left[cell] *= 1.0 - hit
