"""The parsers by name, and the one call that reads a text with any of them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from sloop_ppl.errors import InputError
from sloop_ppl.language.targets import check_targets
from sloop_ppl.language.values import Description, TargetObject, Viewpoint
from sloop_ppl.maps import CityMap
from sloop_ppl.registry import Registry

__all__ = ["PARSERS", "Parser", "find_parser", "list_parsers", "parse"]


Parser = Callable[[str, CityMap, Sequence[TargetObject] | None], Description]
"""Anything that reads a text on a map: rules, a trained parser, a language model.

It takes any text, the map, of whose landmarks it gives the ids as grounds, and the objects it can
speak of (None for the default ones and any others), and returns what the text says.
"""

LONGEST_TEXT = 2_000_000
"""Characters of a text at most: about 300,000 words, which take some twenty seconds."""

PARSERS: Registry[Parser] = Registry("parser")
"""Parsers by name; add your own with ``PARSERS.add(name, parser)``."""


def find_parser(name: str) -> Parser:
    """Return a parser by its name, or by the place it is defined at.

    Parameters
    ----------
    name
        A registered name, or ``"module:name"``; modules are also looked for in the working folder.

    Raises
    ------
    UnknownName
        When no parser is registered by the name.
    InputError
        When the module cannot be imported, or holds no such callable.
    """
    if ":" not in name:
        return PARSERS[name]
    module, _, attribute = name.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)
    try:
        found = getattr(import_module(module), attribute)
    except (ImportError, AttributeError, ValueError, TypeError) as error:
        raise InputError(
            f"Parser '{name}' cannot be imported: {error}; expected module:name of a callable "
            "(text, city, targets) -> Description"
        ) from error
    if not callable(found):
        raise InputError(
            f"Parser '{name}' is a {type(found).__name__}; expected a callable "
            "(text, city, targets) -> Description"
        )
    parser: Parser = found
    return parser


def list_parsers() -> list[str]:
    """Return the names of the registered parsers.

    Examples
    --------
    >>> "rules" in list_parsers()
    True
    """
    return list(PARSERS)


def parse(
    text: str,
    city: CityMap,
    targets: Sequence[TargetObject] | None = None,
    parser: str | Parser = "rules",
    viewpoint: Viewpoint = "map",
    *,
    hearer: tuple[float, float] | None = None,
) -> Description:
    """Read what a text says about where objects are on a map.

    Parameters
    ----------
    text
        What a person says.
    city
        The map it speaks of.
    targets
        The objects that it can speak of; None for GreenToyota, RedHonda and RedBike, and for any
        other object the text names.
    parser
        Name of a registered parser, ``"module:name"`` of one of yours, or a parser.
    viewpoint
        Where who speaks looks from; see :class:`sloop_ppl.language.Description`.
    hearer
        Where who listens is, (x_m, y_m), inside the map or outside; None when no one knows.

    Returns
    -------
    Description
        Relations with character spans, and what was not understood. A text in which nothing is
        understood gives a description without relations.

    Raises
    ------
    UnknownName
        When no parser has this name, or there is no such viewpoint.
    InputError
        When `text` is not a string, or longer than `LONGEST_TEXT` characters.
    DescriptionError
        When two targets share an id, or `hearer` is not two finite numbers.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> said = parse("The green toyota is behind velvet dog", load_map("cleveland"))
    >>> [(r.figure, r.relation, r.ground) for r in said.relations]
    [('GreenToyota', 'behind', 'VelvetDog')]
    """
    read = find_parser(parser) if isinstance(parser, str) else parser
    if not isinstance(text, str):
        raise InputError(f"The text is a {type(text).__name__}; expected a string")
    if len(text) > LONGEST_TEXT:
        raise InputError(
            f"The text has {len(text):,} characters; expected {LONGEST_TEXT:,} at most: give what "
            "one person says at a time"
        )
    if targets is not None:
        targets = tuple(targets)
        check_targets(targets)
    found = read(text, city, targets)
    if viewpoint != found.viewpoint:
        found = replace(found, viewpoint=viewpoint)
    return found.placed(hearer)


def _rules(text: str, city: CityMap, targets: Sequence[TargetObject] | None) -> Description:
    from sloop_ppl.language.rules import read_rules

    return read_rules(text, city, targets)


def _dependency_paths(
    text: str, city: CityMap, targets: Sequence[TargetObject] | None
) -> Description:
    from sloop_ppl._extras import need_extra

    need_extra("Parser 'dependency_paths'", "spacy", "spacy")
    from sloop_ppl.language.dependency import shared_dependency_parser

    return shared_dependency_parser()(text, city, targets)


PARSERS.add("rules", _rules)
PARSERS.add("dependency_paths", _dependency_paths)
