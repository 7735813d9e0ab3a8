"""From words to factors, and from factors to the joint posterior.

Shape legend: S cells; K components; V values of each latent that phrases share.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.errors import DescriptionError, InputError
from sloop_ppl.inference._pairs import pair_groups
from sloop_ppl.inference._phrase_tables import PhraseLatents, latents_of_phrases
from sloop_ppl.inference.answers import AnswerFactor
from sloop_ppl.inference.engines import Engine
from sloop_ppl.inference.joint import JointPosterior, LogFactor, LogTable
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models import (
    GroundedRelation,
    Latent,
    ObservationModel,
    PairKernel,
    ProgramData,
    ground_description,
    ground_target_relations,
    program_data,
    true_places,
)
from sloop_ppl.models._shared_latents import MOST_SETTINGS
from sloop_ppl.models.program import pair_kernels

__all__ = [
    "DescriptionFactor",
    "by_speaker",
    "check_description",
    "gates_of",
    "joint_posterior",
    "site_name",
    "weigh",
]

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DescriptionFactor:
    """What one speaker says of each target, weighed under a model.

    Parameters
    ----------
    descriptions
        What the speaker said, one text or more: together they are one longer description.
    data
        What its program was run on.
    log_factors
        Target -> log of component weight times likelihood, shape (V..., K, S); targets of which
        nothing was said are left out.
    pairs
        What was said of how targets lie apart.
    """

    descriptions: tuple[Description, ...]
    data: ProgramData
    log_factors: Mapping[str, Table]
    pairs: tuple[PairKernel, ...] = ()

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the mixture's components, K of them."""
        return tuple(part.name for part in self.data.model.components)

    @property
    def speaker(self) -> str | None:
        """Who says it; None for a speaker of whom nothing else is known."""
        return self.descriptions[0].speaker

    def is_by(self, speaker: str | None) -> bool:
        """Tell whether a speaker of this name said it; those without a name are all others."""
        return speaker is not None and speaker == self.speaker

    def about(self, target: str) -> tuple[SpatialRelation, ...]:
        """Return what was said of a target, text by text."""
        return tuple(r for description in self.descriptions for r in description.about(target))

    def pairs_of(self, target: str, index: int) -> tuple[PairKernel, ...]:
        """Return what a relation of a target, by its position in `about`, says of other targets."""
        return tuple(
            pair for pair in self.pairs if pair.figure == target and pair.relation.index == index
        )

    def relations(self, target: str) -> tuple[GroundedRelation, ...]:
        """Return the grounded relations of a target."""
        return self.data.relations[self.data.targets.index(target)]


def site_name(site: str, which: int) -> str:
    """Return what a site of a description is called in the joint posterior of several.

    Parameters
    ----------
    site
        Name of the site in its program.
    which
        Position of the description.
    """
    return site if which == 0 else f"{site}[{which}]"


def joint_posterior(
    log_prior: Mapping[str, Table],
    log_sensed: Mapping[str, Table],
    factors: Sequence[DescriptionFactor],
    answers: Sequence[AnswerFactor] = (),
) -> JointPosterior:
    """Return the joint posterior of what was said, answered and sensed.

    Parameters
    ----------
    log_prior
        Target -> log prior over cells, shape (S,).
    log_sensed
        Target -> log likelihood of what was sensed, shape (S,).
    answers
        Answers to questions about the latents of these.

    Raises
    ------
    InputError
        When the descriptions share so many frames that their joint settings cannot be enumerated.
    """
    tables: list[LogFactor] = []
    supports: dict[str, Sequence[object]] = {}
    phrases: list[PhraseLatents] = []
    settings = 1
    for target, table in log_prior.items():
        cell = f"{target}/cell"
        tables.append(LogTable((cell,), torch.from_numpy(table + log_sensed[target])))
        supports[cell] = range(len(table))
    n_phrases = dict.fromkeys(log_prior, 0)
    for which, factor in enumerate(factors):
        shared = [site_name(latent.name, which) for latent in factor.data.shared]
        for name, latent in zip(shared, factor.data.shared, strict=True):
            tables.append(LogTable((name,), latent.log_prior))
            supports[name] = latent.support
            if not isinstance(latent, Latent) or latent.choice is None:
                settings *= len(latent.support)
        for target, table in factor.log_factors.items():
            component = site_name(f"{target}/component", which)
            names = (*shared, component, f"{target}/cell")
            tables.append(LogTable(names, torch.from_numpy(table)))
            supports[component] = factor.components
            phrases += latents_of_phrases(
                factor.data, target, n_phrases[target], partial(site_name, which=which)
            )
            n_phrases[target] += len(factor.relations(target))
    gated = [
        (kernel, gates_of(factor, which, kernel))
        for which, factor in enumerate(factors)
        for kernel in factor.pairs
    ]
    tables += pair_groups(gated, {name: len(values) for name, values in supports.items()})
    tables += [answer.table() for answer in answers if answer.informs]
    if settings > MOST_SETTINGS:
        raise InputError(
            f"The descriptions share frames with {settings} joint settings; at most "
            f"{MOST_SETTINGS} can be enumerated; use a model without shared frames"
        )
    return JointPosterior(tuple(tables), supports, tuple(phrases))


def gates_of(
    factor: DescriptionFactor, which: int, kernel: PairKernel
) -> dict[str, frozenset[int]]:
    """Return what a relation to a target depends on: latent -> positions of values to say it.

    Parameters
    ----------
    factor
        The description.
    which
        Its position.
    kernel
        The relation.
    """
    shared = {latent.name: latent.support for latent in factor.data.shared}
    return {
        site_name(name, which): frozenset(i for i, v in enumerate(shared[name]) if v in values)
        for name, values in kernel.relation.holds_when.items()
        if name in shared
    }


def by_speaker(descriptions: Sequence[Description]) -> list[tuple[Description, ...]]:
    """Return descriptions grouped by who said them, in the order in which speakers first speak."""
    groups: dict[object, list[Description]] = {}
    for i, description in enumerate(descriptions):
        key = i if description.speaker is None else description.speaker
        groups.setdefault(key, []).append(description)
    return [tuple(group) for group in groups.values()]


def weigh(
    descriptions: Sequence[Description],
    city: CityMap,
    model: ObservationModel,
    engine: Engine,
    log_prior: Mapping[str, NDArray[np.float64]],
    *,
    truth: Mapping[str, tuple[float, float]] | None = None,
    rng: np.random.Generator | None = None,
) -> DescriptionFactor:
    """Return what one speaker says of targets.

    Parameters
    ----------
    descriptions
        What the speaker said, one text or more.
    log_prior
        Target -> log prior over cells, shape (S,): where draws are worth making.
    truth
        Target -> true place in metres, for a model that is told it.
    rng
        Where an engine that draws does so.

    Raises
    ------
    UnknownName
        For an unknown relation or ground.
    DescriptionError
        When there is no target, or a relation is about no declared one.
    InputError
        For a missing truth, a description of another map, or an rng that is no generator.
    """
    for description in descriptions:
        check_description(description, city)
    if rng is not None and not isinstance(rng, np.random.Generator):
        raise InputError(
            f"rng is a {type(rng).__name__}; expected a generator: numpy.random.default_rng(seed)"
        )
    grounded = ground_description(descriptions, city, model, log_prior)
    to_targets = ground_target_relations(descriptions, city, model, log_prior)
    cells = np.stack([log_prior[target] for target in grounded])
    data = program_data(
        grounded,
        city,
        model,
        torch.from_numpy(cells),
        truths=true_places(truth, tuple(grounded), model),
        to_targets=to_targets,
    )
    tables = engine.weigh(data, rng)
    _check_tables(tables, data, engine)
    log_factors = {}
    for i, (target, table) in enumerate(zip(grounded, tables, strict=True)):
        if data.is_located(i):
            log_factors[target] = table
        elif target in to_targets:  # nothing is said of its cells by themselves
            weights = data.log_weight[i].numpy()[:, None]
            log_factors[target] = np.ascontiguousarray(np.broadcast_to(weights, table.shape))
    return DescriptionFactor(tuple(descriptions), data, log_factors, pair_kernels(data))


def _check_tables(tables: object, data: ProgramData, engine: Engine) -> None:
    """Refuse what an engine returns when its tables do not fit the program."""
    shared = tuple(len(latent.support) for latent in data.shared)
    shape = (*shared, len(data.model.components), data.n_cells)
    n_targets = len(data.targets)
    if not isinstance(tables, Sequence) or len(tables) != n_targets:
        count = f"{len(tables)} of them" if isinstance(tables, Sequence) else type(tables).__name__
        raise InputError(
            f"Engine '{engine.name}' returned as tables {count}; expected a tuple of {n_targets}, "
            "one for each target"
        )
    for target, table in zip(data.targets, tables, strict=True):
        if not isinstance(table, np.ndarray) or table.shape != shape:
            found = getattr(table, "shape", None)
            of = type(table).__name__ if found is None else f"shape {tuple(found)}"
            raise InputError(
                f"Engine '{engine.name}' returned a table of {of} for '{target}'; expected a "
                f"numpy array of shape {shape}: shared latents, components, cells"
            )
        if np.isnan(table.min(initial=0.0)):
            raise InputError(
                f"Engine '{engine.name}' returned NaN for '{target}'; expected log factors, -inf "
                "where a cell is impossible"
            )


def check_description(description: Description, city: CityMap) -> None:
    """Refuse a description without targets, of unknown ones, or of another map.

    Raises
    ------
    DescriptionError, InputError
        When it is one of these.
    """
    targets = tuple(target.id for target in description.targets)
    if not targets:
        raise DescriptionError("The description has no target; expected at least one")
    if description.map and description.map != city.name:
        raise InputError(
            f"The description was read on map '{description.map}'; expected '{city.name}': the "
            "same id is another landmark there"
        )
    others = (r for reading in description.readings for r in reading.relations)
    for relation in (*description.relations, *others):
        if relation.figure not in targets:
            raise DescriptionError(
                f"Relation '{relation.relation}' is about '{relation.figure}', which is no target "
                f"of the description; expected one of {', '.join(targets)}"
            )
