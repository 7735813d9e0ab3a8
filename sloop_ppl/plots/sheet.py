"""Put all that explains a belief on one sheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import InputError
from sloop_ppl.plots._axes import quote_texts
from sloop_ppl.plots._palette import INK
from sloop_ppl.plots._protocols import FrameLike, PosteriorLike
from sloop_ppl.plots.bars import plot_components, plot_influence
from sloop_ppl.plots.belief import plot_belief
from sloop_ppl.plots.belief_parts import bits_gained, draw_parts, plot_change
from sloop_ppl.plots.city import display_name
from sloop_ppl.plots.frame import plot_frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

__all__ = ["FrameRose", "SheetParts", "plot_sheet", "plot_sheets"]

Cells = NDArray[np.float64]
# More small maps would be too small to tell streets apart.
_MOST_PARTS, _MOST_ROSES = 6, 2


@dataclass(frozen=True, eq=False)
class FrameRose:
    """Which way a landmark faces; see :func:`sloop_ppl.plots.plot_frame`.

    Parameters
    ----------
    ground
        Id of the landmark.
    posterior, prior
        Probabilities of B equal directions, shape (B,), or frames.
    title
        Title of the rose; says whose front it is when None.
    """

    ground: str
    posterior: NDArray[np.float64] | Sequence[FrameLike]
    prior: NDArray[np.float64] | None = None
    title: str | None = None


@dataclass(frozen=True, eq=False)
class SheetParts:
    """What explains the belief of one target; whatever is empty is not drawn.

    Parameters
    ----------
    parts
        Relation in words -> how well each cell fits it, shape (H, W).
    grounds
        Words -> ids of the landmarks to highlight in that part.
    component_maps
        Component -> belief if it is the right one, shape (H, W).
    components, component_prior
        Probabilities; see :func:`plot_components`.
    influence
        Bits of each relation; see :func:`plot_influence`.
    roses
        Frames of reference; the first two are drawn.
    prior
        Belief before anything was said, shape (H, W), to draw the change from.
    truth
        x and y of the true place, metres.
    """

    parts: Mapping[str, Cells] = field(default_factory=dict)
    grounds: Mapping[str, Sequence[str]] = field(default_factory=dict)
    component_maps: Mapping[str, Cells] = field(default_factory=dict)
    components: Mapping[str, float] = field(default_factory=dict)
    component_prior: Mapping[str, float] | None = None
    influence: Mapping[str, float] = field(default_factory=dict)
    roses: Sequence[FrameRose] = ()
    prior: Cells | None = None
    truth: tuple[float, float] | None = None


def plot_sheet(
    posterior: PosteriorLike,
    target: str,
    *,
    parts: Mapping[str, Cells] | None = None,
    grounds: Mapping[str, Sequence[str]] | None = None,
    components: Mapping[str, float] | None = None,
    component_prior: Mapping[str, float] | None = None,
    influence: Mapping[str, float] | None = None,
    truth: tuple[float, float] | None = None,
) -> Figure:
    """Draw a target's belief and, beside it, whatever is given of what explains it.

    Parameters
    ----------
    posterior
        Beliefs over the cells of a map.
    target
        Id of the target.
    parts
        Words -> how well each cell fits them; the first six are drawn, see :func:`plot_relations`.
    grounds
        Words -> ids of the landmarks to highlight in that part.
    components, component_prior
        Probabilities; see :func:`plot_components`.
    influence
        Bits of each relation; see :func:`plot_influence`.
    truth
        x and y of the true place, metres, or None.

    Returns
    -------
    matplotlib.figure.Figure
        A figure that pyplot does not hold: the belief, the parts, the bars and the frame of the
        first landmark with one.

    Raises
    ------
    UnknownName
        When the posterior has no such target.
    InputError
        As the functions that draw the parts.
    """
    frames = list(posterior.frames(target)) if target in posterior.targets else []
    frames = [frame for frame in frames if frame.ground in posterior.city]
    same = [f for f in frames if (f.ground, f.relation) == (frames[0].ground, frames[0].relation)]
    sheet = SheetParts(
        parts=parts or {},
        grounds=grounds or {},
        components=components or {},
        component_prior=component_prior,
        influence=influence or {},
        roses=[FrameRose(frames[0].ground, same)] if frames else [],
        truth=truth,
    )
    return plot_sheets(posterior, {target: sheet})


def plot_sheets(posterior: PosteriorLike, sheets: Mapping[str, SheetParts]) -> Figure:
    """Draw one sheet a target, one below the other, under what was said.

    Parameters
    ----------
    posterior
        Beliefs over the cells of a map.
    sheets
        Target -> what explains its belief.

    Returns
    -------
    matplotlib.figure.Figure
        A figure that pyplot does not hold: for each target the belief on the left, relation by
        relation and component by component on the right, and below them bars, the frames on
        their landmarks, and the change from the prior.

    Raises
    ------
    UnknownName
        When the posterior has no such target.
    InputError
        When there is no sheet, or as the functions that draw the parts.
    """
    from matplotlib.figure import Figure

    if not sheets:
        raise InputError("There is no target to draw; expected at least one")
    sizes = [_size(sheet) for sheet in sheets.values()]
    width = max(w for w, _ in sizes)
    figure = Figure(figsize=(width, sum(h for _, h in sizes) + 0.4), layout="constrained")
    bands = figure.subfigures(len(sheets), 1, squeeze=False, height_ratios=[h for _, h in sizes])
    for band, (target, sheet) in zip(bands.flat, sheets.items(), strict=True):
        _fill(band, posterior, target, sheet)
    quote_texts(figure, posterior.texts, width)
    return figure


def _boxes(sheet: SheetParts) -> int:
    bars = bool(sheet.components) + bool(sheet.influence)
    return bars + len(sheet.roses[:_MOST_ROSES]) + (sheet.prior is not None)


def _rows(count: int, alone: bool) -> int:
    """Return the number of rows of so many small maps, flatter when they share the space."""
    return 1 if count <= (1 if alone else 4) else 2


def _size(sheet: SheetParts) -> tuple[float, float]:
    """Return the width and height of a sheet, inches."""
    maps = bool(sheet.parts or sheet.component_maps)
    if not maps and not _boxes(sheet):
        return 6.8, 7.0
    # Inches: a landscape page for the maps, a band of 3.2 for the boxes below them.
    return 13.2, 6.3 + 3.2 * (maps and _boxes(sheet) > 0)


def _fill(figure: FigureBase, posterior: PosteriorLike, target: str, sheet: SheetParts) -> None:
    """Draw the sheet of one target into a part of a figure."""
    maps, boxes = bool(sheet.parts or sheet.component_maps), _boxes(sheet)
    if not maps and not boxes:
        plot_belief(posterior, target, ax=figure.add_subplot(), truth=sheet.truth)
        return
    top, below = figure, None
    if maps and boxes:
        top, below = figure.subfigures(2, 1, squeeze=False, height_ratios=[6.3, 3.2]).flat
    left, right = top.subfigures(1, 2, squeeze=False, width_ratios=[1.0, 1.05]).flat
    plot_belief(posterior, target, ax=left.add_subplot(), truth=sheet.truth)
    if maps:
        _maps(right, posterior, sheet)
    if below is not None:
        widths = [1.0] * boxes
        axes = below.subplots(1, boxes, squeeze=False, width_ratios=widths)
        _draw_boxes(list(axes.flat), posterior, target, sheet)
    elif boxes:
        rows = -(-boxes // 2) if boxes > 3 else boxes
        axes = right.subplots(rows, 2 if boxes > 3 else 1, squeeze=False)
        _draw_boxes(list(axes.flat), posterior, target, sheet)


def _maps(figure: FigureBase, posterior: PosteriorLike, sheet: SheetParts) -> None:
    """Draw the small maps: relation by relation, then component by component."""
    panels = [
        (sheet.parts, sheet.grounds, "What each relation says by itself"),
        (sheet.component_maps, {}, "Where each component believes it to be"),
    ]
    bands = [
        (dict(list(m.items())[:_MOST_PARTS]), marked, title) for m, marked, title in panels if m
    ]
    heights = [_rows(len(shown), len(bands) == 1) for shown, _, _ in bands]
    parts = figure.subfigures(len(bands), 1, squeeze=False, height_ratios=heights)
    for part, (shown, marked, title), rows in zip(parts.flat, bands, heights, strict=True):
        columns = -(-len(shown) // rows)
        draw_parts(part, posterior.city, shown, None, marked, sheet.truth, columns)
        part.suptitle(title, fontsize=9, color=INK)


def _draw_boxes(axes: list[Axes], posterior: PosteriorLike, target: str, sheet: SheetParts) -> None:
    """Draw bars, roses and the change from the prior, in this order."""
    if sheet.components:
        plot_components(
            sheet.components, prior=sheet.component_prior, ax=axes.pop(0), title="Components"
        )
    if sheet.influence:
        plot_influence(sheet.influence, ax=axes.pop(0), title="Influence", label="bits")
    for rose in sheet.roses[:_MOST_ROSES]:
        plot_frame(
            posterior.city,
            rose.ground,
            rose.posterior,
            prior=rose.prior,
            ax=axes.pop(0),
            legend=False,
            title=rose.title or _title(posterior, rose),
        )
    if sheet.prior is not None:
        belief = posterior.belief(target)
        plot_change(
            posterior.city,
            sheet.prior,
            belief,
            ax=axes.pop(0),
            labels=False,
            legend=False,
            title=f"Against the prior: {bits_gained(belief, sheet.prior):.2f} bits",
        )
    for ax in axes:
        ax.set_axis_off()


def _title(posterior: PosteriorLike, rose: FrameRose) -> str | None:
    if rose.prior is None:
        return None
    return f"Front of {display_name(posterior.city.landmark(rose.ground))} (dashed: before)"
