"""Read one relation phrase: "about 50 feet west of", "at the corner of A and B", "on the left"."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sloop_ppl.language.distances import JUST_PAST
from sloop_ppl.language.grounds import Ground, GroundReader, is_certain
from sloop_ppl.language.items import Cue
from sloop_ppl.language.relations import RELATIONS
from sloop_ppl.language.values import Distance

__all__ = ["RelationPhrase", "read_relation"]

_MOST_GROUNDS = 6
_MOST_PARTS = 8
_PARTS = ("part", "junction", "skip", "none", "dir")
_JOINING = ("between", "on", "at", "in")
_JUST = ("just", "right", "barely", "bit", "little", "slightly", "immediately", "touch", "tad")
_CONTACT = ("at", "on", "in")
_ONWARD = ("above", "up", "down", "along")
_OTHER_SIDE = ("across", "beside", "beyond")
_OPEN_WAYS = ("street", "service", "pedestrian")
_CLOCK_WORDS = ("position", "direction", "mark", "relative", "relation", "respect", "with", "side")
_DIALS = frozenset(("clock", "dial", "clockface", "watch"))
_CENTRES = frozenset(("center", "centre", "middle"))
_LOOKS_BACK = 30
_MEETS_M = 15.0
"""Farthest that the axes of two streets that meet end from one another: the wider's half width."""


@dataclass(frozen=True, slots=True)
class RelationPhrase:
    """One or several relations to the same grounds.

    Parameters
    ----------
    relations
        Canonical relations, at least one unless only a ground was understood.
    grounds
        What they are about; for `joint` relations all at once.
    joint
        Whether the grounds belong to one relation (between, corner).
    corner
        Whether that is a corner.
    part
        Whether a part was named ("side", "corner").
    own
        Whether it is a side of what was spoken of ("to its left").
    each
        Whether it holds of each ground by itself ("not near a bank").
    negated
        Whether the phrase is denied.
    distance
        The distance that was said, or bounds on it.
    cue
        Half-open range of words of the cue.
    last
        Word after the phrase.
    """

    relations: tuple[str, ...]
    grounds: tuple[Ground, ...]
    cue: tuple[int, int]
    last: int
    joint: bool = False
    corner: bool = False
    part: bool = False
    negated: bool = False
    distance: Distance | None = None
    own: bool = False
    each: bool = False


def read_relation(reader: GroundReader, at: int) -> tuple[RelationPhrase, int] | None:
    """Return the relation phrase that begins at an item and the item after it, else None.

    Parameters
    ----------
    reader
        The text's items and the places spoken of so far.
    at
        Position of the first item; a distance may come first.
    """
    start = at
    distance: Distance | None = None
    at = reader.past(at, "skip")
    just = at > 0 and reader.norms[reader.chunks[at - 1].last - 1] in _JUST
    if reader.kind(at) == "distance":
        distance = reader.chunks[at].value
        at = reader.past(at + 1, "skip")
        if reader.kind(at) == "cue" and reader.chunks[at].value.relation in ("within",):
            at += 1
    elif reader.kind(at) == "cue" and reader.kind(reader.past(at + 1, "skip")) == "distance":
        inner = read_relation(reader, reader.past(at + 1, "skip"))
        near = reader.chunks[at].value.relation in ("within", "at", "in", "near")
        if near and (inner is None or not inner[0].grounds):  # "behind it by ten metres"
            chunk = reader.chunks[at]
            return RelationPhrase((), (), (chunk.first, chunk.last), chunk.last), at + 2
        if inner is not None and near:
            return replace(inner[0], cue=(reader.chunks[at].first, inner[0].cue[1])), inner[1]
    cue = reader.chunks[at].value if reader.kind(at) == "cue" else None
    found = _head(reader, at, distance is not None)
    if found is None:
        return None
    phrase, after = found
    if distance is not None:
        away = cue is not None and cue.negated  # "20 m away from" says where it is
        contact = all(RELATIONS[r].relation_class == "contact" for r in phrase.relations)
        phrase = replace(phrase, cue=(reader.chunks[start].first, phrase.cue[1]))
        phrase = replace(phrase, negated=phrase.negated != away)
        if not phrase.grounds and cue is not None and cue.relation in _ONWARD:
            phrase = replace(phrase, relations=())  # "one block over" from who knows where
        return (phrase if contact else replace(phrase, distance=distance)), after
    if cue is not None and cue.distance is not None:
        phrase = replace(phrase, distance=cue.distance)
    elif just and phrase.relations == ("beyond",) and not phrase.negated:
        phrase = replace(phrase, distance=JUST_PAST)
    return phrase, after


def _head(reader: GroundReader, at: int, measured: bool) -> tuple[RelationPhrase, int] | None:
    """Read the part after a distance."""
    kind = reader.kind(at)
    first = reader.chunks[at].first if kind != "end" else 0
    if kind in ("from", "of") and measured:
        return _away_from(reader, at, first)
    if kind == "clock":
        return _clock(reader, at, first)
    if kind in ("to", "from"):
        onward = _past_leads(reader, at + 1)
        if reader.kind(onward) == "robot":  # "two blocks to your north"
            onward = _past_leads(reader, onward + 1)
        return _direction(reader, onward, first, None) if reader.kind(onward) == "dir" else None
    if kind == "dir":
        return _direction(reader, at, first, None)
    if kind == "junction":
        return _junction(reader, at, first, ("at",))
    if kind != "cue":
        return None
    cue: Cue = reader.chunks[at].value
    onward = _past_leads(reader, at + 1)
    ahead = reader.kind(onward)
    if ahead == "robot" and reader.kind(_past_leads(reader, onward + 1)) == "dir":
        ahead, onward = "dir", _past_leads(reader, onward + 1)
    if ahead == "dir" and not reader.selects(onward):
        return _direction(reader, onward, first, cue)
    if ahead == "clock":
        return _clock(reader, onward, first)
    if ahead == "junction":
        return _junction(reader, onward, first, (cue.relation,), cue.negated)
    if RELATIONS[cue.relation].grounds == "several":
        return _several(reader, at, cue.relation)
    return _simple(reader, at, at + 1, cue.relation, cue.negated)


def _away_from(reader: GroundReader, at: int, first: int) -> tuple[RelationPhrase, int] | None:
    """Read "(20 m) from X", "(the second car) from the corner of A and B"."""
    onward = _past_leads(reader, at + 1)
    if reader.kind(onward) != "junction":
        return _simple(reader, at, at + 1, "near")
    phrase, after = _junction(reader, onward, first, ("near",))
    return (phrase if phrase.grounds else replace(phrase, relations=())), after


def _clock(reader: GroundReader, at: int, first: int) -> tuple[RelationPhrase, int]:
    """Read "three o'clock from X"; without a place to look from it is a time."""
    direction = str(reader.chunks[at].value)
    span = first, reader.chunks[at].last
    onward = at + 1
    while reader.value(onward) in _CLOCK_WORDS or reader.kind(onward) in ("skip", "none"):
        onward += 1
    if reader.kind(onward) in ("of", "from", "to"):
        got = reader.read(onward + 1)
        if got is not None:
            ground, after = got
            return RelationPhrase((direction,), (ground,), span, ground.last), after
    seen_from = _looked_from(reader, at)
    if seen_from is None:
        return RelationPhrase((), (), span, span[1]), at + 1
    return RelationPhrase((direction,), (seen_from,), span, span[1]), at + 1


def _looked_from(reader: GroundReader, at: int) -> Ground | None:
    """Return the place of "from X, ... at three o'clock", or of "X is the centre of a clock"."""
    back = at - 1
    while back >= 0 and reader.kind(back) in ("det", "skip", "none", "cue"):
        back -= 1
    if reader.kind(back) in ("robot", "possessive"):
        return None
    if reader.kind(back) == "landmark" and _possessive(reader, at):
        return reader.landmark(back)
    stopped = False
    for k in range(back, max(-1, back - _LOOKS_BACK), -1):
        stopped = stopped or reader.kind(k) == "stop"
        if reader.kind(k) != "landmark":
            continue
        begin, end = reader.chunks[k].first, reader.chunks[k].last
        dial = not _DIALS.isdisjoint(reader.norms[max(0, begin - _LOOKS_BACK // 3) : end + 10])
        dial = dial or not _CENTRES.isdisjoint(reader.norms[end : end + 4])
        seen_from = reader.kind(_past_back(reader, k - 1)) == "from" and not stopped
        if dial or seen_from:
            return reader.landmark(k)
    return None


def _past_back(reader: GroundReader, at: int) -> int:
    """Return the position before articles and the like that stand before an item."""
    end = at - _MOST_PARTS
    while at > end and reader.kind(at) in ("det", "skip", "none", "where", "same"):
        at -= 1
    return at


def _possessive(reader: GroundReader, at: int) -> bool:
    """Whether the word before an item owns it."""
    low = reader.words[reader.chunks[at].first - 1].low
    return low == "'" or low.endswith("'s")


def _past_leads(reader: GroundReader, at: int) -> int:
    """Return the position after articles, intensifiers and "my": where a direction may stand."""
    return reader.past(at, "det", "skip", "possessive", "none")


def _simple(
    reader: GroundReader, at: int, onward: int, relation: str, negated: bool = False
) -> tuple[RelationPhrase, int] | None:
    """Read a cue and its grounds, each of which makes a relation of its own."""
    chunk = reader.chunks[at]
    cue = chunk.first, chunk.last
    denied = reader.past(onward, "skip")
    if reader.kind(denied) == "neg":
        negated, onward = not negated, denied + 1
    if (
        reader.kind(onward) == "comma"
        and reader.kind(_past_leads(reader, onward + 1)) == "landmark"
    ):
        onward += 1
    got = reader.read(onward)
    if got is None:
        return RelationPhrase((relation,), (), cue, chunk.last, negated=negated), onward
    ground, after = got
    vague = ground.kind == "unknown" or not is_certain(ground)
    if vague and relation == "across" and reader.kind(after - 1) == "place":
        return RelationPhrase((relation,), (), cue, ground.last, negated=negated), after
    if ground.kind == "map" and relation in _CONTACT:  # "on the map" says nothing of where
        return RelationPhrase((), (), cue, ground.last), after
    beyond = _other_side(reader, chunk.first, relation, ground, after)
    if beyond is not None:
        relation, ground, after = "across", *beyond
    if ground.kind == "landmark":
        sided = _own_side(reader, after)
        if sided is not None:
            directions, past = sided
            phrase = RelationPhrase(directions, (ground,), cue, ground.last, negated=negated)
            return phrase, past
        if reader.kind(after) == "part":
            after += 1
            if reader.kind(after) == "of":
                other = reader.read(after + 1)
                after = other[1] if other is not None else after + 1
        if reader.kind(after) == "junction" and reader.kind(after + 1) != "of":
            after += 1
    beginning = after
    grounds, after, corner = _more(reader, ground, after)
    if not corner and _meet(reader, relation, grounds):
        corner = all(reader.kind(k) != "or" for k in range(beginning, after))
    amid = relation == "middle" and len(grounds) == 2 and not corner
    relation, joint = ("between", True) if amid else (relation, corner)
    phrase = RelationPhrase(
        (relation,), grounds, cue, grounds[-1].last, joint, corner, negated=negated
    )
    return phrase, after


def _other_side(
    reader: GroundReader, first: int, relation: str, ground: Ground, after: int
) -> tuple[Ground, int] | None:
    """Return B of "across A from B", "on the other side of A from B", A a street or the like."""
    sided = relation in _OTHER_SIDE and "side" in reader.norms[first : ground.first]
    if not (sided or relation == "across") or ground.kind not in ("landmark", "unknown"):
        return None
    if sided and ground.kind == "landmark" and not _is_way(reader, ground):
        return None
    if reader.kind(after) == "from":
        got = reader.read(reader.past(after + 1, "skip"))
        return got if got is not None and got[0].kind in ("landmark", "figure", "robot") else None
    if not sided:
        return None
    start = next(
        (
            k
            for k in range(after, max(0, after - _LOOKS_BACK), -1)
            if k < len(reader.chunks) and reader.chunks[k].first <= first
        ),
        after,
    )
    for k in range(start - 1, max(-1, start - _LOOKS_BACK), -1):  # "from B, it is on ... of A"
        if reader.kind(k) == "stop":
            return None
        if reader.kind(k) == "landmark" and reader.kind(_past_back(reader, k - 1)) == "from":
            return reader.landmark(k), after
    return None


def _is_way(reader: GroundReader, ground: Ground) -> bool:
    """Whether a ground is a street, a path or an alley."""
    position = reader.places.position(ground.ids[0])
    return position is not None and reader.places.index.landmarks[position].kind in _OPEN_WAYS


def _meet(reader: GroundReader, relation: str, grounds: tuple[Ground, ...]) -> bool:
    """Whether "at A and B" means where two streets meet."""
    if relation not in _CONTACT or len(grounds) != 2 or grounds[0].ids == grounds[1].ids:
        return False
    if not all(_is_way(reader, ground) for ground in grounds):
        return False
    shapes = [
        reader.places.index.landmarks[reader.places.position(g.ids[0]) or 0].geometry
        for g in grounds
    ]
    return bool(shapes[0].distance(shapes[1]) < _MEETS_M)


def _own_side(reader: GroundReader, at: int) -> tuple[tuple[str, ...], int] | None:
    """Read "'s north side" after a ground."""
    word = reader.words[reader.chunks[at - 1].last - 1].low if at else ""
    if reader.kind(at) == "clock" and _possessive(reader, at):
        return (str(reader.chunks[at].value),), at + 1
    if reader.kind(at) != "dir" or not word.endswith("'s"):
        return None
    directions = tuple(reader.chunks[at].value)
    return directions, reader.past(at + 1, "part", "junction")


def _more(reader: GroundReader, ground: Ground, at: int) -> tuple[tuple[Ground, ...], int, bool]:
    """Read further grounds after "and" or a comma; tell whether a corner of them was meant."""
    grounds = [ground]
    while len(grounds) < _MOST_GROUNDS and ground.kind == "landmark":
        onward = reader.past(at, "comma", "and", "or", "skip", "none")
        if reader.value(onward) == "nor":
            onward += 1
        if onward == at or all(reader.kind(k) in ("skip", "none") for k in range(at, onward)):
            break
        after = _past_leads(reader, onward)
        if reader.kind(after) != "landmark" or _is_subject(reader, after + 1):
            break
        if reader.kind(onward - 1) == "comma" and not _listed(reader, after):
            break
        ground, at = reader.read(after) or (ground, at)
        grounds.append(ground)
    corner = False
    if len(grounds) > 1 and reader.kind(at) == "junction" and reader.kind(at + 1) != "of":
        corner, at = True, at + 1
    return tuple(grounds), at, corner


def _is_subject(reader: GroundReader, at: int) -> bool:
    """Whether the place before an item begins a clause of its own ("and the Dresden is ...")."""
    at = reader.past(at, "skip", "none", "place")
    if reader.kind(at) == "neg":
        return True
    if reader.kind(at) != "be":
        return False
    onward = reader.past(at + 1, "be", "skip", "det", "possessive", "same")
    return reader.kind(onward) != "figure"


def _listed(reader: GroundReader, at: int) -> bool:
    """Whether a place after a comma goes on a list, or is an address ("Ivy, West 6th Street")."""
    return reader.kind(at + 1) in ("and", "or", "comma", "stop", "end")


def _several(reader: GroundReader, at: int, relation: str) -> tuple[RelationPhrase, int] | None:
    """Read "between A and B (and C)": one relation with all grounds."""
    chunk = reader.chunks[at]
    cue = chunk.first, chunk.last
    grounds, after = _all_of(reader, at + 1)
    if not grounds:
        return RelationPhrase((relation,), (), cue, chunk.last), at + 1
    return RelationPhrase((relation,), grounds, cue, grounds[-1].last, joint=True), after


def _all_of(reader: GroundReader, at: int) -> tuple[tuple[Ground, ...], int]:
    """Return the grounds of a list that belongs together: at least two if they can be found."""
    grounds: list[Ground] = []
    onward = at
    while len(grounds) < _MOST_GROUNDS:
        got = reader.read(onward)
        if got is None:
            break
        ground, after = got
        if len(grounds) > 1 and (ground.kind != "landmark" or _is_subject(reader, after)):
            break
        if grounds and ground.kind == "figure" and _figure_goes_on(reader, after):
            break
        grounds.append(ground)
        at = after
        if reader.kind(at) == "junction" and reader.kind(at + 1) != "of":
            at += 1
        onward = reader.past(at, "comma", "and", "or", "skip", "none")
        if onward == at:
            break
        if len(grounds) > 1 and not any(reader.kind(k) in ("and", "or") for k in range(at, onward)):
            break
        if reader.kind(onward) in ("cue", "to", "from", "dir"):
            break
    return tuple(grounds), at


def _figure_goes_on(reader: GroundReader, at: int) -> bool:
    return reader.kind(at) in ("be", "cue", "neg")


def _junction(
    reader: GroundReader, at: int, first: int, relations: tuple[str, ...], negated: bool = False
) -> tuple[RelationPhrase, int]:
    """Read "corner of A and B"; without grounds the streets spoken of last are meant."""
    cue = first, reader.chunks[at].last
    onward = reader.past(at + 1, "of", "skip", "where", "houses", "junction", "from")
    if reader.kind(onward) == "cue" and reader.chunks[onward].value.relation in _JOINING:
        onward = reader.past(onward + 1, "of", "skip")
    grounds, after = _all_of(reader, onward)
    if not grounds:
        return RelationPhrase(relations, (), cue, cue[1], negated=negated), at + 1
    joint = len(grounds) > 1
    phrase = RelationPhrase(
        relations, grounds, cue, grounds[-1].last, joint, joint, negated=negated
    )
    return phrase, after


def _direction(
    reader: GroundReader, at: int, first: int, cue: Cue | None
) -> tuple[RelationPhrase, int] | None:
    """Read "north of", "on the upper left corner of", "to its left", "on the right side"."""
    if cue is not None and cue.relation == "towards":
        return RelationPhrase((), (), (first, first), reader.chunks[at].last), at + 1
    directions = tuple(reader.chunks[at].value)
    own = _owner(reader, at - 1) if first < reader.chunks[at].first else ""
    onward = at + 1
    corner = part = False
    while onward < at + _MOST_PARTS and reader.kind(onward) in _PARTS:
        if reader.kind(onward) == "dir":
            directions += tuple(reader.chunks[onward].value)
        corner = corner or reader.kind(onward) == "junction"
        part = part or reader.kind(onward) in ("part", "junction")
        onward += 1
    near = cue is not None and part and RELATIONS[cue.relation].relation_class == "proximity"
    span = first, reader.chunks[onward - 1].last
    negated = cue is not None and cue.negated
    if own == "robot":
        robot = Ground("robot", *span)
        return RelationPhrase(directions, (robot,), span, span[1]), onward
    if own == "it":
        got = reader.read(at - 1) if reader.chunks[at - 1].value == "it" else None
        back = got[0] if got else reader.last_ground()
        owners = (back,) if back is not None else ()
        return RelationPhrase(directions, owners, span, span[1], own=True), onward
    if reader.kind(onward) == "comma" and reader.kind(onward + 1) == "of":
        onward += 1
    linked = reader.kind(onward) in ("of", "from") or (reader.kind(onward) == "to" and not part)
    if linked:
        onward += 1
        nested = _past_leads(reader, onward)
        if reader.kind(nested) == "junction":
            return _junction(reader, nested, first, directions, negated)
    direct = reader.kind(_past_leads(reader, onward)) == "landmark" and not part
    if not (linked or direct):
        bare = RelationPhrase(directions, (), span, span[1], part=part, negated=negated)
        return bare, onward
    grounds: tuple[Ground, ...] = ()
    after = onward
    if corner:
        grounds, after = _all_of(reader, onward)
    if not grounds:
        got = reader.read(onward)
        if got is None:
            return RelationPhrase(directions, (), span, span[1], negated=negated), onward
        grounds, after, _ = _more(reader, got[0], got[1])
    if grounds[0].kind == "map":
        directions = _map_sides(directions)
    crossing = corner and len(grounds) > 1
    if directions == ("middle",) and len(grounds) == 2:
        return RelationPhrase(("between",), grounds, span, grounds[-1].last, joint=True), after
    if cue is not None and (near or crossing):
        directions = (cue.relation, *directions)
    phrase = RelationPhrase(
        directions, grounds, span, grounds[-1].last, crossing, crossing, part, negated
    )
    return phrase, after


def _map_sides(directions: tuple[str, ...]) -> tuple[str, ...]:
    """Return compass words for the sides of the map: its top is north."""
    compass = [_map_side(d) for d in directions]
    if len(compass) == 2 and compass[0] in ("north", "south") and compass[1] in ("east", "west"):
        return (compass[0] + compass[1],)
    return tuple(compass)


def _map_side(direction: str) -> str:
    """Return the compass word for a side of the map; its front stays a front."""
    record = RELATIONS[direction]
    if record.needs_frame and not record.absolute:
        return direction
    return record.of_map or direction


def _owner(reader: GroundReader, at: int) -> str:
    """Return whose side it is: the robot's ("your left"), a place's ("its left"), or nobody's."""
    if reader.kind(at) in ("skip", "none"):
        at -= 1
    if reader.kind(at) == "robot" or reader.value(at) in ("my", "our"):
        return "robot"
    if reader.kind(at) == "det" and reader.chunks[at].value in ("its", "their"):
        return "it"
    return ""
