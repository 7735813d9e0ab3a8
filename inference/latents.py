"""What a posterior can be asked about its latents: components, frames, lapses, phrases."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from sloop_ppl.inference.draws import draws_from, uniforms_for
from sloop_ppl.inference.frames import FrameSummary, summarise_frames
from sloop_ppl.inference.fronts import find_framed
from sloop_ppl.inference.influence import Influence, influence_on
from sloop_ppl.inference.lapses import Lapse, lapses_of
from sloop_ppl.inference.tables import (
    component_probabilities,
    component_table,
    component_weights,
    frame_array,
    frame_table,
    responsibility_table,
)

if TYPE_CHECKING:
    import xarray

    from sloop_ppl.inference.posterior import Posterior
    from sloop_ppl.models.simulate import Simulated

__all__ = ["LatentQuestions"]


class LatentQuestions:
    """Every latent of a posterior: how probable, jointly with which cell, and who moved it.

    The part of :class:`sloop_ppl.inference.Posterior` that answers why a belief is where it is.
    """

    @property
    def _self(self) -> Posterior:
        """Itself, as the class that it is the part of."""
        return cast("Posterior", self)

    def component(self, target: str, which: int = -1) -> dict[str, float]:
        """Return the posterior probability of each component.

        Parameters
        ----------
        target : id of the target.
        which : which description about the target, the latest by default.

        Returns
        -------
        dict
            Component name -> probability; empty when nothing was said of the target.
        """
        return component_probabilities(self._self, target, which)

    def frames(self, target: str) -> tuple[FrameSummary, ...]:
        """Return the posterior of every frame that was used in speaking of a target.

        One entry per part of the frame's prior (a street has two normals, left and right have the
        map's frame and the ground's), in the order the relations were said.
        """
        return summarise_frames(self._self, target)

    def frame(
        self, target: str, ground: str | None = None, relation: int | None = None, bins: int = 72
    ) -> xarray.DataArray:
        """Return how probable each direction of a ground's front is.

        Parameters
        ----------
        target : id of the target it was said of.
        ground : id of the landmark; may be left out when the target has one frame only.
        relation : index in :meth:`relations`, when two relations speak of the same ground.
        bins : number of equal directions B, the first centred on east, anticlockwise.

        Returns
        -------
        xarray.DataArray
            Dim angle (radians), sums to one; its coordinate ``prior`` is what was believed before.

        Raises
        ------
        InputError : when nothing depends on a frame, or several frames fit.
        UnknownName : when there is no such target, or no frame of such a ground.
        """
        return frame_array(
            self._self, target, find_framed(self._self, target, ground, relation), bins
        )

    def joint(self, target: str, which: int = -1) -> xarray.DataArray:
        """Return p(component, cell), dims component, y, x, for one description of a target."""
        return component_table(self._self, target, which)

    def component_prior(self, target: str, which: int = -1) -> dict[str, float]:
        """Return the prior weight of each component of a description, 0 where it does not apply."""
        return component_weights(self._self, target, which)

    def joint_frame(
        self, target: str, relation: int | None = None, ground: str | None = None, bins: int = 72
    ) -> xarray.DataArray:
        """Return p(front, cell), dims angle, y, x, for one frame; arguments as in :meth:`frame`."""
        return frame_table(
            self._self, target, find_framed(self._self, target, ground, relation), bins
        )

    def responsibilities(self, target: str, which: int = -1) -> xarray.DataArray:
        """Return p(component | cell), dims component, y, x; NaN where the target cannot be."""
        return responsibility_table(self._self, target, which)

    def influence(
        self, target: str, rng: np.random.Generator | None = None
    ) -> tuple[Influence, ...]:
        """Return how many bits each relation moves the belief: inferred again without it.

        Parameters
        ----------
        target : id of the target.
        rng : wanted by engines that draw.
        """
        return influence_on(self._self, target, rng)

    def lapses(self, target: str) -> tuple[Lapse, ...]:
        """Return how probable it is that each relation of a target is wrong, given everything."""
        return lapses_of(self._self, target)

    def draws(self, target: str, n: int, *, rng: np.random.Generator) -> xarray.Dataset:
        """Draw cells, components and fronts together.

        Parameters
        ----------
        target : id of the target.
        n : how many, > 0.
        rng : where they are drawn from.

        Returns
        -------
        xarray.Dataset
            See :func:`sloop_ppl.inference.draws.draws_from`.
        """
        return draws_from(self._self, target, uniforms_for(self._self, target, n, rng))

    def utterances(
        self, target: str, n: int, *, rng: np.random.Generator, **options: Any
    ) -> tuple[Simulated, ...]:
        """Draw what would be said of a target, as far as is known where it is.

        Parameters
        ----------
        target : id of the target.
        n : how many descriptions, > 0.
        rng : where they are drawn from.
        **options : ``speaker``, ``phrases``, ``grounds``; see
            :func:`sloop_ppl.inference.utterances.utterances_about`.
        """
        from sloop_ppl.inference.utterances import utterances_about

        return utterances_about(self._self, target, n, rng=rng, **options)
