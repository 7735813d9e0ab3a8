"""What a description becomes on a map before the program runs: relations, latents, readings.

Shape legend: S cells; K components; V values of each latent that phrases share.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import (
    Callable,
    Collection,
    Hashable,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
)
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import DescriptionError, InputError
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap, cells_of_map, log_cells
from sloop_ppl.models._choices import Phrasing, phrasings_of
from sloop_ppl.models._guard import trusted
from sloop_ppl.models._logspace import log_normalise
from sloop_ppl.models._target_grounds import SplitPhrasing, split_phrasing, target_ids
from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import (
    GroundedRelation,
    as_vocabulary_word,
    ground_phrasing,
    with_hearer,
)
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.presets import ObservationModel

__all__ = [
    "Phrase",
    "ProgramData",
    "SharedFrame",
    "ground_description",
    "ground_target_relations",
    "latents_of",
    "program_data",
    "true_places",
]

RELIABLE = "reliable"
"""Name of the latent that tells whether anything a speaker says means anything."""

_RESERVED = (
    *("angle", "cell", "component", "cut", "draw", "frame", "holds", "lapse", "normaliser"),
    *("phrase", "prior", "reading", RELIABLE, "shared_error", "targets", "temper", "together"),
    *("x", "y"),
)
"""Names of the program's sites and of the axes of tables."""

MOST_RELATIONS = 10_000
"""Relations of a description: each takes some milliseconds on 41 x 41 cells."""

MOST_SETTINGS = 72 * 72
"""Joint values of shared latents that are enumerated: each has a table of components and cells, so
that 5184 of a map of 41 x 41 cells and two components take 140 MB."""

_MOST_NUMBERS = 1 << 23
"""Numbers in the table of a target, beyond which what a description leaves open is cut short."""

_SHARED_BINS = {1: 72, 2: 36}
"""Angle bins of each frame when so many are shared: 36 each for two leave room for a latent of four
values beside them."""


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
        Latents that several phrases depend on: frames, what the description leaves open, and those
        that the model declares.
    truths
        True places of the targets, metres, for a model that is told them.
    number_priors
        Parameter of the likelihood -> distribution that it is drawn from.
    own
        Latents of the description or the model that one phrase each depends on.
    to_targets
        Target -> its relations to other targets, which no table over its cells can hold; here they
        only count as phrases, and may depend on what the description leaves open.
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

        A phrase that is said of each of several grounds is one. Those of the most probable reading
        count, and of alternatives the branch that has most, so that the number is the same
        whatever was meant.
        """
        shape = (-1, *(1,) * (len(self.shared) + 1))
        every = [
            phrases + self._counted(target)
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
        n = max(_count(self.relations[i] + self._counted(term.figure)), 1)
        return float(n ** -float(self.model.temper))

    def _counted(self, target: str) -> tuple[GroundedRelation, ...]:
        """Return its relations to other targets, those left out that may be to a place, too."""
        terms = self.to_targets.get(target, ())
        return tuple(one for one in terms if not any(c.kind == "ground" for c in one.choices))

    @cached_property
    def cuts(self) -> Tensor:
        """Which components cut cells below uniform, shape (K, 1..., 1)."""
        cut = torch.tensor([part.cut for part in self.model.components])
        return cut.reshape(-1, *(1,) * (len(self.shared) + 1))

    @cached_property
    def log_uninformative(self) -> float:
        """Log probability of a phrase that says nothing, the same at every cell."""
        return self.model.log_uninformative(cells_of_map(self.city.grid))

    def counted(self, log_p: Tensor) -> Tensor:
        """Return tables, shape (..., S), times the number of the map's cells each entry is of."""
        counts = log_cells(self.city.grid)
        return log_p if counts is None else log_p + torch.from_numpy(counts)

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
        changed = len(grounds) > 1 and not relation.has_open_ground
        if has_frame and changed and shared & (grounds | {relation.ground}):
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
        """Log prior weight of each component, -inf where it does not apply, shape (N, K).

        It is that of the most probable reading that says anything of the target.
        """
        return log_normalise(
            torch.tensor(
                [
                    [
                        math.log(part.weight) if self.applies(part, relations) else -math.inf
                        for part in self.model.components
                    ]
                    for relations in map(_main, self.relations)
                ],
                dtype=torch.float64,
            )
        )

    @cached_property
    def readings(self) -> dict[int, Latent]:
        """Which of the shared latents are readings, by their axes."""
        return {
            axis: latent
            for axis, latent in enumerate(self.shared)
            if isinstance(latent, Latent) and latent.choice == "reading"
        }

    @cached_property
    def log_weight_given(self) -> tuple[Tensor, ...]:
        """Log prior weight of each component given the readings, per target, shape (V..., K).

        The axes of the latents are left out where the readings do not matter; else those of other
        latents have length one. Of a target of which a reading says nothing, weights are those of
        the most probable reading.
        """
        return tuple(
            self._log_weight_given(relations, fixed)
            for relations, fixed in zip(self.relations, self.log_weight, strict=True)
        )

    def _log_weight_given(self, relations: tuple[GroundedRelation, ...], fixed: Tensor) -> Tensor:
        axes = [a for a, reading in self.readings.items() if any(map(reading.is_about, relations))]
        if not axes:
            return fixed
        sizes = [len(v.support) if a in axes else 1 for a, v in enumerate(self.shared)]
        rows = []
        for values in itertools.product(*map(range, sizes)):
            read = tuple(
                one
                for one in relations
                if all(one.belongs_to(self.shared[a].name, values[a]) for a in axes)
            )
            weights = [
                math.log(part.weight) if self.applies(part, read) else -math.inf
                for part in self.model.components
            ]
            says = any(not one.is_silent for one in read)
            own = torch.tensor(weights, dtype=torch.float64)
            rows.append(log_normalise(own) if says else fixed)
        if all(torch.equal(row, fixed) for row in rows):
            return fixed
        return torch.stack(rows).reshape(*sizes, -1)

    def log_weight_before(self, i: int) -> Tensor:
        """Return the log prior weight of each component of a target, over its readings, (K,)."""
        given = self.log_weight_given[i]
        if given.dim() == 1:
            return given
        joint = given + self.log_prior_of(self.readings)
        return torch.logsumexp(joint.flatten(0, -2), 0)

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
        return self.log_prior_of(range(len(self.shared)))

    def log_prior_of(self, axes: Iterable[int]) -> Tensor:
        """Return the log prior of the joint values of some shared latents, shape (V..., 1)."""
        total = torch.zeros((1,) * (len(self.shared) + 1), dtype=torch.float64)
        for axis in axes:
            shape = [1] * (len(self.shared) + 1)
            shape[axis] = -1
            total = total + self.shared[axis].log_prior.reshape(shape)
        return total

    def applies(self, part: Component, relations: tuple[GroundedRelation, ...]) -> bool:
        """Tell whether a component has anything to say of a target.

        Of a target of which nothing was said the first component stands for all.
        """
        if self.model.needs_truth or all(one.is_silent for one in relations):
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
        # What was heard comes first: a model's latents may look at the place that is meant.
        order = sorted(
            (axis for axis, latent in enumerate(concerned) if latent is not None),
            key=lambda axis: getattr(concerned[axis], "choice", None) is None,
        )
        meanings = []
        for values in itertools.product(*supports):
            one = relation
            for axis in order:
                latent = concerned[axis]
                one = one if latent is None else latent.apply(one, values[axis])
            meanings.append(one)
        if self.model.normalisation == "speaker":
            meanings = [one if one.is_silent else as_vocabulary_word(one) for one in meanings]
        frames = self._frames_of(meanings)
        has_frame = any(frame is not None for frame in frames)
        self._check_meanings(relation, meanings, has_frame=has_frame)
        sizes = tuple(len(support) for support in supports)
        found = Phrase(relation, own, sizes, tuple(meanings), frames if has_frame else None)
        for axis, shared in enumerate(self.shared):
            if (
                has_frame
                and isinstance(shared, SharedFrame)
                and shared.ground == relation.ground
                and not relation.has_open_ground
            ):
                angles = torch.from_numpy(shared.angles_rad)
                return replace(found, shared_axis=axis, shared_angles=angles)
        return found

    def _frames_of(
        self, meanings: Sequence[GroundedRelation]
    ) -> tuple[FrameDistribution | None, ...]:
        """Return the frame prior of each meaning; the frame is that of the ground it has."""
        if any(meanings[0].denied):
            return (None,) * len(meanings)
        made: dict[Hashable, FrameDistribution | None] = {}
        found = []
        for n, one in enumerate(meanings):
            key = one.meaning if one.choices else n
            if key not in made:
                made[key] = self.model.frame_prior_for(one)
            found.append(made[key])
        return tuple(found)


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
        `ground_target_relations`.

    Raises
    ------
    UnknownName
        When a ground is not on the map.
    DescriptionError
        When a ground is who listens, and the description does not say where that is, or there are
        more than `MOST_RELATIONS`.
    """
    texts = (description,) if isinstance(description, Description) else tuple(description)
    count = sum(len(text.relations) for text in texts)
    if count > MOST_RELATIONS:
        raise DescriptionError(
            f"The description has {count} relations; expected at most {MOST_RELATIONS}: give it in "
            "parts"
        )
    grounded: dict[str, tuple[GroundedRelation, ...]] = {}
    counts: Counter[str] = Counter()
    rest: dict[str, tuple[GroundedRelation, ...]] = {}
    for text, target, phrasings in _by_target(texts, city, model, others):
        own: list[GroundedRelation] = []
        for one in phrasings:
            if one.of_places is not None:
                joint = model.joint_grounds
                own += ground_phrasing(one.of_places, one.index, city, joint=joint)
        terms = with_hearer(tuple(own), texts[text].hearer)
        terms = tuple(replace(term, description=text) for term in terms) if text else terms
        main = tuple(term for term in terms if term.index >= 0)
        grounded[target] = grounded.get(target, ()) + main
        rest[target] = rest.get(target, ()) + tuple(term for term in terms if term.index < 0)
        counts[target] += len(texts[text].about(target))
    # Relations of other readings alone come after all of the most probable ones, and so are
    # numbered: what is asked of the j-th relation that was read means the same with and without.
    return {
        target: terms
        + tuple(replace(term, index=counts[target] + n) for n, term in enumerate(rest[target]))
        for target, terms in grounded.items()
    }


def ground_target_relations(
    descriptions: Sequence[Description],
    city: CityMap,
    model: ObservationModel,
    others: Collection[str] = (),
) -> dict[str, tuple[GroundedRelation, ...]]:
    """Return target -> its relations to other targets, of one speaker, in the order of saying.

    Parameters
    ----------
    descriptions
        All that the speaker said.
    city, model
        The map and the observation model.
    others
        Ids of targets that were spoken of before.

    Returns
    -------
    dict
        Only targets that have some. What is said in some readings or branches alone, or of a
        mention that may be another place, has that in `GroundedRelation.holds_when`.

    Raises
    ------
    DescriptionError
        When a target is located by itself.

    Notes
    -----
    Nothing is measured yet: where such a ground is, no one knows; see
    :class:`sloop_ppl.models.PairKernel`. A model that takes no phrase as it was said ("uniform",
    "keyword", "informed") takes none of these either.
    """
    if model.needs_truth or not any(part.is_literal for part in model.components):
        return {}
    found: dict[str, tuple[GroundedRelation, ...]] = {}
    for text, target, phrasings in _by_target(descriptions, city, model, others):
        terms = tuple(
            GroundedRelation(
                relation=pair.relation.relation,
                grounds=pair.relation.grounds,
                city=city,
                negated=pair.relation.negated,
                stated_distance_m=pair.relation.distance_m,
                index=one.index,
                figure=target,
                each=pair.relation.each,
                description=text,
                distance_bounds=pair.relation.distance,
                choices=pair.choices,
                holds_when=pair.holds_when,
            )
            for one in phrasings
            for pair in one.to_targets
        )
        for term in terms:
            if term.ground == target:
                raise DescriptionError(
                    f"Relation '{term.relation}' of '{target}' is to '{target}' itself; expected a "
                    "landmark or another target"
                )
        if terms:
            found[target] = found.get(target, ()) + terms
    return found


def _by_target(
    texts: Sequence[Description],
    city: CityMap,
    model: ObservationModel,
    others: Collection[str],
) -> Iterator[tuple[int, str, tuple[SplitPhrasing, ...]]]:
    """Yield position of a text, a target and what is said of it there, numbered on.

    A relation of no main reading has the number -1.
    """
    known = target_ids(texts, city, others)
    counts: Counter[str] = Counter()
    for position, text in enumerate(texts):
        phrasings = phrasings_of(
            text, sum_readings=model.sum_readings, sum_grounds=model.sum_grounds, text=position
        )
        for target in text.targets:
            yield (
                position,
                target.id,
                tuple(
                    split_phrasing(
                        one if model.heed_distance else _without_distance(one),
                        known,
                        -1 if one.position is None else counts[target.id] + one.position,
                    )
                    for one in phrasings
                    if one.relation.figure == target.id
                ),
            )
            counts[target.id] += len(text.about(target.id))


def _without_distance(phrasing: Phrasing) -> Phrasing:
    plain = replace(phrasing.relation, distance_m=None, distance=None)
    return replace(phrasing, relation=plain)


def _main(relations: tuple[GroundedRelation, ...]) -> tuple[GroundedRelation, ...]:
    """Return the relations of the most probable reading, all of them when it has none."""
    main = tuple(one for one in relations if one.is_main and not one.is_silent)
    return main or relations


def _count(relations: Sequence[GroundedRelation]) -> int:
    """Return the number of phrases of the most probable reading.

    Of a group of alternatives the branch with most phrases counts.
    """
    branches: dict[str, Counter[int]] = {}
    each, alone = set(), 0
    for one in relations:
        group = next((c.name for c in one.choices if c.kind == "branch"), None)
        if not one.is_main:
            continue
        if one.each and (one.description, one.index) in each:
            continue
        if one.each:
            each.add((one.description, one.index))
        if group is None:
            alone += 1
        else:
            branches.setdefault(group, Counter()).update(one.holds_when[group])
    return alone + sum(max(counter.values()) for counter in branches.values())


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
    between = [relation for terms in (to_targets or {}).values() for relation in terms]
    latents = (
        *_choices_of([*every, *between]),
        *(one for latent in latents_of(model) for one in latent.each(placed)),
    )
    declared = tuple(
        latent
        for latent in latents
        if latent.choice in ("reading", "branch")
        or any(latent.is_about(relation) for relation in between if latent.choice)
        or sum(latent.is_about(relation) for relation in every) != 1
    )
    declared = _most_probable(declared, frames, len(model.components) * city.grid.size)
    names = [latent.name for latent in _declared(model)]
    _check_names(names, targets, frames, number_priors or {})
    _check_sites([latent.name for latent in latents])
    shared = {latent.name for latent in declared}
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
        tuple(latent for latent in latents if latent.name not in shared),
        to_targets or {},
    )


def _choices_of(every: Sequence[GroundedRelation]) -> tuple[Latent, ...]:
    """Return the latents that descriptions declare: readings, then branches, then grounds."""
    kinds = ("reading", "branch", "ground")
    choices = {c.name: c for kind in kinds for r in every for c in r.choices if c.kind == kind}
    return tuple(map(Latent.of_choice, choices.values()))


def _most_probable(
    latents: tuple[Latent, ...], frames: Sequence[SharedFrame], size: int
) -> tuple[Latent, ...]:
    """Leave out the least probable values of readings, branches and grounds, until all fits.

    Parameters
    ----------
    latents
        Those that phrases share.
    frames
        Frames that they share.
    size
        Numbers in the table of one joint value.

    Notes
    -----
    A person who talks long leaves more open than can be listed; what was least probable from the
    start goes first. The most probable reading stays.
    """
    kept = list(latents)
    fixed = math.prod(len(frame.support) for frame in frames)

    def is_too_much() -> bool:
        joint = fixed * math.prod(len(latent.support) for latent in kept)
        return joint > MOST_SETTINGS or joint * size > _MOST_NUMBERS

    while is_too_much():
        options = [
            (latent.prior[v], -n, -v)
            for n, latent in enumerate(kept)
            if latent.choice is not None
            for v in range(1, len(latent.support))
        ]
        if not options:
            break
        _, n, v = min(options)
        kept[-n] = _without(kept[-n], -v)
    return tuple(kept)


def _without(latent: Latent, v: int) -> Latent:
    """Return a latent without one of its values."""
    support = (*latent.support[:v], *latent.support[v + 1 :])
    prior = (*latent.prior[:v], *latent.prior[v + 1 :])
    total = math.fsum(prior)
    return replace(latent, support=support, prior=tuple(p / total for p in prior))


def _shared_frames(
    every: Sequence[GroundedRelation], model: ObservationModel
) -> tuple[SharedFrame, ...]:
    """Return the frames that a model lets several phrases share.

    A frame is shared by all frame phrases about a certain ground, of any target; its prior is that
    of a front or behind phrase, if there is one, whatever the order in which they were said.
    """
    if not model.shared_frames:
        return ()
    framed = [
        relation
        for relation in every
        if not relation.has_open_ground and model.frame_prior_for(relation) is not None
    ]
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
        prior = model.frame_prior_for(min(about, key=lambda r: (r.record.absolute, r.relation)))
        if prior is not None:
            shared.append(SharedFrame(ground, *prior.bins(_SHARED_BINS[len(several)])))
    return tuple(shared)


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
