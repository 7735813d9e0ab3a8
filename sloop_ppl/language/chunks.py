"""Turn words into the items that phrases are built of: names, cues, directions, small words."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from sloop_ppl.language.constructions import clock_direction, rewrite
from sloop_ppl.language.distances import read_distance, read_ordinal_distance
from sloop_ppl.language.figures import FigureMention
from sloop_ppl.language.items import Chunk, Cue
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
_REARS = frozenset(("rear", "back", "front"))
_HEADLESS = {"next": "next", "close": "close", "front": "front"}
_ANYWHERE = frozenset(("anywhere", "everywhere", "anyplace", "anything", "somewhere", "elsewhere"))
_OTHER_THAN = (["other", "than"], ["apart", "from"], ["except", "for"])
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


def read_chunks(
    words: Sequence[Word],
    norms: Sequence[str],
    landmarks: Sequence[LandmarkMention],
    figures: Sequence[FigureMention],
    places: Sequence[Chunk],
    streets: Collection[int] = (),
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
    streets
        Positions in the map of the landmarks that are streets.
    """
    named = {m.first: Chunk("landmark", m.first, m.last, m) for m in landmarks}
    short = lexicon().short
    norms = [n if i in named else short.get(n, n) for i, n in enumerate(norms)]
    fixed = dict(named)
    fixed |= {m.first: Chunk("figure", m.first, m.last, m) for m in figures}
    fixed |= {p.first: p for p in places}
    chunks: list[Chunk] = []
    i = 0
    while i < len(words):
        chunk = fixed.get(i)
        if chunk is None or chunk.kind != "landmark":
            chunk = _measure(words, norms, i, named, chunk) or chunk
        if chunk is None:
            chunk = (
                _fixed_phrase(words, norms, i, fixed)
                or _cue(words, norms, i, fixed)
                or _small(words, norms, i)
            )
        elif words[i].breaks and chunk.kind == "figure":
            chunks.append(Chunk("stop", i, i))
        if chunk.kind != "none":
            chunks.append(chunk)
        i = chunk.last
    return rewrite(_compounds(chunks), words, streets)


def _measure(
    words: Sequence[Word],
    norms: Sequence[str],
    i: int,
    named: Mapping[int, Chunk],
    known: Chunk | None,
) -> Chunk | None:
    """Return a said distance; of what is an object or a kind only "the second car from"."""
    found = read_ordinal_distance(norms, i)
    if found is None and known is None:
        found = read_distance(words, norms, i, named)
    if found is None or any(k in named for k in range(i, found[1])):
        return None
    return Chunk("distance", i, found[1], found[0])


def _fixed_phrase(
    words: Sequence[Word], norms: Sequence[str], i: int, fixed: Mapping[int, Chunk]
) -> Chunk | None:
    """Return "nine o'clock", "no longer", "anywhere but" and "cross street"."""
    hour = clock_direction(norms, i)
    if hour is not None:
        return Chunk("clock", i, hour[1], hour[0])
    following = norms[i + 1] if i + 1 < len(norms) else ""
    if norms[i] == "no" and (following == "longer" or _no_more(norms, i)):
        return Chunk("neg", i, i + 2, "not")
    if norms[i] == "nowhere" and following in ("to", "in", "at", "on", "inside"):
        return Chunk("neg", i, i + 1, "not")  # "nowhere to be seen near the bank"
    if norms[i] in _ANYWHERE:
        end = i + 2 if following in ("but", "except", "besides") else i + 3
        excepts = end == i + 2 or norms[i + 1 : i + 3] in _OTHER_THAN
        if excepts:
            onward = end
            while onward < len(norms) and norms[onward] in ("the", "a", "my"):
                onward += 1
            if onward in fixed:
                return Chunk("cue", i, end, Cue("at", True))
            return Chunk("neg", i, end, "not")
    if norms[i] in ("x", "cross"):
        at = i + 2 if following == "-" and not words[i + 1].spaced else i + 1
        if norms[at : at + 1] in (["street"], ["streets"], ["st"], ["sts"]):
            return Chunk("junction", i, at + 1, "crossing")
    return None


def _no_more(norms: Sequence[str], i: int) -> bool:
    """Whether "no more" means "not any more" here: "the bike is no more at the bank"."""
    onward = norms[i + 2] if i + 2 < len(norms) else ""
    return norms[i : i + 2] == ["no", "more"] and onward in lexicon().longest_cues


def _cue(
    words: Sequence[Word], norms: Sequence[str], i: int, fixed: dict[int, Chunk]
) -> Chunk | None:
    """Return the longest cue at a word, intensifiers inside it allowed."""
    known = lexicon()
    longest = known.longest_cues
    reach = longest.get(known.alike.get(norms[i], norms[i]), 0)
    if not reach:
        return _headless(norms, i, fixed)
    best = _longest_cue(words, norms, i, fixed, reach, ())
    loose = _longest_cue(words, norms, i, fixed, reach, _INSERTED)
    if best is None or (loose is not None and loose.last > best.last):
        best = loose
    if best is None:
        return _headless(norms, i, fixed)
    if best.last - best.first > 1:
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


def _headless(norms: Sequence[str], i: int, fixed: Mapping[int, Chunk]) -> Chunk | None:
    """Return a cue whose small word was left out before a name: "next Ivy", "front the bank"."""
    relation = _HEADLESS.get(norms[i])
    onward = i + 2 if norms[i + 1 : i + 2] == ["the"] else i + 1
    if relation is None or onward not in fixed or fixed[onward].kind != "landmark":
        return None
    return Chunk("cue", i, i + 1, Cue(relation))


def _longest_cue(
    words: Sequence[Word],
    norms: Sequence[str],
    i: int,
    fixed: dict[int, Chunk],
    reach: int,
    inserted: tuple[str, ...],
) -> Chunk | None:
    """Return the longest cue at a word, hyphens and some words inside it passed over."""
    known = lexicon()
    cues, alike = known.cue_words, known.alike
    best: Chunk | None = None
    matched: list[str] = []
    at = i
    while at < len(norms) and len(matched) < reach and at - i < reach + 2:
        if at in fixed and not (fixed[at].kind == "place" and at > i):
            break
        hyphen = matched and norms[at] == "-" and not words[at].spaced
        if not (hyphen or (matched and norms[at] in inserted)):
            matched.append(alike.get(norms[at], norms[at]))
            cue = cues.get(tuple(matched))
            if cue is not None:
                best = Chunk("cue", i, at + 1, Cue(*cue))
        at += 1
    return best


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
    if classes and after == "of" and before in ("the", "a", "its"):
        for name in ("parts", "junctions"):  # "the head of", "the crossing of": nothing one does
            if name in classes:
                return Chunk(_KIND_OF_CLASS[name], i, i + 1, norm)
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
    if norm in _REARS and before in (",", "(", "-", "–", ";") and not after.isalpha():
        return True  # "Hoyt Block, rear"
    onward = after in lexicon().longest_cues and after not in ("on", "at")
    return before in _LEADS and not onward


def _mark(words: Sequence[Word], i: int) -> str:
    """Return what a mark does: end a sentence, part phrases, join, or nothing."""
    mark = words[i]
    if mark.low in "&+":
        return "and"
    if mark.low == "." and i > 0 and i + 1 < len(words) and not mark.spaced:
        after = words[i + 1]
        if words[i - 1].low in lexicon().short:
            return "none"
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
