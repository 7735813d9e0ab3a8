"""Simulation-based calibration: a posterior as sure as it should be, no more and no less.

Run: python -m sloop_ppl.inference.calibration --out DIR [--simulations 400] [--fault NAME]
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.stats import kstest

from sloop_ppl.errors import InputError
from sloop_ppl.inference.fronts import Framed, directions, front_prior, front_table
from sloop_ppl.inference.infer import infer_description
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.models import PredictedSpread, Preset
from sloop_ppl.models.likelihoods import parameters_of, with_values
from sloop_ppl.models.simulate import SPEAKER, Simulated, simulate
from sloop_ppl.models.templates import speakable_grounds
from sloop_ppl.registry import Registry
from sloop_ppl.rng import child

__all__ = ["FAULTS", "Calibration", "Fault", "calibrate", "plot_ranks", "power"]

Table = NDArray[np.float64]

LEVEL = 0.01
_TARGET = "RedBike"
_FRONTS = 72


@dataclass(frozen=True)
class Fault:
    """Something wrong with inference, planted to see whether calibration catches it.

    Parameters
    ----------
    model : changes the model that infers.
    hear : changes what it is told.
    see : changes its belief, shape (H, W).
    """

    model: Callable[[Preset], Preset] = lambda model: model
    hear: Callable[[Description], Description] = lambda said: said
    see: Callable[[Table], Table] = lambda belief: belief


def _sharper_frames(model: Preset) -> Preset:
    prior = model.frame_prior
    if not isinstance(prior, PredictedSpread):
        raise InputError("The fault 'kappa' needs a model whose frames are spread")
    return replace(model, frame_prior=replace(prior, kappa=2 * prior.kappa))


def _wider(model: Preset) -> Preset:
    likelihood = model.likelihood
    widths = [p.name for p in parameters_of(likelihood) if p.unit == "m"]
    changed = {name: 1.5 * getattr(likelihood, name) for name in widths}
    return replace(model, likelihood=with_values(likelihood, changed))


def _mirror(said: Description) -> Description:
    other = {"left": "right", "right": "left"}
    mirrored = tuple(replace(r, relation=other.get(r.relation, r.relation)) for r in said.relations)
    return replace(said, relations=mirrored)


FAULTS: Registry[Fault] = Registry("fault")
"""Planted faults by name."""
FAULTS.add("kappa", Fault(model=_sharper_frames))
FAULTS.add("sigma", Fault(model=_wider))
FAULTS.add("left-right", Fault(hear=_mirror))
FAULTS.add("rows", Fault(see=lambda belief: belief[::-1]))


@dataclass(frozen=True, eq=False)
class Calibration:
    """The rank of each latent's true value in its posterior, over many simulations.

    Parameters
    ----------
    ranks : statistic -> ranks in [0, 1], shape (n,): the posterior probability below the truth,
        ties broken at random. They are uniform when the posterior is right.
    """

    ranks: Mapping[str, Table]

    @property
    def p_values(self) -> dict[str, float]:
        """Kolmogorov-Smirnov p-value of each statistic's ranks against uniform."""
        return {name: float(kstest(ranks, "uniform").pvalue) for name, ranks in self.ranks.items()}

    @property
    def failed(self) -> tuple[str, ...]:
        """The statistics that are not uniform at 1 %, Bonferroni over all of them."""
        least = LEVEL / len(self.ranks)
        return tuple(name for name, p in self.p_values.items() if p < least)


def calibrate(
    city: CityMap,
    n: int,
    *,
    rng: np.random.Generator,
    model: Preset = SPEAKER,
    fault: Fault | None = None,
    phrases: int = 2,
    grounds: Sequence[str] | None = None,
    reach_m: float | None = None,
) -> Calibration:
    """Simulate descriptions, infer, and rank what was true in what is believed.

    Parameters
    ----------
    city : the map; coarse cells make it fast.
    n : number of descriptions, > 0.
    rng : draws the descriptions and breaks ties; description i is the same whatever `n`.
    model : what the descriptions are drawn from.
    fault : what is wrong with inference; nothing when None.
    phrases : phrases of each description.
    grounds : landmarks that are spoken of; see :func:`sloop_ppl.models.simulate.simulate`.
    reach_m : targets are placed, and believed to be, within this distance of one of the grounds:
        far from all of them a width makes no difference to what is said. Anywhere when None.

    Returns
    -------
    Calibration
        Statistics: ``east``, ``north`` and ``density`` of the cell (how much of the belief is
        higher than at the true one), ``distance`` of the cell from the first ground,
        ``component``, ``frame`` (angle from the first ground's likeliest front before), its
        absolute value ``spread``, and ``lapse`` of the first phrase.

    Notes
    -----
    Source: Talts et al. 2018, with the posterior's own table in place of draws from it, so that
    the rank has no Monte Carlo error; ties broken at random for discrete latents.
    """
    wrong = fault or Fault()
    believed = wrong.model(model)
    spoken = speakable_grounds(city) if grounds is None else tuple(grounds)
    away = np.min([city.fields(ground).distance_m for ground in spoken], axis=0)
    prior = np.ones(city.grid.shape) if reach_m is None else (away <= reach_m) * 1.0
    rows: list[dict[str, float]] = []
    for i in range(n):
        stream = child(rng, "calibration", i)
        drawn = simulate(
            city, [_TARGET], stream, model=model, phrases=phrases, grounds=spoken, prior=prior
        )
        rows.append(_ranks(drawn, city, believed, wrong, prior, stream))
    return Calibration({name: np.array([row[name] for row in rows]) for name in rows[0]})


def _ranks(
    drawn: Simulated,
    city: CityMap,
    model: Preset,
    wrong: Fault,
    prior: Table,
    rng: np.random.Generator,
) -> dict[str, float]:
    posterior, _ = infer_description(wrong.hear(drawn.description), city, model, prior=prior)
    truth = drawn.latents[_TARGET]
    belief = wrong.see(posterior.belief(_TARGET))
    row, col = truth.cell
    away = city.fields(drawn.description.relations[0].ground).distance_m
    names = [part.name for part in model.components]
    component = posterior.component(_TARGET)
    term = posterior.said[_TARGET][0].terms[0]
    mass = front_table(posterior, _TARGET, Framed(0, 0, term), _FRONTS).sum(1)
    _, before, home = front_prior(term, model, _FRONTS)
    likeliest = int(np.bincount(home, weights=before).argmax())
    angles = directions(_FRONTS)
    off = _turned(angles - angles[likeliest])
    at = int(np.abs(_turned(angles - truth.fronts_rad[0])).argmin())
    lapse = posterior.lapses(_TARGET)[0].p
    return {
        "east": _rank(belief.sum(0), np.arange(len(belief[0])), col, rng),
        "north": _rank(belief.sum(1), np.arange(len(belief)), row, rng),
        "density": _rank(belief.ravel(), -belief.ravel(), row * belief.shape[1] + col, rng),
        "distance": _rank(belief.ravel(), away.ravel(), row * belief.shape[1] + col, rng),
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


def _rank(mass: Table, order: NDArray[Any], true: int, rng: np.random.Generator) -> float:
    """Return the mass ordered below the true value, plus a random share of that level with it."""
    below = float(mass[order < order[true]].sum())
    level = float(mass[order == order[true]].sum())
    return min(1.0, below + float(rng.random()) * level)


def _turned(angle: Table) -> Table:
    wrapped: Table = np.remainder(angle + math.pi, 2 * math.pi) - math.pi
    return wrapped


def power(found: Calibration, n: int, *, rng: np.random.Generator, repeats: int = 200) -> float:
    """Return how often n simulations would have failed, drawn from those there are.

    Parameters
    ----------
    found : calibration with more than n simulations, of a faulty inference.
    n : size of the test whose power is wanted.
    rng : draws the subsets, without replacement.
    repeats : number of subsets.
    """
    size = len(next(iter(found.ranks.values())))
    if not 0 < n <= size:
        raise InputError(f"n is {n}; expected 1 to {size}, the number of simulations")
    caught = 0
    for _ in range(repeats):
        subset = rng.choice(size, n, replace=False)
        part = Calibration({name: ranks[subset] for name, ranks in found.ranks.items()})
        caught += bool(part.failed)
    return caught / repeats


def plot_ranks(found: Calibration, folder: str | Path) -> tuple[Path, ...]:
    """Write one histogram of ranks per statistic, with the band of uniform ranks; return paths."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from scipy.stats import binom

    Path(folder).mkdir(parents=True, exist_ok=True)
    paths = []
    for name, ranks in found.ranks.items():
        bins = 20
        low, high = binom.ppf([0.005, 0.995], len(ranks), 1 / bins)
        figure = Figure(figsize=(4, 2.6), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.axhspan(low, high, color="0.88", label="99 % if right")
        axes.hist(ranks, bins=bins, range=(0, 1), color="#0072B2")
        axes.set(
            title=f"{name}: p = {found.p_values[name]:.2g}",
            xlabel="posterior probability below the truth",
            ylabel="simulations",
        )
        axes.legend(loc="lower right", fontsize="small")
        paths.append(Path(folder) / f"ranks_{name}.png")
        figure.savefig(paths[-1], dpi=120, metadata={"Software": None})
    return tuple(paths)


def main(arguments: Sequence[str] | None = None) -> int:
    """Calibrate, write the rank plots, and print the p-values; 1 when it fails."""
    options = argparse.ArgumentParser(
        prog="python -m sloop_ppl.inference.calibration", description=__doc__.splitlines()[0]
    )
    options.add_argument("--out", type=Path, default=Path("calibration"), help="folder of plots")
    options.add_argument("--map", default="cleveland")
    options.add_argument("--cell-m", type=float, default=10.0)
    options.add_argument("--grounds", help="landmarks spoken of, separated by commas")
    options.add_argument("--reach-m", type=float, help="targets are this near to one of them")
    options.add_argument("--simulations", type=int, default=400)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--fault", choices=list(FAULTS), help="plant a fault, which should fail")
    given = options.parse_args(arguments)
    torch.set_num_threads(1)
    found = calibrate(
        load_map(given.map, cell_m=given.cell_m),
        given.simulations,
        rng=np.random.default_rng(given.seed),
        fault=FAULTS[given.fault] if given.fault else None,
        grounds=given.grounds.split(",") if given.grounds else None,
        reach_m=given.reach_m,
    )
    plot_ranks(found, given.out)
    for name, p in found.p_values.items():
        verdict = "FAILS" if name in found.failed else "passes"
        sys.stdout.write(f"{name:10} p = {p:.3g}  {verdict}\n")
    return 1 if found.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
