"""Read one relation phrase: "about 50 feet west of", "at the corner of A and B", "on the left"."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sloop_ppl.language.chunks import Cue
from sloop_ppl.language.grounds import Ground, GroundReader, is_certain
from sloop_ppl.language.relations import RELATIONS

__all__ = ["RelationPhrase", "read_relation"]

_MOST_GROUNDS = 6
_MOST_PARTS = 8
_PARTS = ("part", "junction", "skip", "none", "dir")
_JOINING = ("between", "on", "at", "in")


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
    distance_m
        The distance that was said.
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
    distance_m: float | None = None
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
    start, distance = at, None
    at = reader.past(at, "skip")
    if reader.kind(at) == "distance":
        distance = float(reader.chunks[at].value)
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
    found = _head(reader, at, distance is not None)
    if found is None:
        return None
    phrase, after = found
    if distance is not None:
        phrase = replace(phrase, distance_m=round(distance, 3))
        phrase = replace(phrase, cue=(reader.chunks[start].first, phrase.cue[1]))
    return phrase, after


def _head(reader: GroundReader, at: int, measured: bool) -> tuple[RelationPhrase, int] | None:
    """Read the part after a distance."""
    kind = reader.kind(at)
    first = reader.chunks[at].first if kind != "end" else 0
    if kind in ("from", "of") and measured:
        return _simple(reader, at, at + 1, "near")
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
    if ahead == "junction":
        return _junction(reader, onward, first, (cue.relation,), cue.negated)
    if RELATIONS[cue.relation].grounds == "several":
        return _several(reader, at, cue.relation)
    return _simple(reader, at, at + 1, cue.relation, cue.negated)


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
    if ground.kind == "landmark" and relation == "across" and reader.kind(after) == "from":
        got = reader.read(after + 1)
        if got is not None and got[0].kind == "landmark":
            ground, after = got
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
    grounds, after, corner = _more(reader, ground, after)
    phrase = RelationPhrase(
        (relation,), grounds, cue, grounds[-1].last, joint=corner, negated=negated
    )
    return phrase, after


def _own_side(reader: GroundReader, at: int) -> tuple[tuple[str, ...], int] | None:
    """Read "'s north side" after a ground."""
    word = reader.words[reader.chunks[at - 1].last - 1].low if at else ""
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
