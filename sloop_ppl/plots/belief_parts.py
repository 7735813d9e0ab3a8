"""Draw why a belief is where it is: part by part, and before against after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.plots._axes import fitted, new_axes, set_title, width_in
from sloop_ppl.plots._belief import check_cells, draw_cells, draw_hpd, mode_of
from sloop_ppl.plots._marks import add_legend, add_scale_bar
from sloop_ppl.plots._palette import ACCENTS, INK, difference_colours
from sloop_ppl.plots.belief import add_colour_bar, add_mark
from sloop_ppl.plots.city import draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

__all__ = ["bits_gained", "draw_parts", "plot_change", "plot_relations"]

Cells = NDArray[np.float64]


def plot_relations(
    city: CityMap,
    parts: Mapping[str, Cells],
    *,
    whole: Cells | None = None,
    grounds: Mapping[str, Sequence[str]] | None = None,
    truth: tuple[float, float] | None = None,
    columns: int = 3,
    title: str | None = None,
) -> Figure:
    """Draw what each relation, or component, says by itself, and all of them together.

    Parameters
    ----------
    city
        The map.
    parts
        Words -> how well each cell fits them, none negative, shape (H, W); each is scaled to its
        peak, so they need not sum to one.
    whole
        Belief after all of them, drawn last and framed; None to leave it out.
    grounds
        Words -> ids of the landmarks to highlight in that panel.
    truth
        x and y of the true place, metres, marked in every panel, or None.
    columns
        Panels in a row, > 0.
    title
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        A figure that pyplot does not hold.

    Raises
    ------
    InputError
        When there is no part, or one is negative, not finite or of another shape than the map.
    """
    from matplotlib.figure import Figure

    if columns < 1:
        raise InputError(f"columns is {columns}; expected at least 1")
    count = len(parts) + (whole is not None)
    columns = max(1, min(columns, count))
    rows = -(-count // columns)
    side = 2.55 if columns > 2 else 3.2
    figure = Figure(figsize=(side * columns, (side + 0.22) * rows + 0.35), layout="constrained")
    draw_parts(figure, city, parts, whole, grounds or {}, truth, columns)
    if title:
        fitted_title = fitted(title, 10.0, side * columns)
        figure.suptitle(fitted_title, fontsize=10, color=INK, parse_math=False)
    return figure


def draw_parts(
    figure: FigureBase,
    city: CityMap,
    parts: Mapping[str, Cells],
    whole: Cells | None,
    grounds: Mapping[str, Sequence[str]],
    truth: tuple[float, float] | None,
    columns: int,
) -> None:
    """Fill a figure, or a part of one, with one small map a part; see :func:`plot_relations`."""
    if not parts:
        raise InputError("There is no part to draw; expected at least one")
    panels: list[tuple[str, Cells, Sequence[str]]] = [
        (words, table, grounds.get(words, ())) for words, table in parts.items()
    ]
    if whole is not None:
        mentioned = [g for marked in grounds.values() for g in marked]
        panels.append(("all together", whole, mentioned))
    rows = -(-len(panels) // columns)
    grid = list(figure.subplots(rows, columns, squeeze=False).flat)
    for k, (ax, (words, table, marked)) in enumerate(zip(grid, panels, strict=False)):
        _panel(ax, city, words, table, marked, truth, scale=k == 0)
    if whole is not None:
        last = grid[len(panels) - 1]
        draw_hpd(last, check_cells(whole, city, "whole"), city.grid)
        for spine in last.spines.values():
            spine.set_linewidth(1.8)
    for ax in grid[len(panels) :]:
        ax.set_axis_off()
    credit = city.attribution.replace("(c)", "©")
    grid[len(panels) - 1].set_xlabel(credit, fontsize=4.5, color=INK, loc="right", labelpad=2)


def plot_change(
    city: CityMap,
    before: Cells,
    after: Cells,
    *,
    ax: Axes | None = None,
    labels: bool = True,
    legend: bool = True,
    title: str | None = None,
) -> Axes:
    """Draw where a belief rose and where it fell, such as from the prior to the posterior.

    Parameters
    ----------
    city
        The map.
    before, after
        Probabilities, shape (H, W).
    ax
        Axes to draw on; a new pyplot figure when None.
    labels
        True to name landmarks.
    legend
        True to add a legend.
    title
        Title of the axes; says how many bits were gained when None.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in metres; blue cells gained, vermilion ones lost.

    Raises
    ------
    InputError
        When a belief has another shape than the map, or is not finite.
    """
    from matplotlib.colors import TwoSlopeNorm

    prior, posterior = check_cells(before, city, "before"), check_cells(after, city, "after")
    axes = new_axes(ax, height=6.6)
    layer = draw_map(axes, city, labels=labels, muted=True, cells=True)
    change = posterior - prior
    # The same scale for more and for less, so that no change is the clear middle.
    top = max(float(np.abs(change).max()), 1e-12)
    norm = TwoSlopeNorm(0.0, vmin=-top, vmax=top)
    image = draw_cells(axes, change, city.grid, cmap=difference_colours(), norm=norm)
    handles = draw_hpd(axes, posterior, city.grid)
    mode = mode_of(posterior, city.grid)
    handles.append(add_mark(axes, mode, "*", ACCENTS["mode"], "most probable cell"))
    layer.avoid(points=[mode])
    add_colour_bar(axes, image, "change of the probability of a cell")
    set_title(axes, title or f"{bits_gained(posterior, prior):.2f} bits gained")
    if legend:
        add_legend(axes, handles, layer)
    return axes


def bits_gained(posterior: Cells, prior: Cells) -> float:
    """Return the Kullback-Leibler divergence of the posterior from the prior, bits."""
    held = posterior > 0
    with np.errstate(divide="ignore"):
        # sum of p log2(p / q) over cells with p > 0; infinite where the prior excludes what is
        # believed.
        ratio = np.log2(posterior[held]) - np.log2(prior[held])
    return float((posterior[held] * ratio).sum())


def _panel(
    ax: Axes,
    city: CityMap,
    words: str,
    table: Cells,
    grounds: Sequence[str],
    truth: tuple[float, float] | None,
    scale: bool,
) -> None:
    """Draw one small map: its grounds named, no axis labels."""
    values = check_cells(table, city, f"The part '{words}'")
    if (values < 0).any():
        raise InputError(f"The part '{words}' has a negative value; expected none below zero")
    layer = draw_map(ax, city, highlight=grounds, muted=True, cells=True, furniture=False)
    layer.labels = layer.labels[: len(dict.fromkeys(grounds))]
    # 1e-300: a part that fits nowhere is drawn empty instead of dividing by zero.
    draw_cells(ax, values / max(float(values.max()), 1e-300), city.grid)
    if truth is not None:
        add_mark(ax, truth, "D", ACCENTS["truth"], "true place")
        layer.avoid(points=[truth])
    if scale:
        layer.avoid(add_scale_bar(ax))
    ax.set_xlabel("")
    ax.set_ylabel("")
    ax.set_xticks([])
    ax.set_yticks([])
    style: Any = {"fontsize": 7.5, "color": INK, "pad": 3, "parse_math": False}
    ax.set_title(fitted(words, 7.5, max(width_in(ax), 1.8)), **style)
