"""Simulation-based calibration: a posterior as sure as it should be, no more and no less.

Run: python -m sloop_ppl.inference.calibration --out DIR [--simulations 400] [--fault NAME]
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.special import erfc
from scipy.stats import binom, kstest

from sloop_ppl.errors import InputError
from sloop_ppl.inference._calibration_slopes import (
    FAULTS,
    STEP,
    Fault,
    near_slopes,
    residual,
    sharper_frames,
)
from sloop_ppl.inference.frames import Framed, FramePosterior, directions, frame_nodes
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.models import GroundedRelation, ObservationModel, PredictedSpread
from sloop_ppl.models.simulation import SPEAKER, Simulated, simulate, speaker_of
from sloop_ppl.rng import child

__all__ = ["FAULTS", "Calibration", "Fault", "calibrate", "plot_calibration", "power"]

Table = NDArray[np.float64]

LEVEL = 0.01  # how often a right posterior may be taken for a wrong one
_TARGET = "RedBike"
_ANGLES = 72
_BINS = 20  # bars of the picture of ranks
_NEAR = 4
"""Descriptions for the widths' slope for each whose latents are ranked: they cost a twentieth."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """How latents of simulated descriptions lie in their posteriors.

    Parameters
    ----------
    ranks
        Statistic -> ranks in [0, 1], shape (n,): the posterior probability below the truth, ties
        broken at random. They are uniform when the posterior is right.
    slopes
        Parameter -> residual and variance, shape (m, 2); the residuals sum to zero, within the root
        of the summed variances, when the posterior is right.
    """

    ranks: Mapping[str, Table]
    slopes: Mapping[str, Table] = field(default_factory=dict)

    @property
    def p_values(self) -> dict[str, float]:
        """P-value of each statistic.

        Kolmogorov-Smirnov of ranks against uniform; for slopes, two-sided, of their standardised
        sum against the standard normal.
        """
        by_name = {
            name: float(kstest(ranks, "uniform").pvalue) for name, ranks in self.ranks.items()
        }
        for name, rows in self.slopes.items():
            total, variance = rows.sum(0)
            by_name[name] = float(erfc(abs(total) / math.sqrt(2 * max(variance, 1e-300))))
        return by_name

    @property
    def failed(self) -> tuple[str, ...]:
        """The statistics that are off at 1 %, Bonferroni over all of them."""
        least = LEVEL / (len(self.ranks) + len(self.slopes))
        return tuple(name for name, p in self.p_values.items() if p < least)


def calibrate(
    city: CityMap,
    n: int,
    *,
    rng: np.random.Generator,
    model: str | ObservationModel = SPEAKER,
    fault: Fault | None = None,
    phrases: int = 2,
    near: int | None = None,
) -> Calibration:
    """Simulate descriptions, infer, and see where what was true lies in what is believed.

    Parameters
    ----------
    city
        The map; coarse cells make it fast.
    n
        Number of descriptions whose latents are ranked, >= 0.
    rng
        Draws the descriptions and breaks ties; description i is the same whatever `n`.
    model
        What the descriptions are drawn from and inferred with, as a speaker.
    fault
        What is wrong with inference; nothing when None.
    phrases
        Phrases of each of these descriptions.
    near
        Number of other descriptions for the slopes of the cell, of targets near a cluster of
        grounds, >= 0; four times `n` when None. See
        :func:`sloop_ppl.inference._calibration_slopes.near_slopes`.

    Returns
    -------
    Calibration
        Ranks: ``east``, ``north`` and ``density`` of the cell (how much of the belief is higher
        than at the true one), ``distance`` of the cell from the first ground, ``component``,
        ``frame`` (angle from the first ground's likeliest front before), its absolute value
        ``spread``, and ``lapse`` of the first phrase. Slopes: ``width`` and ``mirror``, of the
        cell; and, where frames are spread, ``concentration``, of the first ground's front in
        their kappa.

    Notes
    -----
    Source: Talts et al. 2018, with the posterior's own table in place of draws from it, so that
    the rank has no Monte Carlo error; ties broken at random for discrete latents. Slopes after
    Modrak et al. 2023, whose test quantities depend on the data too.
    """
    wrong = fault or Fault()
    model = speaker_of(model)
    believed = wrong.model(model)
    rows: list[dict[str, float]] = []
    turns: list[tuple[float, float]] = []
    for i in range(n):
        stream = child(rng, "calibration", i)
        drawn = simulate(city, [_TARGET], stream, model=model, phrases=phrases)
        ranks, turn = _ranks(drawn, city, believed, wrong, stream)
        rows.append(ranks)
        turns += [turn] if turn else []
    steep = {"concentration": np.array(turns)} if turns else {}
    if count := _NEAR * n if near is None else near:
        steep |= near_slopes(city, count, rng=rng, model=model, fault=wrong)
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]} if rows else {}
    return Calibration(columns, steep)


def _ranks(
    drawn: Simulated,
    city: CityMap,
    model: ObservationModel,
    wrong: Fault,
    rng: np.random.Generator,
) -> tuple[dict[str, float], tuple[float, float] | None]:
    """Return the ranks of one description's latents, and its slope in the frames' kappa."""
    posterior, _ = infer_description(wrong.perturb(drawn.description), city, model)
    truth = drawn.latents[_TARGET]
    belief = wrong.see(posterior.belief(_TARGET))
    row, col = truth.cell
    distance_m = city.fields(drawn.description.relations[0].ground).distance_m
    names = [part.name for part in model.components]
    component = posterior.component(_TARGET)
    (factor,), (term, *_) = posterior.factors, posterior.grounded(_TARGET)
    frame = FramePosterior(posterior.joint, factor, _TARGET, Framed(0, 0, term))
    mass = frame.table(_ANGLES).sum(1)
    _, before, home = frame.nodes(_ANGLES)
    likeliest = int(np.bincount(home, weights=before).argmax())
    angles = directions(_ANGLES)
    off = _turned(angles - angles[likeliest])
    at = int(np.abs(_turned(angles - truth.frame_angles_rad[0])).argmin())
    lapse = posterior.lapses(_TARGET)[0].p
    ranks = {
        "east": _rank(belief.sum(0), np.arange(len(belief[0])), col, rng),
        "north": _rank(belief.sum(1), np.arange(len(belief)), row, rng),
        "density": _rank(belief.ravel(), -belief.ravel(), row * belief.shape[1] + col, rng),
        "distance": _rank(belief.ravel(), distance_m.ravel(), row * belief.shape[1] + col, rng),
        "component": _rank(
            np.array([component[name] for name in names]),
            np.arange(len(names)),
            names.index(truth.component),
            rng,
        ),
        "frame": _rank(mass, off, at, rng),
        "spread": _rank(mass, np.abs(off).round(9), at, rng),
        "lapse": _rank(np.array([1 - lapse, lapse]), np.arange(2), int(truth.lapses[0]), rng),
    }
    return ranks, _turn(term, model, mass, at)


def _turn(
    term: GroundedRelation, model: ObservationModel, mass: Table, at: int
) -> tuple[float, float] | None:
    """Return residual and variance of the front's slope; None where no kappa can change.

    The slope is that of the front's prior: once the front is known, what was said of its ground
    is as likely whatever the kappa.
    """
    if not isinstance(model.frame_prior, PredictedSpread):
        return None
    priors = []
    for times in (1.0, STEP):
        prior = sharper_frames(model, times).frame_prior_for(term)
        if prior is None:
            return None
        _, weights, home = frame_nodes(prior, _ANGLES, term.n_cells)
        priors.append(np.bincount(home, weights=weights, minlength=_ANGLES))
    return residual(mass, mass * priors[1] / priors[0], at)


def _rank(mass: Table, order: NDArray[Any], true: int, rng: np.random.Generator) -> float:
    """Return the mass ordered below the true value, plus a random share of that level with it."""
    below = float(mass[order < order[true]].sum())
    level = float(mass[order == order[true]].sum())
    return min(1.0, below + float(rng.random()) * level)


def _turned(angle: Table) -> Table:
    wrapped: Table = np.remainder(angle + math.pi, 2 * math.pi) - math.pi
    return wrapped


def power(
    found: Calibration, share: float, *, rng: np.random.Generator, repeats: int = 200
) -> float:
    """Return how often a part of the simulations would have failed.

    Parameters
    ----------
    found
        Calibration of a faulty inference.
    share
        Size of the test whose power is wanted, as a share of the simulations there are.
    rng
        Draws the parts.
    repeats
        Number of parts.

    Raises
    ------
    InputError
        When `share` is not above 0 and at most 1.
    """
    if not 0 < share <= 1:
        raise InputError(f"share is {share}; expected more than 0 and at most 1")
    caught = 0
    for _ in range(repeats):
        orders: dict[int, NDArray[np.intp]] = {}
        parts = []
        for tables in (found.ranks, found.slopes):
            part = {}
            for name, table in tables.items():
                order = orders.setdefault(len(table), rng.permutation(len(table)))
                part[name] = table[order[: max(1, round(share * len(table)))]]
            parts.append(part)
        caught += bool(Calibration(*parts).failed)
    return caught / repeats


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
            off, variance = np.cumsum(found.slopes[name], axis=0).T
            at, band = np.arange(1, len(off) + 1), 2.576 * np.sqrt(variance)
            axes.fill_between(at, -band, band, color="0.88", label="99 % if right")
            axes.plot(at, off, color="#0072B2")
            axes.set(xlabel="simulations", ylabel="sum of truth less belief")
        axes.set_title(f"{name}: p = {p:.2g}")
        axes.legend(loc="lower right", fontsize="small")
        kind = "ranks" if name in found.ranks else "slopes"
        paths.append(Path(folder) / f"{kind}_{name}.png")
        figure.savefig(paths[-1], dpi=120, metadata={"Software": None})
    return tuple(paths)


def main(arguments: Sequence[str] | None = None) -> int:
    """Calibrate, write the plots, and print the p-values; 1 when it fails."""
    options = argparse.ArgumentParser(
        prog="python -m sloop_ppl.inference.calibration", description=__doc__.splitlines()[0]
    )
    options.add_argument("--out", type=Path, default=Path("calibration"), help="folder of plots")
    options.add_argument("--map", default="cleveland")
    options.add_argument("--cell-m", type=float, default=10.0)
    options.add_argument("--simulations", type=int, default=400)
    options.add_argument("--near", type=int, help="descriptions for slopes; 4 times as many")
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--fault", choices=list(FAULTS), help="plant a fault, which should fail")
    given = options.parse_args(arguments)
    torch.set_num_threads(1)
    found = calibrate(
        load_map(given.map, cell_m=given.cell_m),
        given.simulations,
        rng=np.random.default_rng(given.seed),
        fault=FAULTS[given.fault] if given.fault else None,
        near=given.near,
    )
    plot_calibration(found, given.out)
    for name, p in found.p_values.items():
        verdict = "FAILS" if name in found.failed else "passes"
        sys.stdout.write(f"{name:13} p = {p:.3g}  {verdict}\n")
    return 1 if found.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
