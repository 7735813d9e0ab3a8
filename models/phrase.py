"""A phrase under every value of the latents it depends on, and the frame that phrases share.

Shape legend: S cells; B angle bins of a frame.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.latents import Latent

__all__ = ["RELIABLE", "Phrase", "SharedFrame"]

RELIABLE = "reliable"
"""Name of the latent that tells whether anything a speaker says means anything."""


@dataclass(frozen=True, eq=False)
class SharedFrame:
    """The frame of a ground that several phrases of one speaker take the same way.

    Parameters
    ----------
    ground
        Id of the ground.
    angles_rad
        Directions it may face, radians, shape (B,).
    mass
        Their prior probabilities, summing to one, shape (B,).
    """

    ground: str
    angles_rad: NDArray[np.float64]
    mass: NDArray[np.float64]

    @property
    def name(self) -> str:
        """Name of its site."""
        return f"frame/{self.ground}"

    @property
    def support(self) -> tuple[float, ...]:
        """Its values, radians."""
        return tuple(map(float, self.angles_rad))

    @property
    def log_prior(self) -> Tensor:
        """Log prior of its values, shape (B,)."""
        return torch.from_numpy(np.log(np.maximum(self.mass, 1e-300)))  # far off, mass underflows


@dataclass(frozen=True, eq=False)
class Phrase:
    """A grounded relation under every value of the latents it depends on.

    Parameters
    ----------
    relation
        The relation as it was said.
    own
        Latents that concern this phrase alone.
    sizes
        Length of each leading axis of its tables: those of the shared latents, then of its own; 1
        for one that does not matter.
    meanings
        The relation under each combination of values, in row-major order of `sizes`.
    frames
        Prior of the frame for each of `meanings`, None for one without a frame; None when none has
        one.
    shared_axis
        Which shared latent is its frame, when that is shared.
    shared_angles
        Directions of that shared frame, radians, shape (B,).
    """

    relation: GroundedRelation
    own: tuple[Latent, ...]
    sizes: tuple[int, ...]
    meanings: tuple[GroundedRelation, ...]
    frames: tuple[FrameDistribution | None, ...] | None
    shared_axis: int | None = None
    shared_angles: Tensor | None = None

    @property
    def is_of_each_denied(self) -> bool:
        """Tell whether it denies several places: one table then, without frames of its own."""
        return any(self.relation.denied)

    def own_frames(self, site: str) -> dict[str, FrameDistribution]:
        """Return the frames that it may depend on, each at a site of its own.

        Parameters
        ----------
        site
            Name of the first; of the m-th other one ``site/m``.
        """
        known = [frame for frame in self.frames or () if frame is not None]
        return {
            site if m == 0 else f"{site}/{m}": frame for m, frame in enumerate(dict.fromkeys(known))
        }

    def unless_silent(self, log_p: Tensor, otherwise: float, after: int = 1) -> Tensor:
        """Return `log_p` where the phrase says anything and the speaker is reliable, else a number.

        Parameters
        ----------
        log_p
            Shape (..., sizes..., S), or (sizes..., B, S) with `after` 2.
        otherwise
            Log probability of a phrase that says nothing.
        after
            How many axes come after those of the latents.
        """
        says = [one.latents.get(RELIABLE, True) and not one.is_silent for one in self.meanings]
        if all(says):
            return log_p
        return torch.where(torch.tensor(says).reshape(*self.sizes, *(1,) * after), log_p, otherwise)

    def bins(self, count: int) -> tuple[Tensor, Tensor]:
        """Return angle bins of its frame and their log masses, shape (sizes..., B) each.

        A meaning without a frame, beside one with a frame, leaves that frame to its prior.
        """
        first = next(frame for frame in self.frames or () if frame is not None)
        each = [(frame or first).bins(count) for frame in self.frames or ()]
        longest = max(len(angles) for angles, _ in each)
        angles = np.stack([np.pad(a, (0, longest - len(a)), mode="edge") for a, _ in each])
        mass = np.stack([np.pad(m, (0, longest - len(m))) for _, m in each])
        log_mass = np.where(mass > 0, np.log(np.maximum(mass, 1e-300)), -np.inf)
        shape = (*self.sizes, longest)
        return torch.from_numpy(angles).reshape(shape), torch.from_numpy(log_mass).reshape(shape)

    def key(self, *, by_itself: bool) -> Hashable:
        """Return what phrases of one program have in common when their tables are the same.

        Parameters
        ----------
        by_itself
            True where a likelihood or frame prior from outside may look at the figure, or at the
            place of the relation in the description.
        """
        which = (self.relation.figure, self.relation.index, self.relation.description)
        own = tuple((latent.name, latent.prior) for latent in self.own)
        same = tuple(one.meaning for one in self.meanings), own, self.sizes, self.shared_axis
        return (*same, which) if by_itself else same

    def on_shared_axis(self, table: Tensor) -> Tensor:
        """Return a table (sizes..., B, S) with a shared frame's fronts on its latent's axis."""
        if self.shared_axis is None:
            return table
        return table.transpose(self.shared_axis, -2)

    def over_meanings(
        self, table: Callable[[GroundedRelation, Any], Tensor], each: Sequence[Any] | None = None
    ) -> Tensor:
        """Return the tables of every meaning, those of `meanings` along the leading axes.

        Parameters
        ----------
        table
            Takes a relation and what it is given of `each`; returns a table of shape (B, S) or
            (S,).
        each
            What `table` takes with each of `meanings`, such as its fronts; None for nothing.

        Returns
        -------
        Tensor
            Shape (sizes..., B, S).
        """
        given = each or (None,) * len(self.meanings)
        made: dict[Hashable, Tensor] = {}
        keys: list[Hashable] = []
        for n, (one, what) in enumerate(zip(self.meanings, given, strict=True)):
            # Readings and branches have meanings in common, and one that is silent needs no table.
            key: Hashable = (one.meaning, id(what)) if one.choices else n
            keys.append(None if one.is_silent else key)
            if not one.is_silent and key not in made:
                made[key] = table(one, what)
        cells = next((t.shape[-1] for t in made.values()), self.relation.n_cells)
        nothing = torch.zeros(1, cells, dtype=torch.float64)
        tables = [nothing if key is None else made[key] for key in keys]
        if len(tables) == 1:
            return tables[0].reshape(*self.sizes, -1, cells)
        rows = torch.broadcast_tensors(*(one.reshape(-1, cells) for one in tables))
        return torch.stack(rows).reshape(*self.sizes, -1, cells)
