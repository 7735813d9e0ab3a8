"""Read what a relation is about: a named place, a kind of place, "it", "you", "the map"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from sloop_ppl.language._described import fits_relation, is_open_area, most_towards
from sloop_ppl.language.items import Chunk
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.linking import LandmarkMention
from sloop_ppl.language.nearest import nearest_landmarks
from sloop_ppl.language.place_index import KindFit, PlaceIndex
from sloop_ppl.language.referents import NONE_OF_KIND, candidates_of, of_a_kind
from sloop_ppl.language.relations import RELATIONS, WHOLE_MAP
from sloop_ppl.language.values import NOT_ON_MAP, SPEAKER, Candidate
from sloop_ppl.language.words import Word

__all__ = ["Ground", "GroundReader", "is_certain"]

_LONGEST_NAME = 8
_FARTHEST = 12
_DEEPEST = 6
_REMEMBERED = 30
_VAGUE = ("building", "street", "parking lot", "square", "water")
_ANYTHING = ("building", "street")
"""Kinds of which a map is made: "on the road" says hardly more than nothing."""

_AT_LARGE = {"a", "an", "any"}
_STOP = 0.1
"""Weight of a stop among places of its name that are none: by hand, one mention in ten."""

_NONE_OF_WIDER = 0.5
"""Share of none on this map where it has only a wider kind: by hand, an even chance."""

_BEFORE_NAMES = ("det", "skip", "possessive", "only", "same", "none")
_INTO = ("of", "to", "houses", "from")
_ONE = ("one", "ones")
_SELECTING = ("ern", "most")
_MOST_OF_KIND = 60
"""Places of a kind beyond which it tells nothing: one of hundreds of buildings is anywhere."""

_MOST_CANDIDATES = 24
_SETTLED = 4.0
"""Factor for the one of several equals that the text settles on, by its map or its kind."""

_BY_CHANCE = 0.1
"""How well a place that is not on the map fits what is said of it, where those on it fit by 1."""

_KNOWN_TO_BOTH = 0.3
"""Share of the place that contains one not on the map: "the bench in the park" is at the park."""

_OPEN_KINDS = frozenset(
    ("parking lot", "alley", "street", "park", "square", "water", "service road", "playground")
)


@dataclass(frozen=True, slots=True)
class Ground:
    """What a relation is about.

    Parameters
    ----------
    kind
        ``landmark``, ``figure``, ``robot``, ``map`` or ``unknown``.
    first, last
        Half-open range of words.
    ids
        Id of the most probable landmark, or ids of the figures; empty when unknown.
    nearest
        Ids of the landmarks that come nearest, where it is unknown.
    confidence
        How sure the link is, in [0, 1].
    every
        Ids of all landmarks of the kind, where any of it is spoken of ("a bank").
    candidates
        What it may be, the most probable first; empty when that is certain.
    mention
        Number of the place: the word where it was first spoken of; -1 for no place. Grounds of one
        number are the same place.
    """

    kind: str
    first: int
    last: int
    ids: tuple[str, ...] = ()
    nearest: tuple[str, ...] = ()
    confidence: float = 1.0
    every: tuple[str, ...] = ()
    candidates: tuple[Candidate, ...] = ()
    mention: int = -1


def is_certain(ground: Ground) -> bool:
    """Whether a ground is one place for certain."""
    return len(ground.candidates) < 2 and NOT_ON_MAP not in ground.ids


@dataclass
class GroundReader:
    """Reads grounds in surface order and remembers the places that were spoken of.

    Parameters
    ----------
    words, norms, chunks
        The text, as it stands and with its spelling mended.
    places
        The map's places by name and kind.
    chosen
        Landmark mention -> position of the landmark it stands for.
    """

    words: Sequence[Word]
    norms: Sequence[str]
    chunks: Sequence[Chunk]
    places: PlaceIndex
    chosen: dict[int, int]
    grounds: list[Ground] = field(default_factory=list)
    depth: int = 0
    _numbers: dict[frozenset[str | None], int] = field(default_factory=dict)

    def kind(self, at: int) -> str:
        """Return the kind of the item at a position, ``"end"`` past the last one."""
        return self.chunks[at].kind if 0 <= at < len(self.chunks) else "end"

    def value(self, at: int) -> object:
        """Return the value of the item at a position."""
        return self.chunks[at].value if 0 <= at < len(self.chunks) else None

    def past(self, at: int, *kinds: str) -> int:
        """Return the first position from `at` on of none of the kinds, not too far ahead."""
        end = at + _FARTHEST
        while at < end and self.kind(at) in kinds:
            at += 1
        return at

    def read(self, at: int) -> tuple[Ground, int] | None:
        """Return the ground that begins at an item, and the item after it; None if none does."""
        self.depth += 1
        try:
            return self._read(at) if self.depth < _DEEPEST else None
        finally:
            self.depth -= 1

    def _read(self, at: int) -> tuple[Ground, int] | None:
        start = at
        definite = pointing = False
        while at < start + _FARTHEST and self.kind(at) in _BEFORE_NAMES:
            pointing = pointing or self.kind(at) == "same"
            definite = definite or self.chunks[at].value == "the" or pointing
            at += 1
        kind = self.kind(at)
        if kind == "word" and self.value(at) in _ONE and self.kind(at + 1) == "of":
            onward = self.past(at + 2, "plural", "same", "det", "skip")
            if self.kind(onward) == "place":  # "one of those green areas"
                return self._place(start, onward, True, False)
        direction = self.selects(at)
        if direction:
            got = self.read(at + 1)
            return None if got is None else (self._farthest(got[0], direction), got[1])
        if kind == "which" and self.kind(at + 1) in ("place", "figure"):
            pointing, at = True, at + 1
            kind = self.kind(at)
        if kind == "where" and self.kind(at + 1) == "figure":  # "east of where we are"
            mention = self.chunks[at + 1].value
            span = self.chunks[at].first, self.chunks[at + 1].last
            if mention.candidates == (SPEAKER,):
                return Ground("figure", *span, (SPEAKER,)), self.past(at + 2, "be", "skip")
        if kind == "landmark":
            return self._landmark(at)
        if kind in ("pronoun", "plural") and self.chunks[at].value not in ("its", "both"):
            return self._back(at), at + 1
        if kind == "robot" and self.kind(at + 1) == "landmark":
            return self._landmark(at + 1)
        if kind == "robot":
            return Ground("robot", self.chunks[start].first, self.chunks[at].last), at + 1
        if kind == "map":
            return Ground("map", self.chunks[at].first, self.chunks[at].last, (WHOLE_MAP,)), at + 1
        if kind == "figure":
            chunk = self.chunks[at]
            mention = chunk.value
            return Ground("figure", chunk.first, chunk.last, mention.candidates), at + 1
        if kind == "place":
            return self._place(start, at, definite, pointing)
        if pointing and kind in ("end", "comma", "stop", "and"):
            back = self.last_ground()
            span = self.chunks[start].first, self.chunks[at - 1].last
            return (self._again(back, *span), at) if back is not None else None
        if kind == "word" and self.value(at) in lexicon().words_of("adverbs"):
            return None  # "is inside already"
        if kind == "word":
            return self._unknown(at)
        if kind == "part":
            return self._inside(at + 1)
        return None

    def landmark(self, at: int) -> Ground:
        """Return the landmark that the item at a position names, and remember it."""
        chunk = self.chunks[at]
        mention: LandmarkMention = chunk.value
        position = self.chosen.get(chunk.first, mention.candidates[0])
        sure = mention.score / len(mention.candidates)
        ground = Ground(
            "landmark",
            chunk.first,
            chunk.last,
            (self.places.id(position),),
            tuple(self.places.id(c) for c in (*mention.candidates, *mention.rivals)[:3]),
            round(min(1.0, 0.5 + 0.5 * sure), 3),
            (),
            self._candidates(mention, position),
        )
        ground = replace(ground, mention=self._number(ground))
        self.grounds.append(ground)
        return ground

    def _candidates(self, mention: LandmarkMention, chosen: int) -> tuple[Candidate, ...]:
        """Return what a name may mean, the landmark that was settled on first."""
        shares = dict(mention.shares) or {chosen: 1.0}
        stops = {i for i in shares if self._is_stop(i)}
        if stops and len(stops) < len(shares):  # stops have the name of what they are at
            known = sum(shares.values())
            shares = {i: p * (_STOP if i in stops else 1.0) for i, p in shares.items()}
            shares = {i: p * known / sum(shares.values()) for i, p in shares.items()}
        known = sum(shares.values())
        if chosen != mention.candidates[0]:
            shares[chosen] = _SETTLED * shares.get(chosen, known)
        shares[chosen] = max(shares.values())
        total = sum(shares.values())
        order = sorted(shares, key=lambda i: (-shares[i], i != chosen))[:_MOST_CANDIDATES]
        return candidates_of([(self.places.id(i), known * shares[i] / total) for i in order])

    def _is_stop(self, position: int) -> bool:
        properties = self.places.city.landmarks[position].properties
        return properties.get("highway") == "bus_stop" or "public_transport" in properties

    def _number(self, ground: Ground) -> int:
        """Return the number of a place: that of an earlier mention of the same candidates."""
        ids = frozenset(c.ground for c in ground.candidates)
        return self._numbers.setdefault(ids, ground.first)

    def _landmark(self, at: int) -> tuple[Ground, int]:
        ground = self.landmark(at)
        after = at + 1
        while (
            after < at + _FARTHEST
            and self.kind(after) in ("place", "junction", "none")
            and self.kind(after + 1) not in ("of", "figure")
        ):
            after += 1
        led = self.kind(at - 1) == "det" and self.value(at - 1) == "the"
        return self._narrowed(ground, after, restricts=led and len(ground.candidates) > 2)

    def _back(self, at: int) -> Ground:
        """Return the place that "it" or "there" points back to."""
        chunk = self.chunks[at]
        last = self.last_ground()
        if last is None:
            return Ground("unknown", chunk.first, chunk.last)
        return self._again(last, chunk.first, chunk.last)

    def _again(self, ground: Ground, first: int, last: int, confidence: float = 0.8) -> Ground:
        """Return a place that was spoken of before as it is called here."""
        return replace(
            ground, kind="landmark", first=first, last=last, confidence=confidence, every=()
        )

    def last_ground(self) -> Ground | None:
        """Return the place spoken of last."""
        return self.grounds[-1] if self.grounds else None

    def _place(self, start: int, at: int, definite: bool, pointing: bool) -> tuple[Ground, int]:
        """Return the ground that a kind of place stands for."""
        chunk = self.chunks[at]
        after = at + 1
        while after < at + _FARTHEST and self.kind(after) == "place":
            chunk, after = self.chunks[after], after + 1
        if self.kind(after) == "landmark" and not pointing:
            return self._landmark(after)
        if self.kind(after) == "word" and self.words[chunk.last].text[:1].isupper():
            return self._unknown(at)
        inner = self._inside(after)
        if inner is not None:
            return inner
        fit = self.places.of_phrase(str(chunk.value))
        first, last = self.chunks[start if pointing else at].first, chunk.last
        if pointing or (definite and (fit.name not in _VAGUE or self._sided(start))):
            for ground in reversed(self.grounds[-_REMEMBERED:]):
                if ground.ids[0] in fit.ids:
                    return self._again(ground, first, last), after
        if pointing and self.grounds:
            return self._again(self.grounds[-1], first, last, 0.5), after
        if pointing:
            return Ground("unknown", first, last, (), fit.ids[:3]), after
        every = fit.ids if self._is_any(start, at, after) else ()
        return self._of_kind(fit, Ground("landmark", first, last, every=every), after, definite)

    def _of_kind(
        self, fit: KindFit, ground: Ground, after: int, definite: bool
    ) -> tuple[Ground, int]:
        """Return the landmarks of a kind, each with its share, and the item after it."""
        if not fit.ids:
            return self._lacking(ground, after)
        clear = len(fit.ids) == 1 or (len(fit.best) == 1 and fit.name not in _ANYTHING)
        relative = self.kind(after) == "which" or self.value(after) == "that's"
        is_open = fit.name in _OPEN_KINDS or is_open_area(fit.ids[:3], self.places.city)
        modified = self._modifier(after) is not None
        vague = not clear and len(fit.ids) > 1 and fit.name in _ANYTHING
        if (modified and not clear and (is_open or not (definite or relative))) or (
            vague and not modified
        ):
            # "in the lot next to X": what is said of the lot is nearly as true of what is in it.
            shares = of_a_kind(fit.weights, _none_share(clear))
            shares = shares if len(shares) <= _MOST_OF_KIND else ()
            nearest = (fit.best or fit.ids)[:3]
            vague_ground = replace(ground, kind="unknown", nearest=nearest)
            return replace(vague_ground, candidates=candidates_of(shares)), after
        weights = dict(fit.weights)
        first = (*fit.best, *fit.ids)[0] if clear else ""
        if clear:
            weights[first] = max(1.0, *weights.values())
        none = _NONE_OF_WIDER if fit.is_wider else _none_share(clear)
        shares = tuple(sorted(of_a_kind(weights, none), key=lambda s: s[0] != first))
        if not modified and len(shares) > _MOST_OF_KIND:
            shares = ()
        ground = replace(
            ground,
            ids=(shares[0][0],) if shares else (NOT_ON_MAP,),
            confidence=0.8,
            candidates=candidates_of(shares),
            mention=ground.first,
        )
        tied = len(shares) > 1 and shares[1][1] >= shares[0][1]
        ground, after = self._narrowed(ground, after, restricts=tied)
        if shares:
            self.grounds.append(ground)
        return ground, after

    def _lacking(self, ground: Ground, after: int) -> tuple[Ground, int]:
        """Return the ground for a kind that the map has none of; what holds it may be known."""
        nowhere = replace(
            ground,
            ids=(NOT_ON_MAP,),
            candidates=(Candidate(None, 1.0),),
            mention=ground.first,
        )
        modifier = self._modifier(after)
        if modifier is None or modifier[0] not in ("in", "inside", "within", "at", "on"):
            return nowhere, after
        _, inner, onward = modifier
        inner = self._again(inner, ground.first, self.chunks[onward - 1].last, 0.5)
        held = [(c.ground, c.probability * (1 - _KNOWN_TO_BOTH)) for c in self.slot(inner)]
        shares = candidates_of([(i, p) for i, p in held if i is not None])
        return replace(inner, candidates=shares, mention=ground.first), onward

    @staticmethod
    def slot(ground: Ground) -> tuple[Candidate, ...]:
        """Return what a ground may be: the one place that it certainly is, none of an unknown."""
        return ground.candidates or tuple(Candidate(one, 1.0) for one in ground.ids[:1])

    def selects(self, at: int) -> str:
        """Return the direction of "northern" or "southernmost" before a place, else ""."""
        if self.kind(at) not in ("dir", "word") or self.kind(at + 1) not in ("landmark", "place"):
            return ""
        low = self.norms[self.chunks[at].last - 1]
        if not low.endswith(_SELECTING) or self.chunks[at].last - self.chunks[at].first > 1:
            return ""
        if self.kind(at) == "dir":
            return str(self.chunks[at].value[-1])
        stem = low.removesuffix("most").removesuffix("ern")
        return stem if stem in RELATIONS and stem != low else ""

    def _farthest(self, ground: Ground, direction: str) -> Ground:
        """Return a ground with the farthest of its candidates in a direction the most probable."""
        weights = {c.ground: c.probability for c in self.slot(ground) if c.ground is not None}
        if ground.kind != "landmark" or len(weights) < 2:
            return ground
        found = most_towards(direction, weights, self.places.city)
        return self._weighted(ground, found, 1 - sum(weights.values()))

    def _weighted(self, ground: Ground, weights: dict[str, float], none: float) -> Ground:
        """Return a ground with other weights; `none` is the share of places not on the map."""
        if not any(weights.values()):
            return ground
        shares = of_a_kind(weights, max(0.0, none))[:_MOST_CANDIDATES]
        kept = sum(p for _, p in shares)
        shares = tuple((i, p * (1 - none) / kept) for i, p in shares)
        known = replace(ground, ids=(shares[0][0],), candidates=candidates_of(shares))
        if self.grounds and self.grounds[-1] == ground:
            self.grounds[-1] = known
        return known

    def _narrowed(self, ground: Ground, after: int, restricts: bool) -> tuple[Ground, int]:
        """Return a ground narrowed by "next to X" or ", the one in the north", and the item after.

        Parameters
        ----------
        ground
            The ground.
        after
            The item after it.
        restricts
            Whether a relation that follows at once says which place is meant.
        """
        one = after
        if self.kind(one) in ("comma", "stop"):
            one += 1
        one = self.past(one, "det", "skip")
        direction = self.kind(one) == "dir"
        named = self.value(one + direction) in _ONE or (
            self.kind(one + direction) == "word"
            and self.norms[self.chunks[one + direction].first] in _ONE
        )
        if named and self.kind(one - 1) == "det":
            if direction:
                return self._farthest(ground, str(self.chunks[one].value[-1])), one + 2
            onward = self.past(one + 1, "skip")
            inward = self.past(onward + 1, "det")
            bare = self.kind(onward) == "cue" and self.kind(inward) == "dir"
            if bare and self.kind(inward + 1) not in ("of", "from"):
                return self._farthest(ground, str(self.chunks[inward].value[-1])), inward + 1
            after, restricts = one + 1, True
        if not restricts:
            return ground, after
        modifier = self._modifier(after)
        if modifier is None:
            return ground, after
        relation, inner, onward = modifier
        weights: dict[str, float] = {}
        for place in self.slot(ground):
            if place.ground is None:
                continue
            weights[place.ground] = place.probability * sum(
                c.probability * fits_relation(relation, place.ground, c.ground, self.places.city)
                for c in self.slot(inner)
                if c.ground is not None and c.ground in self.places.city
            )
        none = sum(c.probability for c in self.slot(ground) if c.ground is None)
        total = sum(weights.values()) + _BY_CHANCE * none
        if total <= 0:
            return ground, onward
        return self._weighted(ground, weights, _BY_CHANCE * none / total), onward

    def _modifier(self, at: int) -> tuple[str, Ground, int] | None:
        """Return relation and place of "next to X", "that's inside X", and the item after it."""
        relative = self.kind(at) == "which" or self.value(at) == "that's"
        onward = self.past(at + 1, "be", "skip") if relative else self.past(at, "skip")
        kind = self.kind(onward)
        if kind == "cue":
            cue = self.chunks[onward].value
            if cue.negated or RELATIONS[cue.relation].grounds == "several":
                return None
            relation, inward = str(cue.relation), onward + 1
        elif kind == "dir":
            relation = str(self.chunks[onward].value[-1])
            inward = self.past(onward + 1, "part") + 1
            if self.kind(inward - 1) not in ("of", "from", "to"):
                return None
        else:
            return None
        n_grounds = len(self.grounds)
        got = self.read(inward)
        del self.grounds[n_grounds:]
        if got is None or got[0].kind != "landmark" or got[0].ids[:1] == (NOT_ON_MAP,):
            return None
        return relation, got[0], got[1]

    def _is_any(self, start: int, at: int, after: int) -> bool:
        """Whether a kind of place is spoken of at large: "a bank", not "a bank on Elm Street"."""
        led = {self.value(i) for i in range(start, at) if self.kind(i) == "det"}
        onward = after + 1 if self.kind(after) == "comma" else after
        named = onward > after and self.kind(onward) in ("landmark", "place", "which")
        closed = self.kind(after) in ("end", "stop", "comma", "and", "or", "but")
        return led <= _AT_LARGE and closed and not named

    def _sided(self, at: int) -> bool:
        """Whether "side of" (or another part) stands before: "the left side of the street"."""
        return self.kind(at - 1) == "of" and self.kind(at - 2) in ("part", "dir")

    def _inside(self, at: int) -> tuple[Ground, int] | None:
        """Return the named ground in "... of the Dresden", "... that houses Rumor"."""
        relative = self.kind(at) == "which" or self.value(at) == "that's"
        if relative and self.kind(at + 1) == "houses":
            at += 1
        if self.kind(at) not in _INTO:
            return None
        onward = self.past(at + 1, "det", "skip", "same", "none")
        if self.kind(onward) == "landmark":
            return self._landmark(onward)
        if self.kind(onward) in ("place", "pronoun", "word"):
            ground = self.read(at + 1)
            if ground is not None and ground[0].kind == "landmark":
                return ground
        return None

    def _unknown(self, at: int) -> tuple[Ground, int]:
        """Return a noun phrase that is no known place, or the known place inside it."""
        first = at
        while self.kind(at) in ("word", "place", "none", "part") and at - first < _LONGEST_NAME:
            at += 1
        if self.kind(at) == "landmark":
            return self._landmark(at)
        inner = self._inside(at)
        if inner is not None:
            return inner
        span = self.chunks[first].first, self.chunks[at - 1].last
        text = " ".join(w.low for w in self.words[span[0] : span[1]])
        near = nearest_landmarks(text, self.places.index)
        return Ground("unknown", *span, (), near), at

    def _norms(self, chunk: Chunk) -> tuple[str, ...]:
        return tuple(w.low for w in self.words[chunk.first : chunk.last])


def _none_share(clear: bool) -> float:
    """Return the share of places not on the map: less where one of a kind is plainly meant."""
    return NONE_OF_KIND / 2 if clear else NONE_OF_KIND
