"""Draw what a map knows of its streets: their axes, crossings and blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import shapely

from sloop_ppl.maps import Block, CityMap, StreetAxis, StreetNetwork, street_network
from sloop_ppl.plots._axes import font_pt, new_axes, stroke, width_in
from sloop_ppl.plots._ground import draw_shape
from sloop_ppl.plots._marks import add_legend
from sloop_ppl.plots._palette import ACCENTS, INK, PAPER, TARGET_COLOURS
from sloop_ppl.plots.city import draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.text import Text

    from sloop_ppl.plots._labels import Label

__all__ = ["plot_blocks"]

# A block's tint stops this far from the axes around it, so that neighbours stay apart, metres.
_INSET_M = 1.5
_TINT = 0.2


def plot_blocks(city: CityMap, ax: Axes | None = None) -> Axes:
    """Draw the axes of the streets of a map, their crossings, and the blocks between them.

    Parameters
    ----------
    city
        The map; one without streets is drawn as it is.
    ax
        Axes to draw on; a new pyplot figure when None.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in metres, north up. Neighbouring blocks have different tints and the number by
        which `block_table` calls them; a dashed axis bounds no block; a hollow mark is a crossing
        that is no corner, such as a place where a street changes its name.
    """
    axes = new_axes(ax)
    network = street_network(city)
    layer = draw_map(axes, city, labels=False, muted=True)
    for block, colour in zip(network.blocks, _tints(network.blocks), strict=True):
        inner = shapely.buffer(block.polygon, -_INSET_M)
        draw_shape(axes, inner, 2.0, colour, alpha=_TINT)
    window = shapely.box(*city.grid.extent_m)
    for axis in network.streets:
        if axis.named or axis.bounds_blocks:
            _draw_axis(axes, axis, window)
    _draw_crossings(axes, network)
    size_m = font_pt(width_in(axes)) / 72 / width_in(axes) * (window.bounds[2] - window.bounds[0])
    layer.labels = tuple(_labels(network, window, size_m))
    layer.avoid(*_number(axes, network.blocks, size_m))
    layer.avoid(points=[c.point_m for c in network.crossings])
    add_legend(axes, _key(network), layer)
    return axes


def _tints(blocks: tuple[Block, ...]) -> list[str]:
    """Return a colour for each block, other than those of the blocks beside it."""
    shapes = [block.polygon for block in blocks]
    beside: list[set[int]] = [set() for _ in blocks]
    if shapes:
        one, other = shapely.STRtree(shapes).query(shapes, predicate="intersects")
        for i, j in zip(one.tolist(), other.tolist(), strict=True):
            beside[i].add(j)
    chosen: list[str] = []
    for number in range(len(blocks)):
        taken = {chosen[j] for j in beside[number] if j < number}
        free = [colour for colour in TARGET_COLOURS if colour not in taken]
        # Blocks on a plane hardly ever need more than the six there are.
        chosen.append((free or list(TARGET_COLOURS))[0])
    return chosen


def _draw_axis(ax: Axes, axis: StreetAxis, window: shapely.Polygon) -> None:
    line = shapely.intersection(axis.lines, window)
    if axis.bounds_blocks:
        draw_shape(ax, line, 2.4, edge=INK, points=1.3)
    else:
        draw_shape(ax, line, 2.4, edge=INK, points=0.9, linestyle=(0, (3.0, 2.0)))


def _draw_crossings(ax: Axes, network: StreetNetwork) -> None:
    for corner in (True, False):
        points = [c.point_m for c in network.crossings if c.is_corner == corner]
        if points:
            x, y = zip(*points, strict=True)
            ax.scatter(
                x,
                y,
                s=30 * stroke(ax) ** 2,
                color=ACCENTS["wrong"] if corner else PAPER,
                edgecolor=PAPER if corner else ACCENTS["wrong"],
                linewidth=0.9 * stroke(ax),
                zorder=3.0,
            )


def _number(ax: Axes, blocks: tuple[Block, ...], size_m: float) -> list[Text]:
    """Write the numbers of the blocks that have room for one, each where there is most."""
    written = []
    for block in blocks:
        room = shapely.maximum_inscribed_circle(block.polygon, tolerance=0.5)
        if room.length > 1.1 * size_m:
            x, y = shapely.get_coordinates(room)[0]
            size = 1.2 * font_pt(width_in(ax))
            style: dict[str, Any] = {"ha": "center", "va": "center", "weight": "bold", "color": INK}
            written.append(ax.text(x, y, str(block.number), fontsize=size, zorder=3.1, **style))
    return written


def _labels(network: StreetNetwork, window: shapely.Polygon, size_m: float) -> list[Label]:
    """Return the names of the streets, longest first, which stand beside the axes.

    `size_m` is the size of the letters in metres on the map.
    """
    from sloop_ppl.plots._labels import Label

    names = []
    for axis in network.streets:
        seen = [shapely.intersection(spine, window) for spine in axis.spines]
        longest = max(seen, key=lambda line: float(line.length), default=None)
        if axis.named and longest is not None and longest.length > 0:
            beside = shapely.offset_curve(longest, 0.85 * size_m)
            names.append((-longest.length, Label(axis.label, beside, INK, 0.95)))
    return [label for _, label in sorted(names, key=lambda name: name[0])]


def _key(network: StreetNetwork) -> list[Line2D | Patch]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Line2D | Patch] = []
    shown = [axis for axis in network.streets if axis.named or axis.bounds_blocks]
    if any(axis.bounds_blocks for axis in shown):
        handles.append(Line2D([], [], color=INK, lw=1.3, label="street axis"))
    if any(not axis.bounds_blocks for axis in shown):
        dashed = (0, (3.0, 2.0))
        handles.append(Line2D([], [], color=INK, lw=0.9, ls=dashed, label="footway with a name"))
    mark: dict[str, Any] = {"ls": "none", "marker": "o", "ms": 5, "mew": 0.9}
    colour = ACCENTS["wrong"]
    if any(c.is_corner for c in network.crossings):
        handles.append(Line2D([], [], mfc=colour, mec=PAPER, label="corner", **mark))
    if any(not c.is_corner for c in network.crossings):
        handles.append(Line2D([], [], mfc=PAPER, mec=colour, label="crossing, no corner", **mark))
    if network.blocks:
        tint = TARGET_COLOURS[0]
        handles.append(Patch(facecolor=tint, alpha=_TINT, label="block and its number"))
    return handles
