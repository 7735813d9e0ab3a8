"""Relations whose ground is another target: they say how two targets lie apart, not where."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from sloop_ppl.errors import DescriptionError
from sloop_ppl.language import RELATIONS, Description, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.presets import ObservationModel

__all__ = ["ground_target_relations", "split_by_targets", "target_ids"]

_OF_EACH = "near"
"""What a word that takes several grounds means of each of them, where one may be anywhere."""


def target_ids(
    descriptions: Sequence[Description], city: CityMap, others: Collection[str] = ()
) -> frozenset[str]:
    """Return the ids that are targets as grounds; a landmark of the same id comes first.

    Parameters
    ----------
    descriptions
        What was said.
    city
        The map.
    others
        Ids of targets that were spoken of before.
    """
    known = {target.id for description in descriptions for target in description.targets}
    return frozenset(name for name in (*known, *others) if name not in city)


def split_by_targets(
    relation: SpatialRelation, targets: Collection[str]
) -> tuple[SpatialRelation | None, tuple[SpatialRelation, ...]]:
    """Return the part of a relation that is to places, and one relation for each target in it.

    Parameters
    ----------
    relation
        The relation.
    targets
        Ids of targets.

    Returns
    -------
    tuple
        The relation to those of its grounds that are no targets, None when all are; the relation to
        each target. "Between the bank and the red bike" is near the bank and near the bike: the
        region between depends on where the bike is, which a table over cells cannot hold.
    """
    kept = [i for i, ground in enumerate(relation.grounds) if ground not in targets]
    if len(kept) == len(relation.grounds):
        return relation, ()
    several = RELATIONS[relation.relation].grounds == "several"
    word = _OF_EACH if several and len(relation.grounds) > 1 else relation.relation
    pairs = tuple(
        replace(relation, relation=word, grounds=(ground,), candidates=(), mentions=())
        for ground in dict.fromkeys(relation.grounds)
        if ground in targets
    )
    if not kept:
        return None, pairs
    rest = replace(
        relation,
        relation=relation.relation if len(kept) > 1 else word,
        grounds=tuple(relation.grounds[i] for i in kept),
        candidates=tuple(relation.candidates[i] for i in kept if relation.candidates),
        mentions=tuple(relation.mentions[i] for i in kept if relation.mentions),
    )
    return rest, pairs


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

    Raises
    ------
    DescriptionError
        When a target is located by itself.

    Notes
    -----
    Nothing is measured yet: where such a ground is, no one knows; see
    :class:`sloop_ppl.models.pair_kernel.PairKernel`. A model that takes no phrase as it was said
    ("uniform", "keyword", "informed") takes none of these either.
    """
    known = target_ids(descriptions, city, others)
    if model.needs_truth or not any(part.is_literal for part in model.components):
        return {}
    found: dict[str, tuple[GroundedRelation, ...]] = {}
    counts: dict[str, int] = {}
    for position, text in enumerate(descriptions):
        for target in text.targets:
            for index, relation in enumerate(text.about(target.id)):
                _, pairs = split_by_targets(relation, known)
                terms = tuple(
                    GroundedRelation(
                        relation=one.relation,
                        grounds=one.grounds,
                        city=city,
                        negated=one.negated,
                        stated_distance_m=one.distance_m if model.heed_distance else None,
                        index=index + counts.get(target.id, 0),
                        figure=target.id,
                        each=one.each,
                        description=position,
                        distance_bounds=one.distance if model.heed_distance else None,
                    )
                    for one in pairs
                )
                for term in terms:
                    if term.ground == target.id:
                        raise DescriptionError(
                            f"Relation '{term.relation}' of '{target.id}' is to '{target.id}' "
                            "itself; expected a landmark or another target"
                        )
                if terms:
                    found[target.id] = found.get(target.id, ()) + terms
            counts[target.id] = counts.get(target.id, 0) + len(text.about(target.id))
    return found
