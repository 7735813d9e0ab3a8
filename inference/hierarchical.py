"""Draw a model's parameters from their posterior by NUTS, with differences between speakers."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from pyro.infer import MCMC, NUTS
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference._enumeration import seeded_torch
from sloop_ppl.inference._free_parameters import FreeParameters
from sloop_ppl.inference._supervised_scores import Example, SupervisedScore, supervised_score
from sloop_ppl.inference.learning import curvature, maximise
from sloop_ppl.inference.parameter_draws import ParameterDraws
from sloop_ppl.models import ObservationModel
from sloop_ppl.rng import child

if TYPE_CHECKING:
    import xarray

__all__ = ["sample_parameters"]

_LEAST_DRAWS = 20  # r-hat splits each chain in two, and a half of fewer tells nothing
_SPREAD_SCALE = 0.5
"""Scale of the half-normal prior of the spread between speakers, in prior standard deviations."""


def sample_parameters(
    examples: Sequence[Example],
    model: ObservationModel,
    *,
    rng: np.random.Generator,
    learn: Sequence[str] | None = None,
    vary: Sequence[str] = (),
    warmup: int = 200,
    draws: int = 300,
    chains: int = 2,
    progress: Callable[[str], None] | None = None,
) -> ParameterDraws:
    """Draw parameters from their posterior given targets whose cells are known.

    Parameters
    ----------
    examples
        What is learnt from; with `vary`, each has a speaker.
    model
        The model whose parameters are learnt, from where they stand.
    rng
        Where the chains are drawn from; the same seed gives the same draws.
    learn
        Names of what is learnt, as for :func:`sloop_ppl.inference.learning.fit`.
    vary
        Names of those that differ from speaker to speaker, around the population's: numbers of the
        likelihood and ``kappa``.
    warmup
        Steps of a chain that adapt it and are dropped, > 0.
    draws
        Steps of a chain that are kept, at least 20.
    chains
        Number of chains, run one after another, > 0.
    progress
        Called with a line now and then.

    Returns
    -------
    ParameterDraws
        The draws with r-hat and effective sizes; its medians are reloadable parameters.

    Raises
    ------
    InputError
        When no example knows a cell, there is nothing to learn by a name, an example has no speaker
        or there are fewer than two, the score is not a number, or draws are too few.

    Notes
    -----
    The score and the priors are those of `fit`, whose maximum is found first: chains start around
    it and move in the directions of its curvature. A speaker's number is the population's plus
    spread times a standard normal number; the spread has a half-normal prior of half a prior
    standard deviation. Under a model that gives words no probability the score is the log
    belief, which is no likelihood: its draws tell how sharply the score decides, and take far
    longer.
    """
    least_of = (("warmup", warmup, 1), ("draws", draws, _LEAST_DRAWS), ("chains", chains, 1))
    for name, value, least in least_of:
        if value < least:
            raise InputError(f"{name} is {value}; expected at least {least}")
    free = FreeParameters(model, learn)
    varied = [free.may_vary(name) for name in dict.fromkeys(vary)]
    speakers = _speakers(examples) if varied else ()
    pooled = supervised_score(examples, free)
    top, _ = maximise(free, pooled, iterations=60, progress=progress)
    covariance = curvature(free, pooled, top)
    target = _Target(free, supervised_score(examples, free, speakers), varied, top, covariance)
    found, diverged = [], 0
    for i in range(chains):

        def notify(line: str, which: int = i) -> None:
            if progress:
                progress(f"chain {which + 1} of {chains}: {line}")

        with seeded_torch(child(rng, "chain", i)):
            drawn, bad = _chain(target, len(speakers), warmup, draws, notify)
        found.append(drawn)
        diverged += bad
    together = {name: torch.stack([one[name] for one in found]) for name in found[0]}
    provenance = {
        "objective": f"{pooled.score_name}, priors as declared",
        "seed": _seed(rng),
        "examples": len(examples),
        "targets": pooled.size,
        "speakers": len(speakers),
        "vary": list(dict.fromkeys(vary)),
        "chains": chains,
        "warmup": warmup,
        "draws": draws,
        "divergences": diverged,
        "versions": _versions(),
    }
    return ParameterDraws(model.name, _dataset(target, together, speakers), provenance)


class _Target:
    """The density that is drawn from.

    Its coordinates: ``numbers`` (P,), the population's, whitened around the maximum; and where
    parameters vary, ``log_spread`` (V,) and ``offset`` (V, speakers), standard normal.
    """

    def __init__(
        self,
        free: FreeParameters,
        score: SupervisedScore,
        varied: Sequence[int],
        top: Tensor,
        covariance: Tensor | None,
    ) -> None:
        self.free, self.varied = free, tuple(varied)
        self._score, self._top = score, top
        flat = torch.eye(len(top), dtype=torch.float64)
        self._factor = flat if covariance is None else torch.linalg.cholesky(covariance)

    def numbers(self, at: Mapping[str, Tensor]) -> Tensor:
        """Return the population's standard normal numbers, shape (..., P)."""
        return self._top + at["numbers"] @ self._factor.T

    def deviations(self, at: Mapping[str, Tensor]) -> dict[int, Tensor]:
        """Return number -> how far each speaker's is from the population's, (..., speakers)."""
        if not self.varied:
            return {}
        each = at["log_spread"].exp()[..., None] * at["offset"]
        return {i: each[..., v, :] for v, i in enumerate(self.varied)}

    def potential(self, at: Mapping[str, Tensor]) -> Tensor:
        """Return minus the log density, a number."""
        z = self.numbers(at)
        total = 0.5 * (z - self.free.centre).square().sum()
        if self.varied:
            spread = at["log_spread"].exp()
            total = total + 0.5 * (spread / _SPREAD_SCALE).square().sum() - at["log_spread"].sum()
            total = total + 0.5 * at["offset"].square().sum()
        return total - self._score.scores(self.free, z, self.deviations(at)).sum()

    def start(self, speakers: int) -> dict[str, Tensor]:
        """Return a place around the maximum, drawn from torch's generator."""
        at = {"numbers": torch.randn(len(self._top), dtype=torch.float64)}
        if self.varied:
            shape = (len(self.varied), speakers)
            at["log_spread"] = 0.3 * torch.randn(shape[0], dtype=torch.float64) - 1.5
            at["offset"] = torch.randn(shape, dtype=torch.float64)
        return at


def _chain(
    target: _Target, speakers: int, warmup: int, draws: int, notify: Callable[[str], None]
) -> tuple[dict[str, Tensor], int]:
    """Return the draws of one chain, each (draws, ...), and how many steps diverged."""
    kernel = NUTS(potential_fn=target.potential, max_tree_depth=6)
    every = max(1, (warmup + draws) // 10)

    def hook(_kernel: Any, _at: Any, stage: str, i: int) -> None:
        if (i + 1) % every == 0:
            notify(f"{stage.lower()} step {i + 1}")

    chain = MCMC(
        kernel,
        num_samples=draws,
        warmup_steps=warmup,
        initial_params=target.start(speakers),
        hook_fn=hook,
        disable_progbar=True,
    )
    with torch.enable_grad():
        chain.run()
    return chain.get_samples(), len(chain.diagnostics()["divergences"]["chain 0"])


def _speakers(examples: Sequence[Example]) -> tuple[str, ...]:
    speakers = tuple(sorted({example.speaker for example in examples if example.speaker}))
    if len(speakers) < 2:
        raise InputError(
            f"The examples have {len(speakers)} speakers; expected at least two for parameters to "
            "vary between: leave vary out"
        )
    return speakers


def _dataset(
    target: _Target, drawn: Mapping[str, Tensor], speakers: Sequence[str]
) -> xarray.Dataset:
    """Return values of parameters, from draws of coordinates of shape (chains, draws, ...)."""
    import xarray

    free, z = target.free, target.numbers(drawn)
    values = free.values(z)
    variables: dict[str, tuple[tuple[str, ...], Any, dict[str, str]]] = {}
    parts: dict[str, Tensor] = {}
    for section, named in free.by_section(values).items():
        if section == "weights":
            parts = named
            shares = torch.stack(list(parts.values()), -1).numpy()
            variables["weights"] = (("chain", "draw", "component"), shares, {"section": section})
            continue
        for name, value in named.items():
            variables[name] = (("chain", "draw"), value.numpy(), {"section": section})
    for v, (i, offset) in enumerate(target.deviations(drawn).items()):
        name = free.names[i]
        own = z[..., None, :].repeat(1, 1, len(speakers), 1)
        own[..., i] += offset
        each = free.values(own)[name]
        spread = drawn["log_spread"][..., v].exp() * free.scale(i)
        variables[f"{name}_by_speaker"] = (("chain", "draw", "speaker"), each.numpy(), {})
        variables[f"{name}_spread"] = (("chain", "draw"), spread.numpy(), {})
    coords = {"chain": np.arange(z.shape[0]), "draw": np.arange(z.shape[1])}
    labels = {"component": list(parts), "speaker": list(speakers)}
    return xarray.Dataset(variables, coords | {k: v for k, v in labels.items() if v})


def _seed(rng: np.random.Generator) -> str:
    sequence: Any = rng.bit_generator.seed_seq
    key = "".join(f"/{part}" for part in sequence.spawn_key)
    return f"{sequence.entropy}{key}"


def _versions() -> dict[str, str]:
    packages = {name: version(name) for name in ("sloop-ppl", "torch", "pyro-ppl", "numpy")}
    return {"python": platform.python_version(), **packages}
