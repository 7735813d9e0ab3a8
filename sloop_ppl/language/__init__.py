"""Language: relations, descriptions, and the parsers that read them.

Importing this package imports neither spaCy nor torch; the parsers load on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sloop_ppl.language.relations import RELATIONS, WHOLE_MAP, Relation, words_by_class
from sloop_ppl.language.street_parts import StreetPart
from sloop_ppl.language.values import (
    HEARER,
    NOT_ON_MAP,
    SPEAKER,
    Candidate,
    Description,
    Distance,
    Reading,
    RelationSpans,
    SpatialRelation,
    Status,
    TargetObject,
    Unresolved,
    Viewpoint,
    check_viewpoint,
)

if TYPE_CHECKING:
    from sloop_ppl.language.dependency import dependency_parser
    from sloop_ppl.language.diagnosis import Recognised, no_relation_found, recognised
    from sloop_ppl.language.parsers import PARSERS, Parser, list_parsers, parse
    from sloop_ppl.language.pipeline import load_pipeline
    from sloop_ppl.language.rendering import coloured_text, html_page, roles
    from sloop_ppl.language.targets import DEFAULT_TARGETS, load_targets

_LAZY = {
    "DEFAULT_TARGETS": "targets",
    "PARSERS": "parsers",
    "Parser": "parsers",
    "Recognised": "diagnosis",
    "coloured_text": "rendering",
    "dependency_parser": "dependency",
    "html_page": "rendering",
    "list_parsers": "parsers",
    "load_pipeline": "pipeline",
    "load_targets": "targets",
    "no_relation_found": "diagnosis",
    "parse": "parsers",
    "recognised": "diagnosis",
    "roles": "rendering",
}

__all__ = [
    "DEFAULT_TARGETS",
    "HEARER",
    "NOT_ON_MAP",
    "PARSERS",
    "RELATIONS",
    "SPEAKER",
    "WHOLE_MAP",
    "Candidate",
    "Description",
    "Distance",
    "Parser",
    "Reading",
    "Recognised",
    "Relation",
    "RelationSpans",
    "SpatialRelation",
    "Status",
    "StreetPart",
    "TargetObject",
    "Unresolved",
    "Viewpoint",
    "check_viewpoint",
    "coloured_text",
    "dependency_parser",
    "html_page",
    "list_parsers",
    "load_pipeline",
    "load_targets",
    "no_relation_found",
    "parse",
    "recognised",
    "roles",
    "words_by_class",
]


def __getattr__(name: str) -> Any:
    """Load a parser's module when it is first asked for."""
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if _LAZY[name] in ("dependency", "pipeline"):
        from sloop_ppl._extras import need_extra

        need_extra(name, "spacy", "spacy")
    return getattr(import_module(f"{__name__}.{_LAZY[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
