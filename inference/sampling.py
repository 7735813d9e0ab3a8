"""Engines that move through frames continuously: NUTS and variational inference."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pyro
import torch
from numpy.typing import NDArray
from pyro import optim, poutine
from pyro.infer import MCMC, NUTS, SVI, TraceEnum_ELBO, config_enumerate
from pyro.infer.autoguide import AutoNormal, init_to_value
from scipy.special import ive
from torch import Tensor

from sloop_ppl.inference._enumeration import description_tables, mistakes, seeded_torch
from sloop_ppl.inference._frame_draws import draw_frame, framed_sites
from sloop_ppl.inference.engines import Tables, positive, required
from sloop_ppl.inference.summaries import circular_summary
from sloop_ppl.models import FrameDistribution, Program, ProgramData
from sloop_ppl.models.program import check_density

__all__ = ["PLAIN_NUTS", "PLAIN_SVI", "Nuts", "Svi"]

_TOGETHER = 64
"""Draws of frames conditioned on in one run of the program."""

_EVIDENCE_DRAWS = 2000
"""Half from the prior, half from a von Mises round the draws: prior over proposal is at most 2, so
that no weight runs away, and log evidence is off by the order of 1 / sqrt(2000) = .02."""


@dataclass(frozen=True)
class Nuts:
    """Draw frames from their posterior by NUTS, all discrete latents enumerated.

    Parameters
    ----------
    warmup, draws
        Steps of the chain that are dropped and kept, > 0.
    max_tree_depth
        Doublings of a step's trajectory, > 0.

    Notes
    -----
    Angles are not wrapped: the density has period 2 pi. A cross-check for single modes; a chain
    may miss the second front of a street.
    """

    warmup: int = 50
    draws: int = 200
    max_tree_depth: int = 3
    name: ClassVar[str] = "nuts"

    def __post_init__(self) -> None:
        positive(self, "warmup", "draws", "max_tree_depth")

    def weigh(self, data: ProgramData, rng: np.random.Generator | None) -> Tables:
        """Return the log factors; see `sloop_ppl.inference.Engine`.

        Raises
        ------
        InputError
            When `rng` is missing, or a frame is a point.
        """
        return _averaged(self, data, required(rng, self.name))

    def find(self, program: Program, start: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """Return frames from their posterior, site -> angles, shape (draws,) each."""
        kernel = NUTS(program, max_tree_depth=self.max_tree_depth, max_plate_nesting=0)
        chain = MCMC(
            kernel,
            num_samples=self.draws,
            warmup_steps=self.warmup,
            initial_params=dict(start),
            disable_progbar=True,
        )
        chain.run()
        found: dict[str, Tensor] = chain.get_samples()
        return found


@dataclass(frozen=True)
class Svi:
    """Fit a normal guide to each frame, all discrete latents enumerated, and draw from it.

    Parameters
    ----------
    steps
        Gradient steps, > 0.
    draws
        Frames drawn from the guide, > 0.

    Notes
    -----
    The guide (Pyro's AutoNormal) has one mode and no uniform tails, so it is a cross-check where
    frames have one mode and little lapse; with a lapse of .15 beliefs are up to .2 in total
    variation from exact.
    """

    steps: int = 300
    draws: int = 500
    name: ClassVar[str] = "svi"

    def __post_init__(self) -> None:
        positive(self, "steps", "draws")

    def weigh(self, data: ProgramData, rng: np.random.Generator | None) -> Tables:
        """Return the log factors; see `sloop_ppl.inference.Engine`.

        Raises
        ------
        InputError
            When `rng` is missing, or a frame is a point.
        """
        return _averaged(self, data, required(rng, self.name))

    def find(self, program: Program, start: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """Return frames from the guide, site -> angles, shape (draws,) each."""
        with pyro.get_param_store().scope():
            guide = AutoNormal(
                poutine.block(program, expose=list(start)),
                init_loc_fn=init_to_value(values=dict(start)),
                init_scale=0.5,
            )
            adam = optim.PyroOptim(torch.optim.Adam, {"lr": 0.03})
            elbo = TraceEnum_ELBO(num_particles=4, max_plate_nesting=0)
            stepper = SVI(config_enumerate(program), guide, adam, elbo)
            for _ in range(self.steps):
                stepper.step()
            with torch.no_grad():
                drawn = [guide() for _ in range(self.draws)]
        return {name: torch.stack([one[name] for one in drawn]).double() for name in start}


def _averaged(engine: Nuts | Svi, data: ProgramData, rng: np.random.Generator) -> Tables:
    """Average the posterior of the discrete latents over frames from their posterior.

    Notes
    -----
    The factor is Z E[L(v, k, s, psi) / Z(psi)] over the frames, where Z(psi) is the sum of L times
    the priors of cells and of what phrases share. Its product with these is the mean posterior, and
    sums to the evidence Z, which is estimated by importance sampling: half the draws from the
    frames' prior, half from von Mises distributions fitted to the frames that were found.
    """
    check_density(data, f"Engine '{engine.name}'", points=False)
    tables = []
    for i in range(len(data.targets)):
        alone = data.some([i])
        program, priors = Program(alone, "density"), framed_sites(alone)
        with seeded_torch(rng):
            if not priors:
                with torch.no_grad():
                    tables.append(description_tables(program)[0].numpy())
                continue
            start = {name: _likeliest(prior) for name, prior in priors.items()}
            # Whoever calls may have switched gradients off; these engines follow them.
            with torch.enable_grad(), pyro.validation_enabled(False), mistakes():
                frames = engine.find(program, start)
            log_z = _log_evidence(program, priors, frames, rng)
            tables.append(_mean_posterior(program, frames) + log_z)
    return tuple(np.ascontiguousarray(table) for table in tables)


def _likeliest(prior: FrameDistribution) -> Tensor:
    """Return the mean of the weightiest part of a frame's prior."""
    parts = prior.parts
    mean = max(parts, key=lambda part: part.weight).mean_rad if parts else 0.0
    return torch.tensor(mean, dtype=torch.float64)


def _chunks(frames: Mapping[str, Tensor]) -> list[dict[str, Tensor]]:
    count = len(next(iter(frames.values())))
    return [
        {name: angles[start : start + _TOGETHER] for name, angles in frames.items()}
        for start in range(0, count, _TOGETHER)
    ]


def _given(program: Program, frames: Mapping[str, Tensor]) -> tuple[Tensor, Tensor]:
    """Return log L(v, k, s, psi), shape (n, V..., K, S), and log Z(psi), shape (n,)."""
    data = program.data
    factor = description_tables(program, frames)[0]
    log_prior = data.log_shared[..., None, :] + data.log_prior[0]
    return factor, torch.logsumexp((factor + log_prior).flatten(1), 1)


def _mean_posterior(program: Program, frames: Mapping[str, Tensor]) -> NDArray[np.float64]:
    """Return log E[L / Z] over frames drawn from their posterior, shape (V..., K, S)."""
    parts = []
    with torch.no_grad():
        for chunk in _chunks(frames):
            factor, log_z = _given(program, chunk)
            parts.append(torch.logsumexp(factor - log_z.reshape(-1, *(1,) * (factor.dim() - 1)), 0))
        count = len(next(iter(frames.values())))
        mean = torch.logsumexp(torch.stack(parts), 0) - math.log(count)
    table: NDArray[np.float64] = mean.numpy()
    return table


def _log_evidence(
    program: Program,
    priors: Mapping[str, FrameDistribution],
    frames: Mapping[str, Tensor],
    rng: np.random.Generator,
) -> float:
    """Return the log of the mean of Z(psi) over the frames' prior, by importance sampling."""
    half = _EVIDENCE_DRAWS // 2
    log_prior = torch.zeros(2 * half, dtype=torch.float64)
    log_fit = torch.zeros(2 * half, dtype=torch.float64)
    proposed = {}
    for name, prior in priors.items():
        mean, kappa = circular_summary(np.ones(len(frames[name])), frames[name].numpy())
        kappa = min(kappa, 3000.0)  # no narrower than a spread of a degree
        angles = np.concatenate([draw_frame(prior, half, rng), rng.vonmises(mean, kappa, half)])
        proposed[name] = torch.from_numpy(angles)
        level = math.log(2 * math.pi * ive(0, kappa))
        log_fit = log_fit + kappa * (torch.cos(proposed[name] - mean) - 1) - level
        log_prior = log_prior + torch.from_numpy(np.log(prior.density(angles)))
    log_proposal = torch.logaddexp(log_prior, log_fit) - math.log(2)
    with torch.no_grad():
        log_z = torch.cat([_given(program, chunk)[1] for chunk in _chunks(proposed)])
    weights = log_z + log_prior - log_proposal
    return float(torch.logsumexp(weights, 0)) - math.log(2 * half)


PLAIN_NUTS, PLAIN_SVI = Nuts(), Svi()
"""The engines with their default options, as `ENGINES` has them."""
