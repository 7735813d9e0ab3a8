"""Turn words into the items that phrases are built of: names, cues, directions, small words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sloop_ppl.language.figures import FigureMention
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.linking import LandmarkMention
from sloop_ppl.language.name_index import canonical
from sloop_ppl.language.words import Word

__all__ = ["Chunk", "Cue", "read_chunks"]

_STOPS = frozenset(".;!?。؟")
_COMMAS = frozenset(',:()[]—–-"“”|/')
_ADJECTIVAL = frozenset(("left", "right", "front", "back", "rear", "top", "bottom", "middle",
                         "center", "centre", "upper", "lower"))  # fmt: skip
_LEADS = frozenset(("the", "its", "their", "your", "my", "his", "her", "our", "immediate", "far",
                    "upper", "lower", "top", "bottom", "back", "front", "to", "a"))  # fmt: skip
_FOLLOWS = frozenset(("of", "hand", "side", "from", "edge", "end", "corner", "left", "right"))
_PARTICLES = frozenset(("up", "down", "over", "back", "close", "around", "out", "along"))
_INSERTED = ("immediate", "very", "direct", "far", "exact")
_LETTERS = {"n": "north", "s": "south", "e": "east", "w": "west"}
_CLASS_ORDER = (
    "neg", "too", "be", "and",
    "or", "but", "sub", "which", "where", "houses", "robot", "map", "see",
    "route", "route_ing", "plural_pronouns", "pronouns", "det", "possessive", "same", "parts",
    "junctions", "of", "to", "from", "only", "subjects",
)  # fmt: skip
_KIND_OF_CLASS = {
    "parts": "part", "junctions": "junction", "pronouns": "pronoun", "plural_pronouns": "plural",
    "subjects": "subject",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Cue:
    """A surface form that needs a ground: its canonical relation, and whether it negates."""

    relation: str
    negated: bool = False


@dataclass(frozen=True, slots=True)
class Chunk:
    """A stretch of words with one role.

    Parameters
    ----------
    kind
        ``landmark``, ``figure``, ``cue``, ``dir``, ``distance``, ``place``, ``stop``, ...
    first, last
        Half-open range of words.
    value
        What it stands for.
    """

    kind: str
    first: int
    last: int
    value: Any = None


def read_chunks(
    words: Sequence[Word],
    norms: Sequence[str],
    landmarks: Sequence[LandmarkMention],
    figures: Sequence[FigureMention],
    places: Sequence[Chunk],
) -> list[Chunk]:
    """Return the items of a text in order; linear in the words.

    Parameters
    ----------
    words
        The text.
    norms
        The same words, spelling mended.
    landmarks, figures, places
        What was recognised, not overlapping.
    """
    fixed = {m.first: Chunk("landmark", m.first, m.last, m) for m in landmarks}
    fixed |= {m.first: Chunk("figure", m.first, m.last, m) for m in figures}
    fixed |= {p.first: p for p in places}
    chunks: list[Chunk] = []
    i = 0
    while i < len(words):
        chunk = fixed.get(i)
        if chunk is None:
            chunk = (
                _distance(words, norms, i, fixed)
                or _cue(norms, i, fixed)
                or _small(words, norms, i)
            )
        elif words[i].breaks and chunk.kind == "figure":
            chunks.append(Chunk("stop", i, i))
        if chunk.kind != "none":
            chunks.append(chunk)
        i = chunk.last
    return _compounds(chunks)


def _cue(norms: Sequence[str], i: int, fixed: dict[int, Chunk]) -> Chunk | None:
    """Return the longest cue at a word, intensifiers inside it allowed."""
    known = lexicon()
    longest = known.longest_cues
    reach = longest.get(norms[i], 0)
    if not reach:
        return None
    best = _longest_cue(norms, i, fixed, reach, ())
    loose = _longest_cue(norms, i, fixed, reach, _INSERTED)
    if best is None or (loose is not None and loose.last > best.last):
        best = loose
    if best is None or best.last - best.first > 1:
        return best
    word = norms[i]
    following = norms[best.last] if best.last < len(norms) else ""
    if word in _PARTICLES and best.last not in fixed:
        onward = (
            following in longest or following in known.directions or following in ("to", "from")
        )
        if onward and following not in ("the",):
            return Chunk("skip", i, best.last)
    return best


def _longest_cue(
    norms: Sequence[str], i: int, fixed: dict[int, Chunk], reach: int, inserted: tuple[str, ...]
) -> Chunk | None:
    """Return the longest cue at a word, some words inside it passed over."""
    cues = lexicon().cues
    best: Chunk | None = None
    matched: list[str] = []
    at = i
    while at < len(norms) and len(matched) < reach and at - i < reach + 2:
        if at in fixed and not (fixed[at].kind == "place" and at > i):
            break
        if not (matched and norms[at] in inserted):
            matched.append(norms[at])
            cue = cues.get(tuple(matched))
            if cue is not None:
                best = Chunk("cue", i, at + 1, Cue(*cue))
        at += 1
    return best


def _distance(
    words: Sequence[Word], norms: Sequence[str], i: int, fixed: dict[int, Chunk]
) -> Chunk | None:
    """Return a said distance ("about 50 feet", "half a block", "a couple of steps")."""
    known = lexicon()
    value = _number(words[i], norms[i])
    if value is None:
        return None
    at = i + 1
    if at < len(norms) and norms[at] == "hundred":
        value, at = value * 100, at + 1
    while (
        at < len(norms) and norms[at] in ("a", "an", "of", "or", "more", "-", "so") and at - i < 4
    ):
        if norms[at] == "or" and at + 1 < len(norms):
            again = _number(words[at + 1], norms[at + 1])
            if again is not None:
                value, at = (value + again) / 2, at + 1
        at += 1
    if (
        at < len(norms)
        and norms[at] in ("few", "couple", "dozen", "hundred")
        and norms[i] in ("a", "an")
    ):
        value = known.numbers[norms[at]]
        at += 1
        if at < len(norms) and norms[at] == "of":
            at += 1
    if at < len(norms) and at not in fixed and norms[at] in known.units_m:
        return Chunk("distance", i, at + 1, value * known.units_m[norms[at]])
    return None


def _number(word: Word, norm: str) -> float | None:
    if word.kind == "number":
        try:
            return float(word.low.replace(",", "")) if len(word.low) < 12 else None
        except ValueError:
            return None
    return lexicon().numbers.get(norm)


def _small(words: Sequence[Word], norms: Sequence[str], i: int) -> Chunk:
    """Return the role of a single word."""
    known = lexicon()
    word, norm = words[i], norms[i]
    after = norms[i + 1] if i + 1 < len(norms) else ""
    before = norms[i - 1] if i else ""
    if word.kind == "mark":
        return Chunk(_mark(words, i), i, i + 1)
    if norm == "as" and after == "well":
        listed = norms[i + 2 : i + 3] == ["as"]
        return Chunk("and", i, i + 3) if listed else Chunk("too", i, i + 2)
    if norm in known.directions and _directs(norm, before, after):
        return Chunk("dir", i, i + 1, (known.directions[norm],))
    if norm in _LETTERS and after in ("of", "from"):
        return Chunk("dir", i, i + 1, (_LETTERS[norm],))
    classes = known.classes.get(norm)
    if classes:
        for name in _CLASS_ORDER:
            if name in classes:
                return Chunk(_KIND_OF_CLASS.get(name, name), i, i + 1, norm)
    if norm in known.intensifiers or norm in known.directions:
        return Chunk("skip", i, i + 1)
    return Chunk("word", i, i + 1, norm)


def _directs(norm: str, before: str, after: str) -> bool:
    """Whether a word such as "right" or "back" is a direction here."""
    if norm not in _ADJECTIVAL:
        return True
    if after in _FOLLOWS:
        return True
    onward = after in lexicon().longest_cues and after not in ("on", "at")
    return before in _LEADS and not onward


def _mark(words: Sequence[Word], i: int) -> str:
    """Return what a mark does: end a sentence, part phrases, join, or nothing."""
    mark = words[i]
    if mark.low in "&+":
        return "and"
    if mark.low == "." and i > 0 and i + 1 < len(words) and not mark.spaced:
        after = words[i + 1]
        if (
            canonical(words[i - 1].low) != words[i - 1].low
            and words[i - 1].low in lexicon().abbreviations
        ):
            return "stop" if after.text[:1].isupper() and after.spaced else "none"
        if len(words[i - 1].low) == 1 and words[i - 1].kind == "word":
            return "none"
    if mark.low in _STOPS:
        return "stop"
    if mark.low == "-":
        after_spaced = i + 1 < len(words) and words[i + 1].spaced
        return "comma" if mark.spaced and after_spaced else "none"
    return "comma" if mark.low in _COMMAS else "none"


def _compounds(chunks: list[Chunk]) -> list[Chunk]:
    """Join "south" and "east", and "upper" and "left", into one direction."""
    joined: list[Chunk] = []
    for chunk in chunks:
        if chunk.kind == "dir" and joined and joined[-1].kind == "dir":
            before = joined[-1]
            both = before.value[-1] + chunk.value[0]
            value = (
                (*before.value[:-1], both)
                if both in lexicon().compass
                else before.value + chunk.value
            )
            joined[-1] = Chunk("dir", before.first, chunk.last, value)
        else:
            joined.append(chunk)
    return joined
