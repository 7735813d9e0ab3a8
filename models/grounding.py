"""What a description becomes on a map before the program runs: its relations, grounded."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor

from sloop_ppl.errors import DescriptionError, InputError
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models._choices import Phrasing, phrasings_of
from sloop_ppl.models._program_data import ProgramData
from sloop_ppl.models._shared_latents import shared_and_own
from sloop_ppl.models._target_grounds import SplitPhrasing, split_phrasing, target_ids
from sloop_ppl.models.grounded_relation import GroundedRelation, ground_phrasing, with_hearer
from sloop_ppl.models.presets import ObservationModel

__all__ = ["ground_description", "ground_target_relations", "program_data", "true_places"]

MOST_RELATIONS = 10_000
"""Relations of a description: each takes some milliseconds on 41 x 41 cells."""


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
    shared, own = shared_and_own(
        grounded, to_targets or {}, model, city.grid.size, number_priors or {}
    )
    return ProgramData(
        targets,
        relations,
        city,
        model,
        log_prior,
        shared,
        tuple(truths) if truths is not None and model.needs_truth else None,
        dict(number_priors or {}),
        own,
        to_targets or {},
    )
