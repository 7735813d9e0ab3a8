"""Language: relations, descriptions, and the parsers that read them.

Importing this package imports neither spaCy nor torch; the parsers load on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

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
    WHOLE_MAP,
    check_relation,
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
    "COMPASS",
    "DEFAULT_TARGETS",
    "FRAME_RELATIONS",
    "PARSERS",
    "RELATIONS",
    "RELATION_CLASSES",
    "WHOLE_MAP",
    "Description",
    "Parser",
    "Recognised",
    "RelationSpans",
    "SpatialRelation",
    "TargetObject",
    "Unresolved",
    "check_relation",
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
]


def __getattr__(name: str) -> Any:
    """Load a parser's module when it is first asked for."""
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_LAZY[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
