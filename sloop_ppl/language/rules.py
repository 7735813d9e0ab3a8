"""Read a text with the rule parser: its four steps one after the other, without spaCy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from sloop_ppl.language.figures import figure_finder
from sloop_ppl.language.place_index import place_index
from sloop_ppl.language.reading import (
    TextReading,
    find_cues,
    find_figures,
    find_landmarks,
    relate,
    to_description,
)
from sloop_ppl.language.values import Description, TargetObject
from sloop_ppl.maps import CityMap

__all__ = ["STEPS", "begin", "encodable", "read_rules"]

Step = Callable[[TextReading], None]


def _attach(state: TextReading) -> None:
    relate(state)
    state.description = to_description(state)


STEPS: Final[Mapping[str, Step]] = MappingProxyType(
    {
        "sloop_landmarks": find_landmarks,
        "sloop_targets": find_figures,
        "sloop_cues": find_cues,
        "sloop_attachment": _attach,
    }
)
"""The steps in the order they run, by the names of the spaCy components that run them too."""


def encodable(text: str) -> str:
    """Return `text` with each lone surrogate, which UTF-8 cannot hold, as a question mark."""
    return text.encode("utf-8", "replace").decode("utf-8")


def begin(text: str, city: CityMap, targets: Sequence[TargetObject] | None) -> TextReading:
    """Return the state that the steps start from.

    Parameters
    ----------
    text
        The text, `encodable`.
    city
        The map it speaks of.
    targets
        The objects it can speak of; None for the default ones and any others.
    """
    return TextReading(text, city, place_index(city), figure_finder(targets))


def read_rules(
    text: str, city: CityMap, targets: Sequence[TargetObject] | None = None
) -> Description:
    """Read a text with the rule parser; the parser ``rules`` of the registry.

    Parameters
    ----------
    text
        Any text; what is not understood is reported, never an error.
    city
        The map it speaks of.
    targets
        The objects it can speak of; None for the default ones and any others.
    """
    state = begin(encodable(text), city, targets)
    for step in STEPS.values():
        step(state)
    found = state.description
    if found is None:
        raise RuntimeError("the step 'sloop_attachment' set no description")
    return found if found.text == text else replace(found, text=text)
