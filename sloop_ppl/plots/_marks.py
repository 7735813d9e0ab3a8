"""What a map carries besides its landmarks: scale bar, north arrow, attribution and legend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from sloop_ppl.maps import CityMap
from sloop_ppl.plots._axes import font_pt, width_in
from sloop_ppl.plots._palette import INK, PAPER

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

    from sloop_ppl.plots._labels import LabelLayer

__all__ = ["add_attribution", "add_legend", "add_north_arrow", "add_scale_bar", "scale_length_m"]


def scale_length_m(side_m: float) -> float:
    """Return a round length of about a quarter of a map's side, metres."""
    # 1, 2 or 5 times a power of ten, as people read scales.
    target = side_m / 4
    best = 1.0
    power = 1e-3
    while power <= target:
        for step in (1, 2, 5):
            if step * power <= target:
                best = step * power
        power *= 10
    return best


def add_scale_bar(ax: Axes) -> Artist:
    """Add a bar of a round length in the lower left corner."""
    from matplotlib.font_manager import FontProperties
    from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

    west, east = ax.get_xlim()
    length = scale_length_m(east - west)
    text = f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    bar = AnchoredSizeBar(
        ax.transData,
        length,
        text,
        loc="lower left",
        pad=0.35,
        borderpad=0.5,
        sep=2.5,
        frameon=True,
        size_vertical=(east - west) * 0.005,
        color=INK,
        fill_bar=True,
        fontproperties=FontProperties(size=font_pt(width_in(ax))),
    )
    return _boxed(ax, bar)


def add_north_arrow(ax: Axes) -> Artist:
    """Add an arrow to the north in the upper right corner."""
    from matplotlib.offsetbox import AnchoredOffsetbox, DrawingArea, TextArea, VPacker
    from matplotlib.patches import Polygon

    size = font_pt(width_in(ax)) + 0.5
    w, h = 0.95 * size, 1.7 * size
    area = DrawingArea(w, h)
    for side, face in ((0.0, INK), (w, PAPER)):
        corners = [(w / 2, h), (side, 0), (w / 2, 0.26 * h)]
        area.add_artist(Polygon(corners, closed=True, facecolor=face, edgecolor=INK, linewidth=0.7))
    letter = TextArea("N", textprops={"fontsize": size, "fontweight": "bold", "color": INK})
    stack = VPacker(children=[letter, area], align="center", pad=0, sep=1)
    return _boxed(ax, AnchoredOffsetbox("upper right", child=stack, pad=0.35, borderpad=0.5))


def add_attribution(ax: Axes, city: CityMap) -> Artist | None:
    """Add whom the map data belong to, in small print; None when the map does not say."""
    from matplotlib.offsetbox import AnchoredText

    if not city.attribution:
        return None
    text = AnchoredText(
        city.attribution.replace("(c)", "©"),
        loc="lower right",
        pad=0.2,
        borderpad=0.15,
        prop={"fontsize": max(0.62 * font_pt(width_in(ax)), 3.2), "color": INK},
    )
    return _boxed(ax, text)


def add_legend(ax: Axes, handles: Sequence[Any], layer: LabelLayer) -> None:
    """Add a legend: under the axes where the figure makes room for it, else inside.

    Parameters
    ----------
    handles
        Artists with labels, or tuples of them drawn on each other; none means no legend.
    layer
        The labels, which keep off a legend inside.
    """
    if not handles:
        return
    figure = ax.get_figure(root=True)
    room = figure is not None and figure.get_layout_engine() is not None
    width = width_in(ax)
    size = font_pt(width)
    names = [str((h[0] if isinstance(h, tuple) else h).get_label()) for h in handles]
    # 0.54 em a letter, 4.2 em for the sign and the gaps beside it; inches.
    widths = [(len(name) * 0.54 + 4.2) * size / 72 for name in names]
    place: dict[str, Any] = (
        # Below the tick labels and the axis label, which take 2.6 lines and 5 points.
        {"loc": "upper center", "bbox_to_anchor": (0.5, -(2.6 * size + 5.0) / (72 * width))}
        if room
        else {"loc": "upper left"}
    )
    legend = ax.legend(
        list(handles),
        names,
        fontsize=size,
        ncol=_columns(widths, width) if room else 1,
        frameon=not room,
        framealpha=0.88,
        edgecolor="none",
        labelcolor=INK,
        handlelength=1.8,
        handletextpad=0.5,
        columnspacing=1.4,
        labelspacing=0.45,
        borderaxespad=0.4,
        **place,
    )
    legend.set_zorder(8.0)
    if not room:
        layer.avoid(legend)
    elif figure is not None and (engine := figure.get_layout_engine()) is not None:
        # A map keeps its aspect, so that one round of the layout, which drawing is, does not yet
        # know where the legend comes to lie; the next one leaves room for it.
        engine.execute(figure.get_figure(root=True))


def _columns(widths: Sequence[float], room: float) -> int:
    """Return the greatest number of columns in which entries so many inches wide fit."""
    for columns in range(len(widths), 1, -1):
        # matplotlib fills legends column by column.
        rows = -(-len(widths) // columns)
        widest = [max(widths[i : i + rows]) for i in range(0, len(widths), rows)]
        if sum(widest) <= room:
            return len(widest)
    return 1


def _boxed(ax: Axes, box: Any) -> Artist:
    box.patch.set(facecolor=PAPER, alpha=0.82, edgecolor="none")
    box.patch.set_boxstyle("round,pad=0,rounding_size=0.15")
    box.set_zorder(7.0)
    box.set_in_layout(False)
    artist: Artist = ax.add_artist(box)
    return artist
