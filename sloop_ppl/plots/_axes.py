"""Axes to draw a map on: made when none is given, framed in metres, with sizes that fit."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from sloop_ppl.plots._palette import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "fitted",
    "font_pt",
    "frame_map",
    "new_axes",
    "quote_texts",
    "set_title",
    "stroke",
    "width_in",
]

# Text width of a page with two columns, inches.
_DOUBLE_COLUMN_IN = 6.6


def new_axes(ax: Axes | None, *, width: float = _DOUBLE_COLUMN_IN, height: float = 6.8) -> Axes:
    """Return `ax`, or the only axes of a new pyplot figure of so many inches when it is None."""
    if ax is not None:
        return ax
    from matplotlib import pyplot as plt

    return plt.subplots(figsize=(width, height), layout="constrained")[1]


def width_in(ax: Axes) -> float:
    """Return the width of an axes in inches, as it lies now."""
    figure = ax.get_figure(root=True)
    if figure is None:
        return _DOUBLE_COLUMN_IN
    return float(ax.get_window_extent().width / figure.dpi)


def font_pt(width: float) -> float:
    """Return the size of labels in points for a map so many inches wide.

    About 5.6 pt in a 3.4 inch column and 7.6 pt across a 7 inch page.
    """
    return min(max(3.9 + 0.54 * width, 5.0), 9.0)


def fitted(text: str, size_pt: float, width: float) -> str:
    """Return a text broken into lines that fit a width in inches at a font size in points."""
    # 72 points an inch; a letter is about 0.54 of the font size wide.
    return textwrap.fill(text, max(int(width * 72 / (0.54 * size_pt)), 12))


def set_title(ax: Axes, text: str) -> None:
    """Put a title over a map, broken into lines that fit it."""
    size = font_pt(width_in(ax)) + 1.5
    text = fitted(text, size, width_in(ax))
    ax.set_title(text, fontsize=size, color=INK, pad=5, parse_math=False)


def quote_texts(figure: Figure, texts: Sequence[str], width: float) -> None:
    """Put what was said over a figure so many inches wide, unless nothing was."""
    utterance = " ".join(" ".join(t.split()) for t in texts if t.strip())
    if utterance:
        text = fitted(f"“{utterance}”", 11.0, 0.92 * width)
        figure.suptitle(text, fontsize=11, color=INK, parse_math=False)


def stroke(ax: Axes) -> float:
    """Return what line widths and marker sizes are multiplied by: 1 on an axes 4.8 inches wide."""
    return min(max(width_in(ax) / 4.8, 0.65), 1.15)


def frame_map(ax: Axes, extent_m: tuple[float, float, float, float]) -> None:
    """Set limits (west, south, east, north; metres), aspect and labels of an axes with a map."""
    west, south, east, north = extent_m
    size = font_pt(width_in(ax))
    ax.set_xlim(west, east)
    ax.set_ylim(south, north)
    ax.set_aspect("equal")
    ax.set_xlabel("east of the map's centre (m)", fontsize=size, color=INK, labelpad=2)
    ax.set_ylabel("north of the map's centre (m)", fontsize=size, color=INK, labelpad=2)
    ax.tick_params(labelsize=size - 0.5, length=2.5, width=0.6, color=INK, labelcolor=INK, pad=2)
    # Few round ticks: a map is read by its streets, not by its axes.
    ax.locator_params(nbins=5, steps=[1, 2, 5, 10])
    for spine in ax.spines.values():
        spine.set_linewidth(0.7)
        spine.set_color(INK)
