"""Say in one line what was recognised in a text in which no relation was found."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rapidfuzz import process

from sloop_ppl.errors import NoRelationFound
from sloop_ppl.language._place_names import PlaceNames
from sloop_ppl.language.figures import figure_finder
from sloop_ppl.language.place_index import place_index
from sloop_ppl.language.reading import TextReading, find_cues, find_figures, find_landmarks, relate
from sloop_ppl.language.values import Description, TargetObject, Unresolved
from sloop_ppl.maps import CityMap

__all__ = ["Recognised", "no_relation_found", "recognised"]

_SHOWN = 60
_EXAMPLE = "the red bike is behind NAME"


@dataclass(frozen=True)
class Recognised:
    """What was recognised in a text, used in a relation or not.

    Parameters
    ----------
    targets
        Ids of the objects.
    landmarks
        Ids of the landmarks.
    cues
        Canonical relations that were said.
    """

    targets: tuple[str, ...]
    landmarks: tuple[str, ...]
    cues: tuple[str, ...]


def recognised(
    text: str, city: CityMap, targets: Sequence[TargetObject] | None = None
) -> Recognised:
    """Return what the rule parser recognises in `text`, whether or not it fits together.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> recognised("Velvet Dog! And a green car, north.", load_map("cleveland"))
    Recognised(targets=('GreenToyota',), landmarks=('VelvetDog',), cues=('north',))
    """
    state = TextReading(text, city, place_index(city), figure_finder(targets))
    for step in (find_landmarks, find_figures, find_cues, relate):
        step(state)
    landmarks = [state.places.id(m.candidates[0]) for m in state.landmarks]
    cues = [i.value.relation for i in state.chunks if i.kind == "cue"]
    cues += [d for i in state.chunks if i.kind == "dir" for d in i.value]
    return Recognised(
        tuple(t.id for t in state.targets),
        tuple(dict.fromkeys(landmarks)),
        tuple(dict.fromkeys(cues)),
    )


def no_relation_found(
    description: Description, city: CityMap, targets: Sequence[TargetObject] | None = None
) -> NoRelationFound:
    """Return the error to raise for a description without relations.

    Parameters
    ----------
    description
        What was read.
    city
        The map it was read on.
    targets
        The objects that could be spoken of.

    Returns
    -------
    NoRelationFound
        One line: which targets, landmarks and cues were recognised, and for each name that is
        not on the map the nearest names.

    Examples
    --------
    >>> from sloop_ppl.language import parse
    >>> from sloop_ppl.maps import load_map
    >>> city = load_map("cleveland")
    >>> str(no_relation_found(parse("hello", city), city)).split("; ")[:2]
    ["No relation found in 'hello'", 'recognised no target, no landmark, no relation word']
    """
    known = recognised(description.text, city, targets)
    text = " ".join(description.text.split())
    text = text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."
    parts = [
        f"No relation found in '{_printable(text)}'",
        "recognised "
        + ", ".join(
            (
                _listed("target", known.targets),
                _listed("landmark", known.landmarks),
                _listed("relation word", known.cues),
            )
        ),
        *(_missing(u, PlaceNames(city, [description])) for u in description.unresolved[:3]),
        f"say where an object is, such as '{_EXAMPLE}', with a NAME from map '{city.name}'",
    ]
    return NoRelationFound("; ".join(parts))


def _listed(what: str, found: Iterable[str]) -> str:
    names = list(found)
    if not names:
        return f"no {what}"
    shown = ", ".join(names[:5]) + (", ..." if len(names) > 5 else "")
    return f"{what}{'s' if len(names) > 1 else ''} {shown}"


def _missing(unresolved: Unresolved, names: PlaceNames) -> str:
    text = _printable(" ".join(unresolved.text.split())[:_SHOWN])
    labels = [names.of(c) for c in unresolved.candidates]
    if not labels:
        known = [names.of(m.id) for m in names.city.landmarks if m.name]
        # rapidfuzz ranks all names, however far, where the linker offers only the plausible ones.
        labels = [name for name, _, _ in process.extract(text, known, limit=3)]
    near = ", ".join(labels) or "none has a name"
    return f"'{text}' was not found on map '{names.city.name}' (nearest: {near})"


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in text)
