"""What the program is run on: relations, priors, and the tables they share.

Shape legend: S cells; K components; V values of each latent that phrases share.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, cells_of_map, log_cells
from sloop_ppl.models._guard import trusted
from sloop_ppl.models._logspace import log_normalise
from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation, as_vocabulary_word
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.phrase import Phrase, SharedFrame
from sloop_ppl.models.presets import ObservationModel

__all__ = ["ProgramData"]


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
