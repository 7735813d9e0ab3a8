"""Draw how far predicted fronts are off, like the paper's figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from sloop_ppl.errors import InputError
from sloop_ppl.plots._axes import new_axes
from sloop_ppl.plots._palette import ACCENTS, INK, MUTED

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Numbers = Sequence[float] | NDArray[np.floating]

__all__ = ["draw_deviations", "plot_deviations"]


def plot_deviations(boxes: Mapping[str, Numbers], *, ax: Axes | None = None) -> Axes:
    """Draw a box for each predictor: quartiles, whiskers, the mean as a diamond.

    Parameters
    ----------
    boxes
        Name -> deviations, degrees, 0 to 180; at least one each.
    ax
        Axes to draw on; a new pyplot figure when None.

    Raises
    ------
    InputError
        When there is nothing to draw.
    """
    shown = {name: list(values) for name, values in boxes.items() if len(values)}
    if not shown:
        raise InputError("There are no deviations to draw; expected some of one predictor at least")
    axes = new_axes(ax, width=5.2, height=3.6)
    drawn = axes.boxplot(
        list(shown.values()),
        orientation="horizontal",
        showmeans=True,
        patch_artist=True,
        widths=0.6,
        flierprops={"marker": ".", "ms": 2, "mec": MUTED.label, "alpha": 0.3},
        medianprops={"color": INK, "lw": 1.6},
        meanprops={"marker": "D", "mfc": "white", "mec": INK, "ms": 4.5},
    )
    for box in drawn["boxes"]:
        box.set(facecolor=ACCENTS["frame"], edgecolor=INK, linewidth=0.8)
    axes.set_yticks(range(1, len(shown) + 1), [f"{n} ({len(v)})" for n, v in shown.items()])
    axes.invert_yaxis()
    axes.set_xlim(-4, 184)
    axes.set_xticks(range(0, 181, 45))
    axes.set_xlabel("deviation of the likeliest front from the label (degrees)")
    axes.grid(axis="x", color=MUTED.road_edge, lw=0.5)
    axes.set_axisbelow(True)
    return axes


def draw_deviations(
    boxes: Mapping[str, Numbers],
    agreement: Numbers,
    annotated: Mapping[str, Numbers] = MappingProxyType({}),
) -> Figure:
    """Draw deviations from annotated fronts and, beside them, those from addresses.

    Parameters
    ----------
    boxes
        See `plot_deviations`.
    agreement
        Deviation of address from main entrance, degrees, in place of the paper's people.
    annotated
        Name -> deviations from the fronts that annotators gave; without any, a panel says that the
        paper's are not public.

    Notes
    -----
    Source: SLOOP fig. 6. Its left panel compares with annotated frames, which are not public.
    """
    from matplotlib.figure import Figure

    if annotated and not boxes:
        alone = Figure(figsize=(5.6, 3.6), layout="constrained")
        plot_deviations(annotated, ax=alone.subplots())
        alone.axes[0].set_title("Against annotated frames", fontsize=10, color=INK)
        return alone
    figure = Figure(figsize=(9.0, 3.9), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.6 if annotated else 1.0, 2.4])
    if annotated:
        plot_deviations(annotated, ax=left)
    else:
        _say_missing(left)
    left.set_title("Against annotated frames", fontsize=10, color=INK)
    rows = dict(boxes)
    if len(agreement):
        rows["address against entrance\n(in place of Human)"] = agreement
    plot_deviations(rows, ax=right)
    right.set_title("Against the street of the address, cities held out", fontsize=10, color=INK)
    return figure


def _say_missing(axes: Axes) -> None:
    axes.set_xticks([])
    axes.set_yticks([])
    axes.text(
        0.5, 0.5, "not reproducible\nwithout the paper's\nannotations", ha="center", va="center",
        fontsize=10, color=INK, transform=axes.transAxes,
    )  # fmt: skip
