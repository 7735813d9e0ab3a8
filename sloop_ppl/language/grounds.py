"""Read what a relation is about: a named place, a kind of place, "it", "you", "the map"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from sloop_ppl.language.chunks import Chunk
from sloop_ppl.language.figures import FigureMention
from sloop_ppl.language.linking import LandmarkMention
from sloop_ppl.language.nearest import nearest_landmarks
from sloop_ppl.language.place_index import PlaceIndex
from sloop_ppl.language.relations import WHOLE_MAP
from sloop_ppl.language.words import Word

__all__ = ["Ground", "GroundReader"]

"""Id of the ground of "the top left of the map"; used where the map holds it."""

_LONGEST_NAME = 8
_FARTHEST = 12
_DEEPEST = 6
_REMEMBERED = 30
_VAGUE = ("building", "street", "parking lot", "square", "water")
_AT_LARGE = {"a", "an", "any"}
_INTO = ("of", "to", "houses", "from")


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
        Id of the landmark, or ids of the figures; empty when unknown.
    candidates
        Ids of the landmarks that come nearest.
    confidence
        How sure the link is, in [0, 1].
    every
        Ids of all landmarks of the kind, where any of it is spoken of ("a bank").
    """

    kind: str
    first: int
    last: int
    ids: tuple[str, ...] = ()
    candidates: tuple[str, ...] = ()
    confidence: float = 1.0
    every: tuple[str, ...] = ()


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
        while at < start + _FARTHEST and self.kind(at) in (
            "det",
            "skip",
            "possessive",
            "only",
            "same",
            "none",
        ):
            pointing = pointing or self.kind(at) == "same"
            definite = definite or self.chunks[at].value == "the" or pointing
            at += 1
        kind = self.kind(at)
        if kind == "which" and self.kind(at + 1) in ("place", "figure"):
            pointing, at = True, at + 1
            kind = self.kind(at)
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
            mention: FigureMention = self.chunks[at].value
            chunk = self.chunks[at]
            return Ground("figure", chunk.first, chunk.last, mention.candidates), at + 1
        if kind == "place":
            return self._place(start, at, definite, pointing)
        if pointing and kind in ("end", "comma", "stop", "and"):
            back = self.last_ground()
            return (back, at) if back is not None else None
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
        )
        self.grounds.append(ground)
        return ground

    def _landmark(self, at: int) -> tuple[Ground, int]:
        ground = self.landmark(at)
        after = at + 1
        while (
            after < at + _FARTHEST
            and self.kind(after) in ("place", "junction", "none")
            and self.kind(after + 1) not in ("of", "figure")
        ):
            after += 1
        return ground, after

    def _back(self, at: int) -> Ground:
        """Return the place that "it" or "there" points back to."""
        chunk = self.chunks[at]
        last = self.last_ground()
        if last is None:
            return Ground("unknown", chunk.first, chunk.last)
        return Ground("landmark", chunk.first, chunk.last, last.ids, confidence=0.8)

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
        first, last = self.chunks[start if pointing else at].first, chunk.last
        matching = self.places.of_kind(str(chunk.value))
        if pointing or (definite and (chunk.value not in _VAGUE or self._sided(start))):
            for ground in reversed(self.grounds[-_REMEMBERED:]):
                if ground.ids[0] in matching:
                    return Ground("landmark", first, last, ground.ids, confidence=0.8), after
        best = self.places.best_of_kind(str(chunk.value), self._norms(chunk))
        every = matching if self._is_any(start, at, after) else ()
        if len(best) == 1 and not pointing:
            ground = Ground("landmark", first, last, best, confidence=0.8, every=every)
            self.grounds.append(ground)
            return ground, after
        if pointing and self.grounds:
            return Ground("landmark", first, last, self.grounds[-1].ids, confidence=0.5), after
        return Ground("unknown", first, last, (), (best or matching)[:3], every=every), after

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
