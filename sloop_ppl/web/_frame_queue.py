"""The phrases whose frame of reference is annotated: of a description file, or of a map."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from sloop_ppl.bridge.relation_text import relation_in_words
from sloop_ppl.errors import InputError
from sloop_ppl.eval import AnnotatedDescription, read_descriptions
from sloop_ppl.language import RELATIONS, SpatialRelation, parse
from sloop_ppl.language._place_names import PlaceNames
from sloop_ppl.maps import PATH_KINDS, CityMap, load_map

__all__ = ["FrameItem", "items_of_file", "items_of_map"]

_WORDS = ("front", "left")
"""Asked of each place of a map; behind is the front turned round, right is left."""


@dataclass(frozen=True)
class FrameItem:
    """One phrase to annotate.

    Parameters
    ----------
    id
        Name of the item.
    map
        Name or path of its map, as description files have it.
    text
        The words that are shown.
    ground
        Id of the landmark whose front is wanted.
    relation
        The relation.
    """

    id: str
    map: str
    text: str
    ground: str
    relation: str


def items_of_map(city: CityMap, source: str) -> list[FrameItem]:
    """Return a phrase for each named place of a map that is no street, in front of it and left."""
    names = PlaceNames(city)
    named = [m for m in city.landmarks if m.name and m.kind not in PATH_KINDS]
    return [
        FrameItem(
            f"{city.name}/{landmark.id}/{word}",
            source,
            relation_in_words(SpatialRelation("Me", word, (landmark.id,)), names),
            landmark.id,
            word,
        )
        for word in _WORDS
        for landmark in named
    ]


def items_of_file(path: Path) -> list[FrameItem]:
    """Return the phrases of a description file that depend on a frame, each ground once a line.

    A line without gold relations is read.

    Raises
    ------
    InputError
        When the file cannot be used, or holds no such phrase.
    """
    items: dict[str, FrameItem] = {}
    for one in read_descriptions([path]):
        for relation in _relations(one):
            if not RELATIONS[relation.relation].needs_frame:
                continue
            for ground in relation.grounds:
                if ground in load_map(one.map):
                    name = f"{one.id}/{ground}/{relation.relation}"
                    items[name] = FrameItem(name, one.map, one.text, ground, relation.relation)
    if not items:
        raise InputError(
            f"'{path}' holds no front, behind, left or right of a landmark; expected some to "
            "annotate"
        )
    return list(items.values())


def _relations(one: AnnotatedDescription) -> tuple[SpatialRelation, ...]:
    if one.has_gold:
        return tuple(one.relations)
    return parse(one.text, load_map(one.map), viewpoint=one.viewpoint).relations
