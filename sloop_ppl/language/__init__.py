"""Language: relations, descriptions, and the spaCy pipeline that reads them."""

from sloop_ppl.language.values import (
    Description,
    RelationSpans,
    SpatialRelation,
    TargetObject,
    Unresolved,
)
from sloop_ppl.language.vocabulary import (
    COMPASS,
    FRAME_RELATIONS,
    RELATION_CLASSES,
    RELATIONS,
    check_relation,
)

__all__ = [
    "COMPASS",
    "FRAME_RELATIONS",
    "RELATIONS",
    "RELATION_CLASSES",
    "Description",
    "RelationSpans",
    "SpatialRelation",
    "TargetObject",
    "Unresolved",
    "check_relation",
]
