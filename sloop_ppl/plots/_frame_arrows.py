"""Draw which way a landmark is taken to face."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from sloop_ppl.maps import CityMap
from sloop_ppl.plots._axes import stroke
from sloop_ppl.plots._palette import ACCENTS, INK, PAPER
from sloop_ppl.plots._protocols import FrameLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["arrow_length_m", "circular_sd_rad", "draw_frames"]

_LEAST_P = 0.3  # less, and the front is more probably elsewhere
_ARROW = [
    (-1, 0.17), (0.2, 0.17), (0.2, 0.5), (1, 0), (0.2, -0.5), (0.2, -0.17), (-1, -0.17), (-1, 0.17),
]  # fmt: skip


def circular_sd_rad(kappa: float | None) -> float:
    """Return the spread of a von Mises direction, radians; 0 for an exact one, at most pi/2.

    Notes
    -----
    The circular standard deviation sqrt(-2 log(I1(kappa) / I0(kappa))).
    """
    if kappa is None:
        return 0.0
    from scipy.special import i0e, i1e

    # Scaled Bessel functions: I0 itself overflows above kappa = 700.
    resultant: float = float(i1e(kappa)) / float(i0e(kappa))
    if resultant <= 0:
        return math.pi / 2
    spread: float = math.sqrt(-2.0 * math.log(min(resultant, 1.0)))
    return min(spread, math.pi / 2)


def arrow_length_m(city: CityMap, ground: str) -> float:
    """Return how long an arrow is drawn on a landmark: about half its size, metres."""
    west, south, east, north = city.footprint(ground).bounds
    side = city.grid.east_m - city.grid.west_m
    longer: float = max(east - west, north - south)
    # Between 7 and 13 % of the side of the map: seen on a kiosk, not all over a mall.
    return min(max(0.55 * longer, 0.07 * side), 0.13 * side)


def draw_frames(
    ax: Axes, city: CityMap, frames: Sequence[FrameLike]
) -> tuple[list[Any], list[tuple[float, float]]]:
    """Draw an arrow from each ground to where its front is, with a fan one standard deviation wide.

    Parameters
    ----------
    frames
        Directions; those with a probability below 0.3 are left out, and those of who listens, who
        is no landmark; equal ones are drawn once.

    Returns
    -------
    tuple
        Handles for a legend and points along the arrows, which labels had better avoid.
    """
    from matplotlib.colors import to_rgb
    from matplotlib.lines import Line2D
    from matplotlib.patches import FancyArrowPatch, Wedge
    from matplotlib.path import Path
    from matplotlib.patheffects import withStroke

    colour = ACCENTS["frame"]
    drawn: set[tuple[str, int]] = set()
    points: list[tuple[float, float]] = []
    for frame in frames:
        key = frame.ground, round(math.degrees(frame.mean_rad)) % 360
        if frame.p < _LEAST_P or key in drawn or frame.ground not in city:
            continue
        drawn.add(key)
        x, y = city.centroid(frame.ground)
        length = arrow_length_m(city, frame.ground)
        dx, dy = math.cos(frame.mean_rad), math.sin(frame.mean_rad)
        spread = math.degrees(circular_sd_rad(frame.kappa))
        if spread > 0:
            middle = math.degrees(frame.mean_rad)
            fan = Wedge((x, y), 0.85 * length, middle - spread, middle + spread, zorder=3.6)
            fan.set(facecolor=colour, edgecolor="none", alpha=0.4)
            ax.add_artist(fan)
        ax.add_artist(
            FancyArrowPatch(
                (x, y),
                (x + length * dx, y + length * dy),
                arrowstyle="simple,head_length=0.75,head_width=0.75,tail_width=0.22",
                mutation_scale=13 * stroke(ax),
                shrinkA=0,
                shrinkB=0,
                linewidth=0.8 * stroke(ax),
                facecolor=(*to_rgb(colour), 0.3 + 0.7 * min(frame.p, 1.0)),
                edgecolor=INK,
                path_effects=[withStroke(linewidth=2.4 * stroke(ax), foreground=PAPER)],
                zorder=4.2,
                gid="frame-arrow",
            )
        )
        # Four points along the arrow, dense enough that no label fits between them.
        points += [(x + t * length * dx, y + t * length * dy) for t in (0.15, 0.4, 0.65, 0.9)]
    if not drawn:
        return [], []
    handle = Line2D(
        [], [], ls="none", marker=Path(_ARROW), ms=13.5 * stroke(ax), mfc=colour, mec=INK, mew=0.8,
        label="mean front of ground",
    )  # fmt: skip
    return [handle], points
