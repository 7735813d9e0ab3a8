"""The latents of one phrase: its frame, its lapse and those declared for it, given all others.

Engines sum these out; they come back by running the program of that phrase alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.inference._enumeration import DRAW, enumerated_sites
from sloop_ppl.inference.joint import LogTable, sum_product
from sloop_ppl.models import (
    Component,
    FrameDistribution,
    GroundedRelation,
    Latent,
    Program,
    ProgramData,
)
from sloop_ppl.models.phrase import Phrase
from sloop_ppl.models.program import SummedPhrase, log_held, summed_phrase, with_lapse

__all__ = ["FRAME_BINS", "PhraseLatents", "PhraseTables", "latents_of_phrases"]

Table = NDArray[np.float64]

FRAME_BINS = 72
"""Angle bins of a frame in the joint posterior; the first is west, anticlockwise."""

_ALONE = "phrase"


@dataclass(frozen=True, eq=False)
class PhraseTables:
    """What one phrase says of the cells under each value of its own latents.

    Parameters
    ----------
    data
        What the description's program was run on.
    relation
        The grounded relation.
    """

    data: ProgramData
    relation: GroundedRelation

    @property
    def shared(self) -> tuple[str, ...]:
        """Names of the latents that phrases of the description share."""
        return tuple(latent.name for latent in self.data.shared)

    @cached_property
    def phrase(self) -> Phrase:
        """The phrase under every value of the latents it depends on."""
        return self.data.phrase(self.relation)

    @cached_property
    def log_phi(self) -> LogTable:
        """Log of the phrase's factor, its own latents summed out, over shared latents and cell."""
        return LogTable((*self.shared, "cell"), self._summed.log_phi)

    @property
    def log_phi_alone(self) -> Table:
        """Log of the phrase's factor had it been all that was said, shape (S,)."""
        with torch.no_grad():
            alone = summed_phrase(self._alone, self._alone.model.likelihood, self.relation).log_phi
        table: Table = alone.reshape(-1).numpy()
        return table

    @property
    def frame(self) -> FrameDistribution | None:
        """Prior of the frame that is the phrase's own; None when it has none or shares it.

        Raises
        ------
        InputError
            When it depends on another latent.
        """
        if self.phrase.frames is None or self.phrase.shared_angles is not None:
            return None
        known = {frame for frame in self.phrase.frames if frame is not None}
        if len(known) > 1:
            raise InputError(
                f"The frame of '{self.relation.relation} {self.relation.ground}' is another one "
                "under each value of another latent; ask for that latent first"
            )
        return next(iter(known))

    def log_phi_given_frame(
        self, angles_rad: Table, cells: NDArray[np.intp] | None = None
    ) -> Tensor:
        """Return what `log_phi_without_lapse` does with the lapse mixed in."""
        log_p = self.log_phi_without_lapse(angles_rad, cells)
        lapse = self.data.model.lapse_of(self.relation)
        return with_lapse(log_p, lapse, self.data.log_uninformative)

    def log_phi_without_lapse(
        self, angles_rad: Table, cells: NDArray[np.intp] | None = None
    ) -> Tensor:
        """Return the log of the phrase's factor for some directions its ground may face, if meant.

        Parameters
        ----------
        angles_rad
            Radians, shape (B,).
        cells
            Cells that are wanted, shape (C,); all of them when None.

        Returns
        -------
        Tensor
            Shape (B, V..., C), V the values of each shared latent; declared latents of its own
            are summed out, and there is no lapse.

        Notes
        -----
        The program is run on the wanted cells alone for log g; what divides it, the sum over the
        whole map, was kept when the phrase was weighed.
        """
        model, summed, own = self.data.model, self._summed, self.phrase.own
        relation = self.relation if cells is None else self.relation.at(cells)
        if self.frame is not None and self.frame.is_point:  # a site of its points, not of angles
            points = np.array([part.mean_rad for part in self.frame.parts])
            which = np.abs(np.angle(np.exp(1j * (angles_rad[:, None] - points)))).argmin(1)
            program = Program(self._raw(relation), "bins")
            tables = self._sites(program, None)[f"{_ALONE}/holds_0"]
            log_g = tables.aligned((f"{_ALONE}/frame_0", *self._axes))
            log_g = log_g[torch.from_numpy(which) if len(points) > 1 else which * 0]
        else:
            angles = torch.from_numpy(np.ascontiguousarray(angles_rad))
            program = Program(self._raw(relation), "density")
            given = {f"{_ALONE}/frame_0": angles}
            log_g = self._sites(program, given)[f"{_ALONE}/holds_0"].aligned((DRAW, *self._axes))
        peak = summed.log_peak if summed.log_peak.dim() == 1 else summed.log_peak[..., 0]
        log_p = log_held(log_g, self.relation, model, peak) - summed.log_z
        log_p = self.phrase.unless_silent(log_p, self.data.log_uninformative)
        for latent in reversed(own):
            log_p = torch.logsumexp(log_p + latent.log_prior[:, None], -2)
        return log_p

    def log_joint(self, own: Sequence[str], bins: int = FRAME_BINS) -> LogTable:
        """Return the log joint of latents of the phrase's own with its factor, priors included.

        Parameters
        ----------
        own
            ``"lapse"``, ``"frame"`` and names of declared latents, at least one.
        bins
            Angle bins of the frame.

        Returns
        -------
        LogTable
            Over `own`, shared latents and cell; summed over `own` it is `log_phi`.
        """
        if list(own) == ["lapse"]:  # no frame to look at: the closed form has all that is needed
            log_phi = self.log_phi.values
            lapse = self.data.model.lapse_of(self.relation)
            level = math.log(lapse) + self.data.log_uninformative
            lapsed = torch.full_like(log_phi, level)
            informative = log_phi + torch.log1p(-(lapsed - log_phi).exp().clamp_max(1.0))
            return LogTable(("lapse", *self.log_phi.latents), torch.stack([informative, lapsed]))
        if self.phrase.shared_angles is not None:
            raise InputError(
                f"'{self.relation.relation} {self.relation.ground}' shares its frame with other "
                f"phrases, so its latents {', '.join(own)} cannot be told by themselves; use a "
                "model without shared frames"
            )
        return self._table(Program(self._alone, "bins", bins), tuple(own))

    @cached_property
    def _summed(self) -> SummedPhrase:
        with torch.no_grad():
            return summed_phrase(self.data, self.data.model.likelihood, self.relation)

    @property
    def _axes(self) -> tuple[str, ...]:
        """The axes of the phrase's tables after that of the frame."""
        return (*self.shared, *(latent.name for latent in self.phrase.own), f"{_ALONE}/cell")

    def _raw(self, relation: GroundedRelation) -> ProgramData:
        """Return the program's data with an asserted phrase alone, of which nothing is divided."""
        is_generative = self.data.model.normalisation == "speaker"
        model = replace(
            self._alone.model,
            lapse=0.0,
            unreliable=0.0,
            normalisation="speaker" if is_generative else "truth",
        )
        log_prior = torch.zeros(1, relation.n_cells, dtype=torch.float64)
        return replace(
            self._alone,
            relations=((replace(relation, negated=False),),),
            model=model,
            log_prior=log_prior,
            tables={},
            phrases={},
        )

    def _sites(self, program: Program, given: dict[str, Tensor] | None) -> dict[str, LogTable]:
        with torch.no_grad():
            return enumerated_sites(program, given, lambda name: name == f"{_ALONE}/holds_0")

    @cached_property
    def _alone(self) -> ProgramData:
        """The program's data with this phrase alone, said literally and untempered."""
        model = replace(
            self.data.model,
            components=(Component("literal"),),
            shared_frames=False,
            temper=0.0,
            error_m=0.0,
            informed_sigma_m=None,
        )
        size = self.data.n_cells
        uniform = torch.full((1, size), -math.log(size), dtype=torch.float64)
        concerned = (
            latent
            for latent in self.data.shared
            if isinstance(latent, Latent) and latent.is_about(self.relation)
        )
        return ProgramData(
            (_ALONE,),
            ((self.relation,),),
            self.data.city,
            model,
            uniform,
            own=(*self.phrase.own, *concerned),
        )

    def log_prior(self, own: Sequence[str], bins: int = FRAME_BINS) -> LogTable:
        """Return the log joint prior of latents of the phrase's own."""
        return self._table(Program(self._alone, "bins", bins), tuple(own), prior=True)

    def _table(self, program: Program, keep: Sequence[str], *, prior: bool = False) -> LogTable:
        sites = {name: f"{_ALONE}/{name}_0" for name in ("lapse", "frame")}
        sites["cell"] = f"{_ALONE}/cell"
        wanted = tuple(sites.get(name, name) for name in (*keep, *self.shared, "cell"))
        left_out = {f"{_ALONE}/component", f"{_ALONE}/normaliser", sites["cell"], *self.shared}
        left_out |= {f"{_ALONE}/holds_0"} if prior else set()
        with torch.no_grad():
            tables = enumerated_sites(program, None, lambda name: name not in left_out)
            found = sum_product(list(tables.values()), wanted)
        names = {site: name for name, site in sites.items()}
        return LogTable(tuple(names.get(n, n) for n in found.latents), found.values)


@dataclass(frozen=True, eq=False)
class PhraseLatents:
    """The own latents of one phrase, by their names in the joint posterior.

    Parameters
    ----------
    data
        What the description's program was run on.
    target
        Id of the target.
    position
        Position of the phrase among those of the target.
    before
        How many relations of the target came before this description.
    called
        Site of the description's program -> its name in the joint posterior.
    """

    data: ProgramData
    target: str
    position: int
    before: int
    called: Callable[[str], str]

    @cached_property
    def tables(self) -> PhraseTables:
        """What the phrase says of the cells."""
        relations = self.data.relations[self.data.targets.index(self.target)]
        return PhraseTables(self.data, relations[self.position])

    @cached_property
    def reads(self) -> tuple[bool, ...]:
        """Per component, whether it takes the phrase as it was said."""
        i = self.data.targets.index(self.target)
        return tuple(map(bool, self.data.reads[i][self.position]))

    @cached_property
    def names(self) -> dict[str, str]:
        """``"lapse"``, ``"frame"`` or a declared latent -> its name in the joint posterior.

        None are of a phrase that no component reads: the program has no such sites either.
        """
        if not any(self.reads):
            return {}
        phrase, j = self.tables.phrase, self.before + self.position
        names = {latent.name: self.called(latent.name) for latent in phrase.own}
        if self.data.model.lapse_of(self.tables.relation):
            names["lapse"] = f"{self.target}/lapse_{j}"
        if phrase.frames is not None and phrase.shared_angles is None:
            names["frame"] = f"{self.target}/frame_{j}"
        return names

    @property
    def others(self) -> dict[str, str]:
        """Names in the joint posterior of ``"component"``, ``"cell"`` and the shared latents."""
        others = {latent.name: self.called(latent.name) for latent in self.data.shared}
        component = self.called(f"{self.target}/component")
        return others | {"component": component, "cell": f"{self.target}/cell"}

    def support(self, name: str) -> Sequence[Any]:
        """Return the values of the latent that has this name in the joint posterior."""
        own = next(key for key, called in self.names.items() if called == name)
        if own == "lapse":
            return (False, True)
        if own == "frame":
            angles, _ = self.tables.phrase.bins(FRAME_BINS)
            return tuple(map(float, angles.reshape(-1, angles.shape[-1])[0]))
        return next(latent.support for latent in self.tables.phrase.own if latent.name == own)

    def log_conditional(self, asked: Sequence[str]) -> LogTable:
        """Return log p(asked | component, cell, shared latents), the axes of `asked` first.

        Parameters
        ----------
        asked
            Names in the joint posterior of some of its latents.
        """
        own = [key for key, name in self.names.items() if name in asked]
        joint, prior = self.tables.log_joint(own), self.tables.log_prior(own)
        rest = tuple(name for name in joint.latents if name not in own)
        axes = (*own, *rest)
        # A support of one value has an impossible twin in the program.
        within = tuple(slice(0, len(self.support(self.names[name]))) for name in own)
        log_p = joint.aligned(axes)[within]
        log_p = log_p - torch.logsumexp(log_p, tuple(range(len(own))), keepdim=True)
        unread = prior.aligned(axes)[within].expand(log_p.shape)
        each = torch.stack([log_p if reads else unread for reads in self.reads], -1)
        called = {**self.names, **self.others}
        return LogTable((*(called[name] for name in axes), called["component"]), each)


def latents_of_phrases(
    data: ProgramData, target: str, first: int, name: Callable[[str], str]
) -> tuple[PhraseLatents, ...]:
    """Return the own latents of every phrase about a target.

    Parameters
    ----------
    first
        How many relations of it came before this description.
    name
        Site of the description's program -> its name in the joint posterior.
    """
    relations = data.relations[data.targets.index(target)]
    return tuple(PhraseLatents(data, target, j, first, name) for j in range(len(relations)))
