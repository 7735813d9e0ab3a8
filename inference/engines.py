"""Inference engines, as values with options: each runs the program its own way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference._enumeration import PYRO_LOCK, description_tables
from sloop_ppl.inference._frame_draws import draw_frame, framed_sites
from sloop_ppl.models import Program, ProgramData
from sloop_ppl.registry import Registry

__all__ = [
    "ENGINES",
    "Engine",
    "Enumerate",
    "Exact",
    "Importance",
    "InferenceInfo",
    "engine_of",
    "positive",
    "required",
]

Tables = tuple[NDArray[np.float64], ...]
"""Per target, log of component weight times likelihood, shape (V..., K, S); see `Engine`."""

_MOST_NUMBERS = 4_000_000
"""Of one chunk of draws, 32 MB in float64."""


@dataclass(frozen=True)
class InferenceInfo:
    """How an inference went.

    Parameters
    ----------
    engine
        The engine's name.
    seconds
        Wall time it took.
    log_evidence
        Log probability of what was said, summed over targets; it carries the model's
        normalisation, so it does not rank models.
    not_located
        Targets of which nothing was said; their belief is their prior.
    """

    engine: str
    seconds: float
    log_evidence: float
    not_located: tuple[str, ...] = ()


@runtime_checkable
class Engine(Protocol):
    """Weigh what was said of each target by running the program.

    Shape legend: V values of each latent that phrases share, K components, S cells.
    """

    @property
    def name(self) -> str:
        """What it is called."""

    def weigh(self, data: ProgramData, rng: np.random.Generator | None) -> Tables:
        """Return the log factors of a description.

        Parameters
        ----------
        data
            What the program is run on; its priors of cells are where draws are worth making.
        rng
            Where an engine that draws does so; ignored by the others.

        Returns
        -------
        tuple of numpy.ndarray
            Per target, log of component weight times likelihood given the shared latents, shape
            (V..., K, S); the priors of cells and of shared latents are left out.
        """


ENGINES: Registry[Engine] = Registry("engine")
"""Inference engines by name, with their default options."""


def engine_of(engine: str | Engine) -> Engine:
    """Return the engine of a name, or an engine as it is.

    Raises
    ------
    UnknownName
        When there is no engine of the name.
    InputError
        When it is neither a name nor an engine.
    """
    if isinstance(engine, str):
        return ENGINES[engine]
    if isinstance(engine, type) or not isinstance(engine, Engine):
        kind = engine.__name__ if isinstance(engine, type) else type(engine).__name__
        a = "the class" if isinstance(engine, type) else "a"
        raise InputError(
            f"Engine is {a} {kind}; expected one of the names {', '.join(ENGINES)}, or an engine "
            "with its options, such as sloop_ppl.inference.Importance(draws=1000)"
        )
    return engine


@dataclass(frozen=True)
class Exact:
    """Enumerate component, cell and shared latents; frames summed out in closed form.

    Notes
    -----
    The program run with ``frames="summed"``: frame, lapse and other latents of one phrase are
    summed out within the phrase, the frame by the likelihood's ``log_marginal`` where it has one.
    That is its one optimisation over `Enumerate`.
    """

    name: ClassVar[str] = "exact"

    def weigh(
        self,
        data: ProgramData,
        rng: np.random.Generator | None = None,  # noqa: ARG002 - nothing is drawn
    ) -> Tables:
        """Return the log factors; see `Engine`."""
        with torch.no_grad():
            return _numpy(description_tables(Program(data, "summed")))


@dataclass(frozen=True)
class Enumerate:
    """Enumerate every latent of the program, frames on angle bins and lapses too.

    The parity reference of `Exact`, for grids up to 41 x 41.

    Parameters
    ----------
    frame_bins
        Angle bins of each frame, > 0.
    """

    frame_bins: int = 1440
    name: ClassVar[str] = "enumerate"

    def __post_init__(self) -> None:
        positive(self, "frame_bins")

    def weigh(
        self,
        data: ProgramData,
        rng: np.random.Generator | None = None,  # noqa: ARG002 - nothing is drawn
    ) -> Tables:
        """Return the log factors; see `Engine`."""
        with torch.no_grad():
            return _numpy(description_tables(Program(data, "bins", self.frame_bins)))


@dataclass(frozen=True)
class Importance:
    """Draw frames from their priors and enumerate all else.

    Parameters
    ----------
    draws
        Draws of each frame, > 0.

    Notes
    -----
    Frames are drawn in equal steps of their prior's mass, in random order: about a third less
    error than plain draws. The guide is the prior, so every draw has the same weight before the
    likelihood.
    """

    draws: int = 10_000
    name: ClassVar[str] = "importance"

    def __post_init__(self) -> None:
        positive(self, "draws")

    def weigh(self, data: ProgramData, rng: np.random.Generator | None) -> Tables:
        """Return the log factors; see `Engine`.

        Raises
        ------
        InputError
            When `rng` is missing.
        """
        generator = required(rng, self.name)
        program = Program(data, "density")
        priors = framed_sites(data)
        drawn = {
            name: torch.from_numpy(draw_frame(prior, self.draws, generator))
            for name, prior in priors.items()
        }
        if not drawn:
            return _numpy(description_tables(program))
        shared = math.prod(len(latent.support) for latent in data.shared)
        step = max(1, _MOST_NUMBERS // (shared * len(data.model.components) * data.n_cells))
        totals: list[Tensor] = []
        with torch.no_grad(), PYRO_LOCK:
            for start in range(0, self.draws, step):
                some = {name: angles[start : start + step] for name, angles in drawn.items()}
                parts = [torch.logsumexp(t, 0) for t in description_tables(program, some)]
                if totals:
                    pairs = zip(totals, parts, strict=True)
                    parts = [torch.logaddexp(total, part) for total, part in pairs]
                totals = parts
        return _numpy([total - math.log(self.draws) for total in totals])


def positive(engine: object, *options: str) -> None:
    """Refuse options that are no whole number above 0.

    Raises
    ------
    InputError
        When one is not.
    """
    for option in options:
        value: Any = getattr(engine, option)
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise InputError(
                f"{type(engine).__name__} has {option} {value!r}; expected a whole number above 0"
            )


def required(rng: np.random.Generator | None, engine: str) -> np.random.Generator:
    """Return a generator, or refuse to draw without one."""
    if rng is None:
        raise InputError(f"Engine '{engine}' draws; give rng=numpy.random.default_rng(seed)")
    return rng


def _numpy(tables: Sequence[Tensor]) -> Tables:
    return tuple(np.ascontiguousarray(table.numpy()) for table in tables)


ENGINES.add("exact", Exact())
ENGINES.add("enumerate", Enumerate())
ENGINES.add("importance", Importance())
ENGINES.add_later("nuts", "sloop_ppl.inference.sampling", "PLAIN_NUTS")
ENGINES.add_later("svi", "sloop_ppl.inference.sampling", "PLAIN_SVI")
