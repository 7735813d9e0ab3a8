"""Ground what was said the way a model reads it."""

from __future__ import annotations

from dataclasses import replace

from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models.presets import Preset
from sloop_ppl.models.terms import RelationTerm, ground_relations

__all__ = ["ground_description"]


def ground_description(
    description: Description, city: CityMap, model: Preset
) -> dict[str, tuple[RelationTerm, ...]]:
    """Return target -> its grounded relations, in the order of the description's targets.

    Parameters
    ----------
    description : what was said.
    city : the map.
    model : the observation model; its `joint_grounds` and `heed_distance` decide what a relation
        to several grounds and a said distance mean.

    Raises
    ------
    UnknownName : when a ground is not on the map.
    """
    grounded = {}
    for target in description.targets:
        relations = description.about(target.id)
        if not model.heed_distance:
            relations = tuple(replace(relation, distance_m=None) for relation in relations)
        grounded[target.id] = ground_relations(relations, city, joint=model.joint_grounds)
    return grounded
