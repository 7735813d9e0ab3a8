"""Put all that explains a belief on one sheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.plots._axes import fitted
from sloop_ppl.plots._palette import INK
from sloop_ppl.plots._protocols import PosteriorLike
from sloop_ppl.plots.bars import plot_components, plot_influence
from sloop_ppl.plots.belief import plot_belief
from sloop_ppl.plots.frame import plot_frame
from sloop_ppl.plots.parts import draw_parts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_sheet"]

Cells = NDArray[np.float64]
_MOST_PARTS, _ONE_ROW = 6, 3


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
    posterior : beliefs over the cells of a map.
    target : id of the target.
    parts : words -> how well each cell fits them; the first six are drawn, see
        :func:`plot_relations`.
    grounds : words -> ids of the landmarks to highlight in that part.
    components, component_prior : probabilities; see :func:`plot_components`.
    influence : bits of each relation; see :func:`plot_influence`.
    truth : x and y of the true place, metres, or None.

    Returns
    -------
    matplotlib.figure.Figure
        A figure that pyplot does not hold: the belief on the left; parts, bars and the frame of
        the first landmark with one on the right.

    Raises
    ------
    UnknownName : when the posterior has no such target.
    InputError : as the functions that draw the parts.
    """
    from matplotlib.figure import Figure

    frames = list(posterior.frames(target))
    boxes = [bool(components), bool(influence), bool(frames)]
    tall = [bool(parts), any(boxes)]
    if not any(tall):
        figure = Figure(figsize=(6.8, 7.1), layout="constrained")
        plot_belief(posterior, target, ax=figure.add_subplot(), truth=truth)
        return figure
    figure = Figure(figsize=(12.6, 6.9), layout="constrained")
    left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=[1.0, 1.05]).flat
    plot_belief(posterior, target, ax=left.add_subplot(), truth=truth)
    rows = 1 if parts and len(parts) <= _ONE_ROW else 2
    ratios = [rows, 1.3] if all(tall) else [1]
    bands = list(right.subfigures(len(ratios), 1, squeeze=False, height_ratios=ratios).flat)
    if parts:
        shown = dict(list(parts.items())[:_MOST_PARTS])
        columns = -(-len(shown) // rows)
        draw_parts(bands[0], posterior.city, shown, None, grounds or {}, truth, columns)
        bands[0].suptitle("What each relation says by itself", fontsize=9, color=INK)
    if any(boxes):
        shape = (1, sum(boxes)) if parts else (sum(boxes), 1)
        axes = list(bands[-1].subplots(*shape, squeeze=False).flat)
        if components:
            plot_components(components, prior=component_prior, ax=axes.pop(0), title="Components")
        if influence:
            plot_influence(influence, ax=axes.pop(0), title="Influence", label="bits")
        if frames:
            ground = frames[0].ground
            same = [f for f in frames if f.ground == ground and f.relation == frames[0].relation]
            plot_frame(posterior.city, ground, same, ax=axes.pop(0), legend=False)
    said = " ".join(" ".join(t.split()) for t in posterior.texts if t.strip())
    if said:
        figure.suptitle(fitted(f"“{said}”", 11.0, 11.6), fontsize=11, color=INK, parse_math=False)
    return figure
