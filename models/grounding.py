"""What a description becomes on a map before the program runs: relations, latents, readings.

Shape legend: S cells; K components; V values of each latent that phrases share.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models._guard import trusted
from sloop_ppl.models._logspace import log_normalise
from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import (
    GroundedRelation,
    as_vocabulary_word,
    ground_relations,
    with_hearer,
)
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.presets import ObservationModel
from sloop_ppl.models.target_grounds import split_by_targets, target_ids

__all__ = [
    "Phrase",
    "ProgramData",
    "SharedFrame",
    "ground_description",
    "latents_of",
    "program_data",
    "true_places",
]

RELIABLE = "reliable"
"""Name of the latent that tells whether anything a speaker says means anything."""

_RESERVED = (
    *("angle", "cell", "component", "cut", "draw", "frame", "holds", "lapse", "normaliser"),
    *("phrase", "prior", RELIABLE, "shared_error", "targets", "temper", "together", "x", "y"),
)
"""Names of the program's sites and of the axes of tables."""

MOST_SETTINGS = 5184
"""Joint values of shared latents that are enumerated."""

_SHARED_BINS = {1: 72, 2: 36}
"""Angle bins of each frame when so many are shared."""


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
        return torch.from_numpy(np.log(np.maximum(self.mass, 1e-300)))


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

    def if_reliable(self, log_p: Tensor, otherwise: float, after: int = 1) -> Tensor:
        """Return `log_p` where the speaker is reliable, else a number.

        Parameters
        ----------
        log_p
            Shape (..., sizes..., S), or (sizes..., B, S) with `after` 2.
        otherwise
            Log probability of a phrase that says nothing.
        after
            How many axes come after those of the latents.
        """
        if RELIABLE not in self.meanings[0].latents:
            return log_p
        reliable = torch.tensor([one.latents[RELIABLE] for one in self.meanings])
        return torch.where(reliable.reshape(*self.sizes, *(1,) * after), log_p, otherwise)

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
        tables = [table(*one) for one in zip(self.meanings, given, strict=True)]
        cells = tables[0].shape[-1]
        if len(tables) == 1:
            return tables[0].reshape(*self.sizes, -1, cells)
        rows = torch.broadcast_tensors(*(one.reshape(-1, cells) for one in tables))
        return torch.stack(rows).reshape(*self.sizes, -1, cells)


@dataclass(frozen=True, eq=False)
class ProgramData:
    """What the program is run on: grounded relations, priors and the latents between them.

    Parameters
    ----------
    targets
        Ids of the targets, N of them.
    relations
        Per target, its grounded relations.
    city, model
        The map and the observation model.
    log_prior
        Log prior over cells of each target, shape (N, S).
    shared
        Latents that several phrases depend on: frames, and declared ones.
    truths
        True places of the targets, metres, for a model that is told them.
    number_priors
        Parameter of the likelihood -> distribution that it is drawn from.
    own
        Declared latents that one phrase each depends on.
    to_targets
        Target -> its relations to other targets, which no table over its cells can hold; here they
        only count as phrases.
    """

    targets: tuple[str, ...]
    relations: tuple[tuple[GroundedRelation, ...], ...]
    city: CityMap
    model: ObservationModel
    log_prior: Tensor
    shared: tuple[SharedFrame | Latent, ...] = ()
    truths: tuple[tuple[float, float], ...] | None = None
    number_priors: Mapping[str, Any] = field(default_factory=dict)
    own: tuple[Latent, ...] = ()
    to_targets: Mapping[str, tuple[GroundedRelation, ...]] = field(default_factory=dict)
    tables: dict[Any, Any] = field(default_factory=dict, repr=False)
    phrases: dict[int, Phrase] = field(default_factory=dict, repr=False)

    @cached_property
    def reads(self) -> tuple[tuple[Tensor, ...], ...]:
        """Which components read each phrase of each target as it was said, shape (K,) each.

        A component that does not apply has no weight, so what it would read does not matter; it
        counts as reading all, which spares an axis where the others do.
        """
        found = []
        for relations in self.relations:
            skipped = [not self.applies(part, relations) for part in self.model.components]
            rows = [
                [part.reads(r) or i for part, i in zip(self.model.components, skipped, strict=True)]
                for r in relations
            ]
            found.append(tuple(map(torch.tensor, rows)))
        return tuple(found)

    @cached_property
    def n_phrases(self) -> tuple[Tensor, ...]:
        """How many phrases each component reads of each target, at least 1, (K, 1..., 1) each.

        A phrase that is said of each of several grounds is one.
        """
        shape = (-1, *(1,) * (len(self.shared) + 1))
        every = [
            phrases + self.to_targets.get(target, ())
            for target, phrases in zip(self.targets, self.relations, strict=True)
        ]
        return tuple(
            torch.tensor(
                [max(_count(part.terms_it_reads(phrases)), 1) for part in self.model.components],
                dtype=torch.float64,
            ).reshape(shape)
            for phrases in every
        )

    def power_of(self, term: GroundedRelation) -> float:
        """Return the exponent that tempering gives a relation to another target."""
        i = self.targets.index(term.figure)
        n = _count(self.relations[i] + self.to_targets.get(term.figure, ()))
        return float(n ** -float(self.model.temper))

    @cached_property
    def cuts(self) -> Tensor:
        """Which components cut cells below uniform, shape (K, 1..., 1)."""
        cut = torch.tensor([part.cut for part in self.model.components])
        return cut.reshape(-1, *(1,) * (len(self.shared) + 1))

    @cached_property
    def log_uninformative(self) -> float:
        """Log probability of a phrase that says nothing, the same at every cell."""
        return self.model.log_uninformative(self.n_cells)

    def some(self, which: Sequence[int]) -> ProgramData:
        """Return the same for some of the targets; tables made for one are there for the other."""
        return replace(
            self,
            targets=tuple(self.targets[i] for i in which),
            relations=tuple(self.relations[i] for i in which),
            log_prior=self.log_prior[list(which)],
            truths=self.truths and tuple(self.truths[i] for i in which),
        )

    @cached_property
    def shares_tables(self) -> bool:
        """Tell whether phrases that mean the same may share their tables.

        They may where the likelihood and the frame prior are of this package: these look at what a
        relation means, and not at whose it is.
        """
        return trusted(self.model.likelihood) and _is_ours(self.model.frame_prior)

    def _check_meanings(
        self, relation: GroundedRelation, meanings: Sequence[GroundedRelation], *, has_frame: bool
    ) -> None:
        """Refuse what a latent may not change.

        Raises
        ------
        InputError
            When it changes whether the relation is denied, or the ground of a shared frame.
        """
        if len(meanings) == 1:
            return
        phrase = f"'{relation.relation} {relation.ground}'"
        if any(one.negated != relation.negated for one in meanings):
            raise InputError(
                f"A latent changes whether {phrase} is denied; expected it to leave `negated` alone"
            )
        shared = {v.ground for v in self.shared if isinstance(v, SharedFrame)}
        grounds = {one.ground for one in meanings}
        if has_frame and len(grounds) > 1 and shared & (grounds | {relation.ground}):
            raise InputError(
                f"A latent changes the ground of {phrase}, whose frame phrases share; use a model "
                "without shared frames"
            )

    def is_located(self, i: int) -> bool:
        """Tell whether anything was said of the target at position i."""
        return bool(self.relations[i]) or self.truths is not None

    @property
    def n_cells(self) -> int:
        """How many cells the tables are of."""
        return self.city.grid.size

    @cached_property
    def log_weight(self) -> Tensor:
        """Log prior weight of each component, -inf where it does not apply, shape (N, K)."""
        return log_normalise(
            torch.tensor(
                [
                    [
                        math.log(part.weight) if self.applies(part, relations) else -math.inf
                        for part in self.model.components
                    ]
                    for relations in self.relations
                ],
                dtype=torch.float64,
            )
        )

    def framed_phrases(self) -> Iterator[tuple[str, int, Phrase]]:
        """Yield target, position and phrase of every frame that the program draws by itself.

        A phrase that no component reads as it was said has no sites but ``holds``.
        """
        for i, target in enumerate(self.targets):
            for j, relation in enumerate(self.relations[i]):
                phrase = self.phrase(relation)
                own = phrase.frames is not None and phrase.shared_angles is None
                if own and bool(self.reads[i][j].any()):
                    yield target, j, phrase

    @property
    def holders(self) -> dict[str, set[str]]:
        """Shared latent -> the targets of which a phrase depends on it."""
        found: dict[str, set[str]] = {latent.name: set() for latent in self.shared}
        for target, relations in zip(self.targets, self.relations, strict=True):
            for phrase in map(self.phrase, relations):
                for axis, latent in enumerate(self.shared):
                    if phrase.sizes[axis] > 1 or phrase.shared_axis == axis:
                        found[latent.name].add(target)
        return found

    @property
    def log_shared(self) -> Tensor:
        """Log prior of the joint values of the shared latents, shape (V..., 1)."""
        total = torch.zeros((1,) * (len(self.shared) + 1), dtype=torch.float64)
        for axis, latent in enumerate(self.shared):
            shape = [1] * (len(self.shared) + 1)
            shape[axis] = -1
            total = total + latent.log_prior.reshape(shape)
        return total

    def applies(self, part: Component, relations: tuple[GroundedRelation, ...]) -> bool:
        """Tell whether a component has anything to say of a target.

        Of a target of which nothing was said the first component stands for all.
        """
        if self.model.needs_truth or not relations:
            return self.model.needs_truth or part == self.model.components[0]
        return bool(part.terms_it_reads(relations))

    def phrase(self, relation: GroundedRelation) -> Phrase:
        """Return a relation under every value of the latents that it depends on; made once."""
        key = id(relation)
        if key not in self.phrases:
            self.phrases[key] = self._phrase(relation)
        return self.phrases[key]

    def _phrase(self, relation: GroundedRelation) -> Phrase:
        own = tuple(latent for latent in self.own if latent.is_about(relation))
        concerned = [
            latent if isinstance(latent, Latent) and latent.is_about(relation) else None
            for latent in (*self.shared, *own)
        ]
        supports = [(None,) if a is None else a.support for a in concerned]
        meanings = []
        for values in itertools.product(*supports):
            one = relation
            for latent, value in zip(concerned, values, strict=True):
                one = one if latent is None else latent.apply(one, value)
            meanings.append(one)
        if self.model.normalisation == "speaker":
            meanings = [as_vocabulary_word(one) for one in meanings]
        frames = tuple(self.model.frame_prior_for(one) for one in meanings)
        has_frame = any(frame is not None for frame in frames)
        self._check_meanings(relation, meanings, has_frame=has_frame)
        sizes = tuple(len(support) for support in supports)
        found = Phrase(relation, own, sizes, tuple(meanings), frames if has_frame else None)
        for axis, shared in enumerate(self.shared):
            if has_frame and isinstance(shared, SharedFrame) and shared.ground == relation.ground:
                angles = torch.from_numpy(shared.angles_rad)
                return replace(found, shared_axis=axis, shared_angles=angles)
        return found


def latents_of(model: ObservationModel) -> tuple[Latent, ...]:
    """Return the latents of a model: declared, of its likelihood, and the speaker's reliability."""
    declared = _declared(model)
    if not model.unreliable:
        return declared
    shares = (1 - model.unreliable, model.unreliable)
    return (*declared, Latent(RELIABLE, (True, False), shares))


def _declared(model: ObservationModel) -> tuple[Latent, ...]:
    return (*model.latents, *getattr(model.likelihood, "latents", ()))


def ground_description(
    description: Description | Sequence[Description],
    city: CityMap,
    model: ObservationModel,
    others: Collection[str] = (),
) -> dict[str, tuple[GroundedRelation, ...]]:
    """Return target -> its grounded relations, in the order of the description's targets.

    Parameters
    ----------
    description
        What was said, or all that one speaker said: relations of later texts count on.
    city
        The map.
    model
        The observation model; its `joint_grounds` and `heed_distance` decide what a relation to
        several grounds and a said distance mean.
    others
        Ids of targets that were spoken of before. Relations to a target are left out: they say how
        two targets lie apart; see
        :func:`sloop_ppl.models.target_grounds.ground_target_relations`.

    Raises
    ------
    UnknownName
        When a ground is not on the map.
    DescriptionError
        When a ground is who listens, and the description does not say where that is.
    """
    texts = (description,) if isinstance(description, Description) else tuple(description)
    known = target_ids(texts, city, others)
    grounded: dict[str, tuple[GroundedRelation, ...]] = {}
    counts: Counter[str] = Counter()
    for position, text in enumerate(texts):
        for target in text.targets:
            relations = text.about(target.id)
            if not model.heed_distance:
                relations = tuple(replace(r, distance_m=None, distance=None) for r in relations)
            terms = _grounded(relations, city, model, known)
            terms = with_hearer(terms, text.hearer)
            if position:
                terms = tuple(
                    replace(term, index=term.index + counts[target.id], description=position)
                    for term in terms
                )
            grounded[target.id] = grounded.get(target.id, ()) + terms
            counts[target.id] += len(relations)
    return grounded


def _grounded(
    relations: Sequence[SpatialRelation],
    city: CityMap,
    model: ObservationModel,
    targets: Collection[str],
) -> tuple[GroundedRelation, ...]:
    """Return the terms of what relations say of places, those to targets left out."""
    terms: list[GroundedRelation] = []
    for index, relation in enumerate(relations):
        of_places, _ = split_by_targets(relation, targets)
        if of_places is not None:
            some = ground_relations((of_places,), city, joint=model.joint_grounds)
            terms += [replace(term, index=index) for term in some]
    return tuple(terms)


def _count(relations: Sequence[GroundedRelation]) -> int:
    """Return the number of phrases that grounded relations make up."""
    each = {(one.description, one.index) for one in relations if one.each}
    return len(each) + sum(not one.each for one in relations)


def _is_ours(value: object) -> bool:
    """Tell whether a frame prior, and what it rests on, is of this package."""
    inner = [getattr(value, name, None) for name in ("predictor", "otherwise")]
    ours = type(value).__module__.split(".")[0] == "sloop_ppl"
    return ours and all(one is None or _is_ours(one) for one in inner)


def true_places(
    truth: Mapping[str, tuple[float, float]] | None, targets: Sequence[str], model: ObservationModel
) -> tuple[tuple[float, float], ...] | None:
    """Return the true place of each target, for a model that is told them; else None.

    Raises
    ------
    InputError
        When one is missing.
    """
    if not model.needs_truth:
        return None
    for target in targets:
        if truth is None or target not in truth:
            raise InputError(
                f"Model '{model.name}' needs to be told where '{target}' is; give its place "
                f"(truth={{'{target}': (x_m, y_m)}} in Python; --place {target}=x,y to search)"
            )
    return tuple((truth or {})[target] for target in targets)


def program_data(
    grounded: Mapping[str, tuple[GroundedRelation, ...]],
    city: CityMap,
    model: ObservationModel,
    log_prior: Tensor | None = None,
    *,
    truths: Sequence[tuple[float, float]] | None = None,
    number_priors: Mapping[str, Any] | None = None,
    to_targets: Mapping[str, tuple[GroundedRelation, ...]] | None = None,
) -> ProgramData:
    """Return what the program is run on.

    Parameters
    ----------
    grounded
        Target -> its grounded relations.
    city, model
        The map and the observation model.
    log_prior
        Log prior over cells of each target, shape (N, S); uniform when None.
    truths
        True places, metres, one for each target; wanted by models that need them, else ignored.
    number_priors
        Parameter of the likelihood -> distribution that it is drawn from.
    to_targets
        Target -> its relations to other targets; they count as phrases.

    Raises
    ------
    InputError
        When the model needs the true places and got none, two latents have one name, or more
        frames are shared than can be enumerated.
    """
    if model.needs_truth and truths is None:
        raise InputError(
            f"Model '{model.name}' needs to be told where the targets are; give truth="
            "{target: (x_m, y_m)}"
        )
    targets = tuple(grounded)
    if log_prior is None:
        size = city.grid.size
        log_prior = torch.full((len(targets), size), -math.log(size), dtype=torch.float64)
    relations = tuple(grounded.values())
    every = [relation for phrases in relations for relation in phrases]
    frames = _shared_frames(every, model)
    placed = [(t, j, r) for t, phrases in grounded.items() for j, r in enumerate(phrases)]
    latents = tuple(one for latent in latents_of(model) for one in latent.each(placed))
    declared = tuple(
        latent for latent in latents if sum(latent.is_about(relation) for relation in every) != 1
    )
    names = [latent.name for latent in _declared(model)]
    _check_names(names, targets, frames, number_priors or {})
    _check_sites([latent.name for latent in latents])
    _check_shared((*frames, *declared), model)
    return ProgramData(
        targets,
        relations,
        city,
        model,
        log_prior,
        (*frames, *declared),
        tuple(truths) if truths is not None and model.needs_truth else None,
        dict(number_priors or {}),
        tuple(latent for latent in latents if latent not in declared),
        to_targets or {},
    )


def _shared_frames(
    every: Sequence[GroundedRelation], model: ObservationModel
) -> tuple[SharedFrame, ...]:
    """Return the frames that a model lets several phrases share.

    A frame is shared by all frame phrases about a ground, of any target; its prior is that of a
    front or behind phrase, if there is one, whatever the order in which they were said.
    """
    if not model.shared_frames:
        return ()
    framed = [relation for relation in every if model.frame_prior_for(relation) is not None]
    counts = Counter(relation.ground for relation in framed)
    several = [ground for ground, count in counts.items() if count > 1]
    if len(several) > max(_SHARED_BINS):
        raise InputError(
            f"{len(several)} grounds have a front that several phrases share "
            f"({', '.join(several)}); at most {max(_SHARED_BINS)} can be enumerated; say less at "
            "a time or use a model without shared frames"
        )
    shared = []
    for ground in several:
        about = [relation for relation in framed if relation.ground == ground]
        prior = model.frame_prior_for(min(about, key=_by_class))
        if prior is not None:
            shared.append(SharedFrame(ground, *prior.bins(_SHARED_BINS[len(several)])))
    return tuple(shared)


def _by_class(relation: GroundedRelation) -> tuple[bool, str]:
    """Order frame phrases: front and behind, which mean the ground's own front, come first."""
    return relation.record.absolute, relation.relation


def _check_shared(shared: Sequence[SharedFrame | Latent], model: ObservationModel) -> None:
    """Refuse more joint values of shared latents than can be enumerated, and to cut them."""
    joint = math.prod(len(latent.support) for latent in shared)
    if joint > MOST_SETTINGS:
        raise InputError(
            f"Phrases share {len(shared)} latents with {joint} joint values "
            f"({', '.join(latent.name for latent in shared)}); at most {MOST_SETTINGS} can be "
            "enumerated; say less at a time, or declare fewer"
        )
    if shared and any(part.cut for part in model.components):
        raise InputError(
            f"Model '{model.name}' cuts cells below uniform, which is not defined where phrases "
            f"share a latent ('{shared[0].name}'); use its variant 'paper', or bayes"
        )


def _check_names(
    latents: Sequence[str],
    targets: Sequence[str],
    frames: Sequence[SharedFrame],
    number_priors: Mapping[str, Any],
) -> None:
    """Refuse a name that two sites would have."""
    taken = {*(frame.name for frame in frames), *number_priors}
    for name in latents:
        if name in _RESERVED:
            raise InputError(f"Latent '{name}' has a name that the program uses; choose another")
        if "[" in name:
            raise InputError(f"Latent '{name}' has a bracket in its name; expected none")
        if name in taken:
            raise InputError(f"Two latents are named '{name}'; expected a name of its own for each")
        if any(name == target or name.startswith(f"{target}/") for target in targets):
            raise InputError(
                f"Latent '{name}' has the name of a site of a target; expected another name"
            )
        taken.add(name)


def _check_sites(names: Sequence[str]) -> None:
    """Refuse latents whose sites have one name: `q` of each ground beside `q/Ivy`."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(
            f"Two latents have a site named '{twice[0]}'; expected a name of its own for each"
        )
