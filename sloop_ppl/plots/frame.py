"""Draw which way landmarks face, as roses on the landmarks themselves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.plots._axes import new_axes, set_title
from sloop_ppl.plots._marks import add_legend
from sloop_ppl.plots._palette import ACCENTS, INK, MUTED, PAPER
from sloop_ppl.plots._protocols import DistributionLike, FrameLike
from sloop_ppl.plots.city import display_name, draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["frame_bins", "plot_frame", "plot_frames"]

Bins = NDArray[np.float64]
# A spread of 1 / sqrt(500), 2.6 degrees, half a bin of 72.
_EXACT_KAPPA = 500.0


def frame_bins(frames: Sequence[FrameLike], bins: int = 72) -> Bins:
    """Return the probability of each of B equal directions under a mixture of von Mises parts.

    Parameters
    ----------
    frames
        Parts of the mixture, weighed by their ``p``; what is missing to one is uniform. An exact
        direction counts as one of concentration 500.
    bins
        B; the first is centred on east, and they go anticlockwise.

    Returns
    -------
    numpy.ndarray
        Probabilities, shape (B,), sum one.
    """
    angles = 2 * math.pi * np.arange(bins) / bins
    total = np.zeros(bins)
    for frame in frames:
        kappa = _EXACT_KAPPA if frame.kappa is None else frame.kappa
        # von Mises density without its constant, which the sum over bins replaces.
        part = np.exp(kappa * (np.cos(angles - frame.mean_rad) - 1.0))
        total += frame.p * part / part.sum()
    rest = max(0.0, 1.0 - float(sum(f.p for f in frames)))
    total += rest / bins
    whole: Bins = total / total.sum()
    return whole


def plot_frame(
    city: CityMap,
    ground: str,
    posterior: Bins | Sequence[FrameLike],
    *,
    prior: Bins | Sequence[FrameLike] | None = None,
    ax: Axes | None = None,
    legend: bool = True,
    title: str | None = None,
) -> Axes:
    """Draw the distribution of a landmark's front as a rose round its centroid.

    Parameters
    ----------
    city
        The map.
    ground
        Id of the landmark.
    posterior
        Probabilities of B equal directions, the first centred on east, anticlockwise, shape (B,);
        or frames, which :func:`frame_bins` turns into such.
    prior
        The same before anything was said, drawn as an outline; None to leave it out.
    ax
        Axes to draw on; a new pyplot figure when None.
    legend
        True to add a legend.
    title
        Title of the axes; says whose front it is when None.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in metres, limits round the landmark. The area of a petal is its probability.

    Raises
    ------
    UnknownName
        When the landmark is not on the map.
    InputError
        When probabilities are negative, not finite or all zero.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch, PathPatch
    from matplotlib.path import Path

    after = _checked(posterior, "posterior")
    before = None if prior is None else _checked(prior, "prior")
    landmark = city.landmark(ground)
    axes = new_axes(ax, width=4.6, height=4.9)
    x, y = city.centroid(ground)
    west, south, east, north = city.footprint(ground).bounds
    # A little beyond the footprint, and not less than 12 % of the map, to see a small one.
    reach = max(
        0.62 * max(east - west, north - south), 0.12 * (city.grid.east_m - city.grid.west_m)
    )
    radius = 0.92 * reach
    half = 1.3 * reach
    view = (x - half, y - half, x + half, y + half)
    layer = draw_map(axes, city, highlight=[ground], muted=True, view_m=view)
    axes.set_facecolor(MUTED.ground)
    densities = [d * len(d) for d in (after, before) if d is not None]
    top = max(float(np.sqrt(d).max()) for d in densities)
    colour = ACCENTS["frame"]
    for turn in np.linspace(0.25, 1.0, 4):
        axes.add_patch(_ring(x, y, turn * radius))
    handles: list[Any] = []
    # The area of a sector grows with the square of its radius, so the radius is sqrt(probability).
    petals = Path(_petals(x, y, radius * np.sqrt(after * len(after)) / top))
    axes.add_patch(
        PathPatch(petals, facecolor=colour, alpha=0.75, edgecolor=INK, linewidth=0.5, zorder=4.0)
    )
    handles.append(Patch(facecolor=colour, alpha=0.75, edgecolor=INK, lw=0.5, label="posterior"))
    if before is not None:
        outline = _petals(x, y, radius * np.sqrt(before * len(before)) / top)
        axes.plot(outline[:, 0], outline[:, 1], color=INK, lw=1.0, ls=(0, (2, 1.5)), zorder=4.2)
        handles.append(Line2D([], [], color=INK, lw=1.0, ls=(0, (2, 1.5)), label="prior"))
    axes.plot([x], [y], "o", ms=4, mfc=INK, mec=PAPER, mew=0.7, zorder=4.4)
    layer.avoid(points=[(x, y)])
    set_title(axes, title or f"Front of {display_name(landmark)}")
    if legend:
        add_legend(axes, handles, layer)
    return axes


def _checked(given: Bins | Sequence[FrameLike], what: str) -> Bins:
    listed: Any = list(given) if not isinstance(given, np.ndarray) else given
    if len(listed) and hasattr(listed[0], "mean_rad"):
        return frame_bins(listed)
    bins = np.asarray(listed, dtype=np.float64)
    if bins.ndim != 1 or not bins.size or not np.isfinite(bins).all() or (bins < 0).any():
        raise InputError(
            f"The {what} of the frame has shape {bins.shape}; expected probabilities of equal "
            "directions, finite and none negative, shape (B,)"
        )
    if not bins.sum() > 0:
        raise InputError(f"The {what} of the frame is zero everywhere; expected probabilities")
    whole: Bins = bins / bins.sum()
    return whole


def _ring(x: float, y: float, radius: float) -> Any:
    from matplotlib.patches import Circle

    return Circle((x, y), radius, facecolor="none", edgecolor=INK, lw=0.4, alpha=0.3, zorder=3.5)


def _petals(x: float, y: float, radii: Bins) -> NDArray[np.float64]:
    """Return the closed outline of sectors of these radii, each as wide as its bin."""
    count = len(radii)
    points: list[tuple[float, float]] = []
    for k, r in enumerate(radii):
        # Seven points an arc: round to the eye at 72 bins.
        arc = 2 * math.pi * (k + np.linspace(-0.5, 0.5, 7)) / count
        points += [(x + r * math.cos(a), y + r * math.sin(a)) for a in arc]
    return np.array([*points, points[0]])


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
    # Circular convolution with a von Mises kernel, columns summing to one, shape (bins, bins).
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
