"""Draw which way all buildings of a map are taken to face."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl.maps import CityMap
from sloop_ppl.plots._axes import new_axes
from sloop_ppl.plots._palette import ACCENTS, INK, MUTED
from sloop_ppl.plots._protocols import DistributionLike
from sloop_ppl.plots.city import draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_frames"]

_BINS = 180
_SMOOTH_KAPPA = 120.0  # five degrees, so that a sharp front is a petal and not a line
_LEAST_M, _MOST_M = 0.03, 0.07  # radius of a rose, in sides of the map


def plot_frames(
    city: CityMap, frames: Mapping[str, DistributionLike], *, ax: Axes | None = None
) -> Axes:
    """Draw a small rose on each landmark: how probable it is that it faces each direction.

    Parameters
    ----------
    city
        The map.
    frames
        Landmark id -> distribution of its front.
    ax
        Axes to draw on; a new pyplot figure when None.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in metres. The area of a petal is its probability within its rose, blurred by
        five degrees; the radius of a rose grows with its landmark.

    Raises
    ------
    UnknownName
        When a landmark is not on the map.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    axes = new_axes(ax)
    draw_map(axes, city, labels=False, muted=True)
    axes.set_facecolor(MUTED.ground)
    side = city.grid.east_m - city.grid.west_m
    angles = 2 * np.pi * np.arange(_BINS) / _BINS
    blur = np.exp(_SMOOTH_KAPPA * (np.cos(angles[:, None] - angles) - 1))
    blur /= blur.sum(0)
    for name, frame in frames.items():
        x, y = city.centroid(name)
        west, south, east, north = city.footprint(name).bounds
        reach = min(max(0.6 * max(east - west, north - south), _LEAST_M * side), _MOST_M * side)
        radius = np.sqrt(blur @ frame.binned(_BINS))
        radius *= reach / max(radius.max(), 1e-12)
        outline = np.column_stack([
            x + radius * np.cos(angles),
            y + radius * np.sin(angles),
        ])  # fmt: skip
        axes.add_patch(
            PathPatch(
                Path(outline, closed=False),
                facecolor=ACCENTS["frame"],
                edgecolor=INK,
                linewidth=0.4,
                alpha=0.85,
                zorder=4.0,
                gid="front",
            )
        )
    return axes
