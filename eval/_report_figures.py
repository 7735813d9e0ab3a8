"""The figures of a report: completed searches by steps, boxes of rewards, example searches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sloop_ppl.eval.results import Results
from sloop_ppl.plots._palette import ACCENTS, INK, TARGET_COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["completed_figure", "model_style", "panels", "plain", "reward_figure"]

_GREYS = {"uniform": "#b4b8bf", "informed": "#5c626b"}


def model_style(model: str, models: tuple[str, ...]) -> dict[str, Any]:
    """Return colour and dashes of a model: bounds in grey, ours in the strongest colour."""
    if model in _GREYS:
        return {"color": _GREYS[model], "linestyle": (0, (4, 2))}
    if model == "bayes":
        return {"color": ACCENTS["wrong"], "linestyle": "-"}
    coloured = [m for m in models if m not in _GREYS and m != "bayes"]
    palette = [c for c in TARGET_COLOURS if c != ACCENTS["wrong"]]
    place = coloured.index(model)
    return {
        "color": palette[place % len(palette)],
        "linestyle": "-" if place < len(palette) else ":",
    }


def completed_figure(results: Results) -> Figure:
    """Draw how many searches had found their target after so many steps, a panel per range."""
    figure, all_axes = panels(len(results.ranges), width=3.1, height=3.2)
    asked = results.manifest["searching"]["max_steps"]
    most = int(asked or max(max(t.steps for t in results.trials), 200))
    for axes, range_cells in zip(all_axes, results.ranges, strict=True):
        for model in results.models:
            trials = results.of(model, range_cells)
            took = np.sort([t.steps for t in trials if t.found])
            share = 100 * np.arange(1, len(took) + 1) / len(trials)
            end = share[-1] if len(took) else 0.0
            axes.step(
                [0, *took, most], [0, *share, end], where="post", lw=1.5, label=model,
                zorder=3 if model == "bayes" else 2, **model_style(model, results.models),
            )  # fmt: skip
        axes.set_xlim(0, most)
        axes.set_ylim(0, 102)
        axes.set_xlabel("steps")
        axes.set_title(f"range {range_cells:g} cells", fontsize=9, color=INK)
        plain(axes)
    all_axes[0].set_ylabel("completed searches (%)")
    all_axes[-1].legend(frameon=False, fontsize=7, loc="lower right")
    return figure


def reward_figure(results: Results) -> Figure:
    """Draw boxes of the discounted rewards of all trials, a panel per range."""
    figure, all_axes = panels(
        len(results.ranges), width=3.1, height=0.9 + 0.32 * len(results.models)
    )
    for axes, range_cells in zip(all_axes, results.ranges, strict=True):
        samples = [
            [t.discounted_reward for t in results.of(model, range_cells)]
            for model in results.models
        ]
        boxes = axes.boxplot(
            samples, orientation="horizontal", widths=0.62, patch_artist=True, showmeans=True,
            meanprops={
                "marker": "D", "markersize": 3.5, "markerfacecolor": "white",
                "markeredgecolor": INK,
            },
            medianprops={"color": INK, "lw": 1.2},
            whiskerprops={"color": INK, "lw": 0.7},
            capprops={"color": INK, "lw": 0.7},
            flierprops={"marker": ".", "markersize": 2.5, "markeredgecolor": "#8a8f98"},
        )  # fmt: skip
        for patch, model in zip(boxes["boxes"], results.models, strict=True):
            patch.set_facecolor(model_style(model, results.models)["color"])
            patch.set_alpha(0.75)
            patch.set_linewidth(0.7)
        axes.set_yticks(range(1, 1 + len(results.models)))
        axes.set_yticklabels(results.models if axes is all_axes[0] else [])
        axes.invert_yaxis()
        axes.axvline(0, color="#c9ccd1", lw=0.7, zorder=0)
        axes.set_xlabel("discounted reward")
        axes.set_title(f"range {range_cells:g} cells", fontsize=9, color=INK)
        plain(axes)
    return figure


def panels(count: int, *, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes, side by side, each so many inches wide and high."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(max(width * count, 4.2), height), layout="constrained")
    grid = figure.subplots(1, count, squeeze=False)
    return figure, list(grid[0])


def plain(axes: Axes) -> None:
    """Take away what is not needed and set small type."""
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.tick_params(labelsize=8, length=2.5, width=0.6, color=INK, labelcolor=INK)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_fontsize(8.5)
        label.set_color(INK)
