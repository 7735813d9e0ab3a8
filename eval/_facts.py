"""What was said of each described target, and whether its frames were taken as the speaker did."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from msgspec import structs

from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError
from sloop_ppl.eval._run_records import TargetRecord
from sloop_ppl.eval.descriptions import AnnotatedDescription, Place
from sloop_ppl.language import RELATIONS, SpatialRelation
from sloop_ppl.maps import CityMap
from sloop_ppl.models import GroundedRelation, PredictedPoint, ground_relations
from sloop_ppl.models._target_grounds import split_by_targets

__all__ = ["RelationFacts", "TargetFacts", "facts_of", "plain_word"]

_FRAME_PRIOR = PredictedPoint()


@dataclass(frozen=True)
class RelationFacts:
    """One gold relation of a target.

    Parameters
    ----------
    relation, relation_class
        Its word and the class of that.
    grounds
        Ids of its grounds.
    negated
        Whether it was denied.
    good
        For front, behind, left and right: whether the target lies on the predicted side of the
        ground; None for the other relations, and for what was denied.
    """

    relation: str
    relation_class: str
    grounds: tuple[str, ...]
    negated: bool
    good: bool | None


@dataclass(frozen=True)
class TargetFacts:
    """A described target.

    Parameters
    ----------
    description, target
        Its ids.
    map, configuration
        Where, and of which placement of the objects.
    relations
        The gold relations of this target.
    """

    description: str
    target: str
    map: str
    configuration: str
    relations: tuple[RelationFacts, ...]

    @property
    def good(self) -> bool | None:
        """Whether all its frame relations are good; None when it has none."""
        decided = [r.good for r in self.relations if r.good is not None]
        return all(decided) if decided else None

    def to_json(self) -> dict[str, Any]:
        """Return the facts as a JSON object."""
        return asdict(self)

    @classmethod
    def from_json(cls, record: Mapping[str, Any]) -> TargetFacts:
        """Return the facts that `to_json` told.

        Raises
        ------
        InputError
            When a member is missing or of another type.
        """
        try:
            known = checked(record, TargetRecord)
        except Fault as fault:
            raise InputError(f"The targets of a sweep are damaged ({fault})") from fault
        relations = tuple(RelationFacts(**structs.asdict(one)) for one in known.relations)
        return cls(known.description, known.target, known.map, known.configuration, relations)


def plain_word(word: str) -> str:
    """Return what a relation is counted as: the class of compass and frame words, else the word.

    Examples
    --------
    >>> plain_word("above"), plain_word("near")
    ('north', 'near')
    """
    record = RELATIONS[word]
    return record.relation_class if record.is_compass or record.needs_frame else word


def facts_of(annotated: AnnotatedDescription, city: CityMap) -> list[TargetFacts]:
    """Return what was said of each target of a description, in its order."""
    targets = [target for target in annotated.targets if target not in city]
    return [
        TargetFacts(
            description=annotated.id,
            target=target,
            map=annotated.map,
            configuration=annotated.configuration,
            relations=_relations(annotated.about(target), place, city, targets),
        )
        for target, place in annotated.targets.items()
    ]


def _relations(
    phrases: Sequence[SpatialRelation], place: Place, city: CityMap, targets: Collection[str]
) -> tuple[RelationFacts, ...]:
    found = []
    for relation in phrases:
        of_places, _ = split_by_targets(relation, targets)
        terms = ground_relations((of_places,), city) if of_places else ()
        # The map has no front, and that of who listens, or of another target, no one predicts.
        framed = [t for t in terms if t.needs_frame and t.ground in city and not relation.negated]
        goods = [_good(term, place) for term in framed]
        found.append(
            RelationFacts(
                relation.relation,
                terms[0].relation_class if terms else RELATIONS[relation.relation].relation_class,
                relation.grounds,
                relation.negated,
                all(goods) if goods else None,
            )
        )
    return tuple(found)


def _good(term: GroundedRelation, place: Place) -> bool:
    """Tell whether a target is on the side of its ground that the prediction says.

    Notes
    -----
    Source: SLOOP sec. VI: the bearing from the ground's centroid has a positive cosine with the
    predicted direction. The front is that of the nearest street, left and right are those of the
    map; a street has two fronts, and one of them will do.
    """
    x, y = term.city.centroid(term.ground)
    bearing = math.atan2(place.y_m - y, place.x_m - x)
    angles = [part.mean_rad for part in _FRAME_PRIOR(term).parts]
    return any(math.cos(bearing - (angle + term.offset_rad)) > 0 for angle in angles)
