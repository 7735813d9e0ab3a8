"""Draw the ranks and slopes of a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import binom

if TYPE_CHECKING:
    from sloop_ppl.inference.calibration import Calibration

__all__ = ["plot_calibration"]

_BINS = 20


def plot_calibration(found: Calibration, folder: str | Path) -> tuple[Path, ...]:
    """Write one figure per statistic, with where it lies when all is right; return their paths.

    Ranks are drawn as histograms, slopes as the running sum of their residuals.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    Path(folder).mkdir(parents=True, exist_ok=True)
    paths = []
    for name, p in found.p_values.items():
        figure = Figure(figsize=(4, 2.6), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        if name in found.ranks:
            ranks = found.ranks[name]
            low, high = binom.ppf([0.005, 0.995], len(ranks), 1 / _BINS)
            axes.axhspan(low, high, color="0.88", label="99 % if right")
            axes.hist(ranks, bins=_BINS, range=(0, 1), color="#0072B2")
            axes.set(xlabel="posterior probability below the truth", ylabel="simulations")
        else:
            residual, variance = np.cumsum(found.slopes[name], axis=0).T
            at, band = np.arange(1, len(residual) + 1), 2.576 * np.sqrt(variance)
            axes.fill_between(at, -band, band, color="0.88", label="99 % if right")
            axes.plot(at, residual, color="#0072B2")
            axes.set(xlabel="simulations", ylabel="sum of truth less belief")
        axes.set_title(f"{name}: p = {p:.2g}")
        axes.legend(loc="lower right", fontsize="small")
        kind = "ranks" if name in found.ranks else "slopes"
        paths.append(Path(folder) / f"{kind}_{name}.png")
        figure.savefig(paths[-1], dpi=120, metadata={"Software": None})
    return tuple(paths)
