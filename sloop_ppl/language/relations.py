"""The relation words: one record each, which every part of the package reads."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from sloop_ppl.errors import InputError
from sloop_ppl.registry import Registry

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from sloop_ppl.maps import CityMap

__all__ = ["RELATIONS", "WHOLE_MAP", "Relation", "words_by_class"]

WHOLE_MAP = "Map"
"""Id of the map itself as a ground ("the top left of the map"), unless a landmark has it."""

Width: TypeAlias = Literal["contact", "proximity", "between", "across", "directed"]
Region: TypeAlias = "Callable[[CityMap, tuple[str, ...]], BaseGeometry | None]"


@dataclass(frozen=True)
class Relation:
    """What a relation word means, how it is heard and how it is said.

    Parameters
    ----------
    relation_class
        Words of one class mean the same: evaluation merges them (`class_f1`), and a speaker
        chooses one of them.
    forms
        Surface forms that a ground follows, such as ``"in front of"``.
    denied_forms
        The same, of forms that deny it: "far from" is not near.
    directions
        Words for a side, such as ``"northern"``, read in "to the ... of", "on the ... side of".
    phrase
        How a speaker says it before a ground's name; the first of `forms` unless given.
    converse
        Word for the relation of the ground to the figure; None where there is none.
    grounds
        How many grounds it takes at once: ``"one"``, ``"several"`` ("between A and B") or
        ``"any"``. More than it takes are a corner, and the place where they meet is meant.
    bearing_rad
        Direction of a compass word, radians anticlockwise from east.
    offset_rad
        Direction of a frame word less the direction that the ground faces, radians.
    absolute
        Whether a frame word may be meant of the map's frame instead (left and right).
    width
        Which of a likelihood's widths it takes; that of its class or direction unless given, and
        ``"proximity"`` where it has neither.
    region
        What it measures from: a name in `sloop_ppl.models.REGIONS`, or a function of the map and
        the grounds' ids that returns a shape in metres, or None for the grounds themselves. Not
        asked where the map itself is the ground, nor by models that ground each phrase on one
        ground as the paper does.
    of_map
        Word that it means when the ground is the map: its left is west.
    from_ground
        Word that it means to someone who stands on the ground instead of looking at a map; None
        where that is no other. See :class:`sloop_ppl.language.Description`.
    bare
        Whether it may end a clause without a ground: "..., and the car is behind".
    part
        Whether it names a part of its ground: "in the middle".
    speakable
        Whether a simulated speaker chooses it, and listeners with ``speaker`` normalisation count
        it among what could have been said.

    Raises
    ------
    InputError
        When it can be said in no way, or has two directions.

    Examples
    --------
    >>> RELATIONS["front"].needs_frame, RELATIONS["front"].converse
    (True, 'behind')
    """

    relation_class: str
    forms: tuple[str, ...] = ()
    denied_forms: tuple[str, ...] = ()
    directions: tuple[str, ...] = ()
    phrase: str = ""
    converse: str | None = None
    grounds: Literal["one", "several", "any"] = "one"
    bearing_rad: float | None = None
    offset_rad: float | None = None
    absolute: bool = False
    width: Width | None = None
    region: str | Region | None = None
    of_map: str | None = None
    from_ground: str | None = None
    bare: bool = False
    part: bool = False
    speakable: bool = False

    def __post_init__(self) -> None:
        if not (self.phrase or self.forms):
            raise InputError(
                f"A relation of class '{self.relation_class}' has no words; expected forms, or a "
                "phrase to say it by"
            )
        if self.is_compass and self.needs_frame:
            raise InputError(
                f"A relation of class '{self.relation_class}' has a bearing and an offset; "
                "expected one direction: bearing_rad on the map, or offset_rad from a front"
            )
        object.__setattr__(self, "phrase", self.phrase or self.forms[0])
        if self.width is None:
            object.__setattr__(self, "width", self._usual_width())

    @property
    def needs_frame(self) -> bool:
        """Whether its direction depends on which way the ground faces."""
        return self.offset_rad is not None

    @property
    def is_compass(self) -> bool:
        """Whether its direction is fixed by the map."""
        return self.bearing_rad is not None

    def takes(self, grounds: int) -> bool:
        """Return whether so many grounds make one relation that has its own meaning."""
        return {"one": grounds == 1, "several": grounds > 1, "any": True}[self.grounds]

    def _usual_width(self) -> Width:
        if self.is_compass or self.needs_frame:
            return "directed"
        own: dict[str, Width] = {"contact": "contact", "between": "between", "across": "across"}
        return own.get(self.relation_class, "proximity")


RELATIONS: Registry[Relation] = Registry("relation")
"""Canonical relation word -> what it means; add your own with ``RELATIONS.add(word, record)``."""


def words_by_class() -> dict[str, tuple[str, ...]]:
    """Return the words of each class, in the order they were added.

    Examples
    --------
    >>> words_by_class()["south"]
    ('south', 'below', 'down', 'under')
    """
    found: dict[str, tuple[str, ...]] = {}
    for word, record in RELATIONS.items():
        found[record.relation_class] = (*found.get(record.relation_class, ()), word)
    return found


# Directions of frame words: SLOOP fig. 4 (right is 90 degrees clockwise of front). The published
# code has southwest at 75 degrees of its compass, a slip for 135; not followed.
_ENGLISH: dict[str, Relation] = {
    "on": Relation(
        "contact",
        forms=("on", "onto", "upon", "on top of", "up top of", "atop", "on the top of"),
    ),
    "at": Relation(
        "contact", forms=("at", "@"), denied_forms=("absent from",),
        speakable=True,
    ),
    "in": Relation("contact", forms=("in", "into")),
    "inside": Relation(
        "contact", bare=True,
        forms=("inside", "inside of", "in side of", "in side", "on the inside of",
            "at the inside of"),
    ),
    "along": Relation(
        "contact", region="along",
        forms=("along", "alongside", "alongside of", "along side", "along side of",
            "halfway along", "midway along"),
    ),
    "within": Relation("contact", forms=("within",)),
    "middle": Relation(
        "contact", of_map="middle", part=True,
        forms=("in the middle of", "at the middle of", "in the center of", "in the centre of",
            "at the center of", "at the centre of"),
        directions=("middle", "center", "centre"),
    ),
    "side": Relation(
        "contact", part=True,
        forms=("at the side of", "on the side of", "to the side of", "on one side of",
            "on either side of", "on a side of", "by the side of"),
    ),
    "adjacent": Relation(
        "contact", converse="adjacent", bare=True,
        forms=("adjacent to", "adjacent", "adjoining", "bordering", "abutting", "touching",
            "attached to"),
    ),
    "near": Relation(
        "proximity", converse="near", bare=True, speakable=True,
        forms=("near", "near to", "near by", "nearby", "nearby to", "nearest to", "nearest",
            "nearer to", "nearer", "in the vicinity of", "in the area of", "in proximity to",
            "a short walk from", "by", "over by", "hard by", "around the corner from",
            "steps from", "steps away from", "doors down from", "doors from",
            "next door but one to", "next but one to", "in the neighborhood of",
            "in the neighbourhood of", "this side of", "on this side of", "on the near side of",
            "short of", "just before", "right before", "shortly before", "along from", "on from",
            "along the street from", "up the street from", "up the way from", "up the block from",
            "up the alley from", "up the hill from", "uphill from", "uphill of",
            "down the street from", "down the way from", "down the block from",
            "down the alley from", "down the hill from", "downhill from", "downhill of"),
        denied_forms=("far from", "far away from", "a long way from", "a long way away from",
            "nowhere near", "nowhere near to", "nowhere close to", "nowhere around", "nowhere by",
            "away from", "clear of", "miles from", "miles away from", "a good way from",
            "a good distance from"),
    ),
    "beside": Relation(
        "proximity", converse="beside", bare=True,
        forms=("beside", "besides", "on the other side of", "at the other side of",
            "other side of", "the other side of", "side by side with"),
    ),
    "next": Relation(
        "proximity", converse="next", bare=True,
        forms=("next to", "next door to", "next door from", "next of", "next from", "next with",
            "next by"),
    ),
    "by": Relation("proximity", phrase="by", converse="by"),
    "around": Relation("proximity", forms=("around", "round", "surrounding"), converse="around"),
    "close": Relation(
        "proximity", converse="close",
        forms=("close to", "close by", "closest to", "closer to", "close by to", "close from",
            "close of", "close with"),
    ),
    "outside": Relation("proximity", forms=("outside", "outside of"), bare=True),
    "towards": Relation("proximity", forms=("towards", "toward", "facing", "in the direction of")),
    "against": Relation(
        "proximity",
        forms=("against", "up against", "leaning on", "leans on", "leaned on", "leant on",
            "propped on"),
    ),
    "off": Relation("proximity", forms=("off", "off of")),
    "beyond": Relation(
        "proximity",
        forms=("beyond", "past", "on the far side of", "at the far side of", "far side of",
            "farther than", "further than", "just after", "right after", "shortly after",
            "immediately after"),
    ),
    "between": Relation(
        "between", grounds="several", region="between",
        forms=("between", "betwixt", "in between", "in the middle between", "halfway between",
            "midway between", "sandwiched between", "in the space between", "b/w"),
    ),
    "north": Relation(
        "north", phrase="north of", converse="south", bearing_rad=math.pi / 2, bare=True,
        speakable=True,
        directions=("north", "northern", "northerly", "northward", "northwards"),
    ),
    "above": Relation(
        "north", converse="below", bearing_rad=math.pi / 2, of_map="north", from_ground="at",
        bare=True,
        forms=("above", "over"),
    ),
    "up": Relation(
        "north", converse="down", bearing_rad=math.pi / 2, of_map="north", from_ground="near",
        forms=("up", "up from", "halfway up"),
    ),
    "top": Relation(
        "north", phrase="at the top of", converse="below", bearing_rad=math.pi / 2, of_map="north",
        from_ground="at",
        directions=("top", "upper", "topmost"),
    ),
    "south": Relation(
        "south", phrase="south of", converse="north", bearing_rad=-math.pi / 2, bare=True,
        speakable=True,
        directions=("south", "southern", "southerly", "southward", "southwards"),
    ),
    "below": Relation(
        "south", converse="above", bearing_rad=-math.pi / 2, of_map="south", from_ground="at",
        bare=True,
        forms=("below",),
        directions=("bottom", "lower"),
    ),
    "down": Relation(
        "south", converse="up", bearing_rad=-math.pi / 2, of_map="south", from_ground="near",
        forms=("down", "down from", "halfway down"),
    ),
    "under": Relation(
        "south", converse="above", bearing_rad=-math.pi / 2, of_map="south", from_ground="at",
        forms=("under", "underneath", "beneath"),
    ),
    "east": Relation(
        "east", phrase="east of", converse="west", bearing_rad=0.0, bare=True, speakable=True,
        directions=("east", "eastern", "easterly", "eastward", "eastwards"),
    ),
    "west": Relation(
        "west", phrase="west of", converse="east", bearing_rad=math.pi, bare=True, speakable=True,
        directions=("west", "western", "westerly", "westward", "westwards"),
    ),
    "northeast": Relation(
        "northeast", phrase="northeast of", converse="southwest", bearing_rad=math.pi / 4,
        bare=True, speakable=True,
        directions=("northeast", "northeastern", "ne"),
    ),
    "northwest": Relation(
        "northwest", phrase="northwest of", converse="southeast", bearing_rad=3 * math.pi / 4,
        bare=True, speakable=True,
        directions=("northwest", "northwestern", "nw"),
    ),
    "southeast": Relation(
        "southeast", phrase="southeast of", converse="northwest", bearing_rad=-math.pi / 4,
        bare=True, speakable=True,
        directions=("southeast", "southeastern", "se"),
    ),
    "southwest": Relation(
        "southwest", phrase="southwest of", converse="northeast", bearing_rad=-3 * math.pi / 4,
        bare=True, speakable=True,
        directions=("southwest", "southwestern", "sw"),
    ),
    "front": Relation(
        "front", converse="behind", offset_rad=0.0, of_map="north", bare=True, speakable=True,
        forms=("in front of", "in the front of", "at the front of", "out front of",
            "to the front of", "on the front of", "in front", "front of", "ahead of", "out front",
            "out the front of", "out the front", "at front of", "on front of",
            "round the front of", "around the front of", "round the front", "around the front",
            "round front of"),
        directions=("front",),
    ),
    "behind": Relation(
        "behind", converse="front", offset_rad=math.pi, of_map="south", bare=True, speakable=True,
        forms=("behind", "in back of", "in the back of", "at the back of", "on the back of",
            "to the back of", "out back of", "around the back of", "round the back of", "back of",
            "in the rear of", "at the rear of", "to the rear of", "on the rear of", "rear of",
            "around back of", "at the backside of", "on the backside of", "out back",
            "out the back of", "out the back", "round back of", "round back", "around back",
            "round the back", "around the back", "in back", "at back of", "round behind",
            "around behind", "out behind", "in the back", "in the rear", "at the rear"),
        directions=("back", "rear", "backside"),
    ),
    "left": Relation(
        "left", phrase="to the left of", converse="right", offset_rad=math.pi / 2, absolute=True,
        of_map="west", speakable=True,
        directions=("left", "lefthand", "leftmost"),
    ),
    "right": Relation(
        "right", phrase="to the right of", converse="left", offset_rad=-math.pi / 2, absolute=True,
        of_map="east", speakable=True,
        directions=("right", "righthand", "rightmost"),
    ),
    "across": Relation(
        "across", converse="across", grounds="any", region="across", bare=True,
        forms=("across from", "across", "opposite", "opposite to", "opposite of", "opposite from",
            "directly opposite", "across the street from", "across the road from",
            "across the way from", "across the intersection from", "across the alley from",
            "over the road from", "over the street from", "diagonally across from",
            "diagonally across", "diagonally opposite", "diagonally opposite to",
            "diagonally opposite of", "diagonally opposite from", "diagonally from",
            "diagonally to", "diagonal to", "diagonal from", "diagonal of",
            "diagonal across from", "on the diagonal from", "diagonally across the street from",
            "diagonally across the intersection from", "diagonally across the corner from",
            "kitty corner to", "kitty corner from", "kitty corner of", "kitty corner",
            "kitty corner across from", "kitty corner with", "on the kitty corner from",
            "kittycorner to", "kittycorner from", "kittycorner of", "kittycorner",
            "kittycorner across from", "on the opposite side of", "opposite side of",
            "on the other side of the street from", "on the other side of the road from",
            "on the opposite side of the street from", "on the opposite side of the road from"),
    ),
}  # fmt: skip

for _word, _record in _ENGLISH.items():
    RELATIONS.add(_word, _record)
