"""The generative model with every latent a site of its own: a plain Pyro program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyro
import pyro.distributions as dist
import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models.atoms import Atoms
from sloop_ppl.models.evidence import Evidence, gather_evidence
from sloop_ppl.models.grounding import ground_description
from sloop_ppl.models.lookup import look_up
from sloop_ppl.models.phrases import front_prior, log_idle, log_phrase_given_front
from sloop_ppl.models.presets import Preset, preset
from sloop_ppl.models.terms import RelationTerm
from sloop_ppl.models.truth import TruthValue

__all__ = ["OpenProgram", "build"]

_MOST_NUMBERS = 200_000_000


@dataclass(frozen=True, eq=False)
class _Phrase:
    """One phrase: its own frame's angles, if it has any, and its truth table.

    `table` has the shape (K, C, lapses, B, S): component, setting of shared frames, meant or
    lapsed, own front, cell; an axis that does not matter has length 1.
    """

    atoms: Atoms | None
    lapse: float
    table: Tensor


@dataclass(frozen=True, eq=False)
class OpenProgram:
    """A Pyro program of a description; call it to run it.

    Sites, for each target T and its phrases j = 0, 1, ...: ``T/component``, ``T/cell``,
    ``T/frame_j`` (phrases that need a frame; radians), ``T/lapse_j`` (models with a lapse),
    ``T/truth_j`` (observed), and the factor ``T/normaliser``; ``shared`` when phrases share
    frames. Cells count row by row from the south-west.
    """

    targets: tuple[str, ...]
    evidence: Evidence
    log_prior: Tensor
    phrases: tuple[tuple[_Phrase, ...], ...]

    def __call__(self) -> dict[str, Tensor]:
        """Run the program; return the cell of each target."""
        shared = torch.tensor(0)
        if self.evidence.shared.grounds:
            shared = pyro.sample("shared", dist.Categorical(logits=self.evidence.shared.log_prior))
        cells = {}
        for i, target in enumerate(self.targets):
            component = pyro.sample(
                f"{target}/component", dist.Categorical(logits=self.evidence.log_weight[i])
            )
            cell = pyro.sample(f"{target}/cell", dist.Categorical(logits=self.log_prior[i]))
            normaliser = self.evidence.log_normaliser[:, i]
            pyro.factor(f"{target}/normaliser", look_up(normaliser, (shared, component, cell)))
            for j, phrase in enumerate(self.phrases[i]):
                front = lapsed = torch.tensor(0)
                if phrase.atoms is not None:
                    front = phrase.atoms.index(pyro.sample(f"{target}/frame_{j}", phrase.atoms))
                if phrase.lapse:
                    chance = torch.tensor(phrase.lapse, dtype=torch.float64)
                    lapsed = pyro.sample(f"{target}/lapse_{j}", dist.Bernoulli(chance)).long()
                setting = shared if phrase.table.shape[1] > 1 else torch.tensor(0)
                log_g = look_up(phrase.table, (component, setting, lapsed, front, cell))
                pyro.sample(f"{target}/truth_{j}", TruthValue(log_g), obs=torch.ones(()))
            cells[target] = cell
        return cells


def build(
    description: Description,
    city: CityMap,
    model: str | Preset = "bayes",
    *,
    log_prior: Tensor | None = None,
    frame_bins: int = 72,
) -> OpenProgram:
    """Return the generative model of a description as a plain Pyro callable.

    Parameters
    ----------
    description : what was said.
    city : the map.
    model : a model's name, or a Preset.
    log_prior : log belief over cells of each target, shape (N, S); uniform when None.
    frame_bins : angles that stand for each frame, > 0.

    Returns
    -------
    OpenProgram
        Takes no arguments. `poutine.condition`, `poutine.do`, `Predictive`, `TraceEnum_ELBO` and
        `pyro.render_model` work on it.

    Raises
    ------
    InputError : when the tables would not fit in memory; use fewer bins or a smaller map.

    Notes
    -----
    With the frames and lapses summed out this is the program of the exact engine. Tempering, the
    cut and the shared error are part of the factor ``normaliser``.

    Examples
    --------
    >>> import pyro
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> said = sloop.parse("the green toyota is behind velvet dog", city)
    >>> program = sloop.models.build(said, city, "bayes")
    >>> trace = pyro.poutine.trace(program).get_trace()
    >>> [name for name in trace.stochastic_nodes if "/" in name]
    ['GreenToyota/component', 'GreenToyota/cell', 'GreenToyota/frame_0', 'GreenToyota/lapse_0']
    """
    chosen = preset(model)
    targets = tuple(target.id for target in description.targets)
    terms = list(ground_description(description, city, chosen).values())
    return open_program(targets, terms, city, chosen, log_prior=log_prior, frame_bins=frame_bins)


def open_program(
    targets: tuple[str, ...],
    terms: list[tuple[RelationTerm, ...]],
    city: CityMap,
    model: Preset,
    *,
    log_prior: Tensor | None = None,
    truths: Sequence[tuple[float, float]] | None = None,
    frame_bins: int = 72,
) -> OpenProgram:
    """Return the program of grounded relations, one tuple of terms per target."""
    evidence = gather_evidence(terms, city, model, truths)
    if log_prior is None:
        shape = (len(targets), city.grid.size)
        log_prior = torch.full(shape, -np.log(city.grid.size), dtype=torch.float64)
    phrases = tuple(
        tuple(_phrase(j, said, i, evidence, model, frame_bins) for j in range(max(len(said), 1)))
        for i, said in enumerate(terms)
    )
    return OpenProgram(targets, evidence, log_prior, phrases)


def _phrase(
    j: int,
    said: tuple[RelationTerm, ...],
    i: int,
    evidence: Evidence,
    model: Preset,
    frame_bins: int,
) -> _Phrase:
    """Lay out one phrase's truth under every component, setting, lapse and front."""
    _, _, components, _, cells = evidence.log_truth.shape
    term = said[j] if said else None
    prior = None if term is None else front_prior(term, model)
    atoms, fronts = None, np.zeros(1)
    own = prior is not None and term is not None and term.ground not in evidence.shared.grounds
    if prior is not None and own and any(part.uses_frames for part in model.components):
        fronts, mass = prior.bins(frame_bins)
        atoms = Atoms(torch.from_numpy(fronts), torch.from_numpy(np.maximum(mass, 1e-300)).log())
    lapses = 2 if model.lapse and term is not None else 1
    settings = evidence.shared.size if prior is not None and not own else 1
    shape = (components, settings, lapses, len(fronts), cells)
    if np.prod(shape) > _MOST_NUMBERS:
        raise InputError(
            f"The open program of this description would need tables of {shape} numbers; use fewer "
            "frame_bins, a smaller map, or the exact engine"
        )
    table = torch.zeros(shape, dtype=torch.float64)
    for k, part in enumerate(model.components):
        if part.combine == "product" and part.read_as is None and term is not None:
            if part.keep_frames or not term.needs_frame:
                table[k] = _meant_and_lapsed(term, evidence, model, fronts, own=own, lapses=lapses)
        elif j == 0:
            # The phrases are read together; their one factor stands with the first of them.
            table[k] = evidence.log_truth[0, i, k, 0]
    return _Phrase(atoms, model.lapse if lapses == 2 else 0.0, table)


def _meant_and_lapsed(
    term: RelationTerm,
    evidence: Evidence,
    model: Preset,
    fronts: np.ndarray,
    *,
    own: bool,
    lapses: int,
) -> Tensor:
    """Return the log truth of one phrase, shape (C, lapses, B, S)."""
    shared = evidence.shared
    if own or front_prior(term, model) is None:
        meant = _given(term, model, fronts)[None]
    else:
        meant = _given(term, model, shared.fronts_rad[:, shared.grounds.index(term.ground)])[
            :, None
        ]
    if lapses == 1:
        return meant[:, None]
    return torch.stack([meant, torch.full_like(meant, log_idle(model, meant.shape[-1]))], 1)


def _given(term: RelationTerm, model: Preset, fronts: np.ndarray) -> Tensor:
    return log_phrase_given_front(term, model, fronts, lapse=False)
