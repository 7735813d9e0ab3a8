"""Which stretches of a text are asserted: not what is asked, denied, or held before.

Statuses are told by word, before phrases are attached: a phrase has the status of its cue.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

from sloop_ppl.language.chunks import Chunk
from sloop_ppl.language.words import Word

__all__ = ["Assertion", "assertions", "correction_at"]

Assertion: TypeAlias = Literal["asserted", "denied", "asked", "past", "other"]

_GREETINGS = frozenset(
    ("and", "but", "so", "hey", "hi", "hello", "sir", "madam", "please", "excuse", "me", "ok", "okay",
     "well", "um", "uh", "sorry", "oh", "yo", "dude", "guys", "um", "quick", "question", "hmm",
     "just", "now")
)  # fmt: skip
_ASKING = frozenset(
    ("is", "are", "was", "were", "do", "does", "did", "has", "have", "had", "could", "can", "would",
     "will", "should", "might", "isn't", "aren't", "wasn't", "weren't", "didn't", "doesn't",
     "hasn't", "haven't", "couldn't", "any", "anyone", "anybody", "who", "which", "what", "when",
     "how", "whose", "why", "where", "where's", "wheres", "what's", "who's")
)  # fmt: skip
_PLAIN_ASKING = frozenset(
    ("is", "are", "was", "were", "do", "does", "did", "has", "isn't", "aren't", "wasn't", "didn't")
)
_REQUESTS = frozenset(
    ("look", "check", "search", "meet", "come", "pick", "help", "join", "fetch", "get", "go", "bring",
     "send", "drop", "start", "fly", "head", "grab", "collect", "wait")
)  # fmt: skip
_SUGGESTS = frozenset(
    ("let's", "lets", "meet", "maybe", "might", "probably", "think", "perhaps", "guess", "believe",
     "should", "may")
)  # fmt: skip
_TAGS = (
    ("right",), ("ok",), ("okay",), ("yeah",), ("yes",), ("huh",), ("correct",), ("eh",), ("no",),
    ("got", "it"), ("see",),
)  # fmt: skip
_WONDERING = (
    ("wondering", "if"), ("wondering", "whether"), ("wonder", "if"), ("wonder", "whether"),
    ("sure", "if"), ("sure", "whether"), ("know", "if"), ("know", "whether"), ("ask", "if"),
    ("asked", "if"), ("asking", "if"), ("tell", "me", "if"), ("see", "if"), ("check", "if"),
    ("check", "whether"), ("find", "out", "if"), ("unclear", "if"), ("unclear", "whether"),
)  # fmt: skip
_SEEING = frozenset(
    ("see", "seen", "saw", "seeing", "find", "found", "finding", "spot", "spotted", "notice",
     "noticed", "locate", "located", "sighted", "sight")
)  # fmt: skip
_SEARCHING = frozenset(("look", "search", "check", "bother", "go", "waste", "try", "fly", "hunt"))
_SEARCHED = frozenset(("looked", "searched", "checked", "tried", "went", "been", "scoured", "combed"))
_VAIN = (
    ("nothing",), ("no", "luck"), ("not", "there"), ("no", "sign"), ("in", "vain"), ("no", "trace"),
    ("without", "luck"), ("without", "success"), ("found", "nothing"), ("no", "joy"), ("isn't", "there"),
    ("wasn't", "there"), ("nada",), ("zilch",),
)  # fmt: skip
_NEGATIONS = frozenset(
    ("not", "never", "don't", "doesn't", "didn't", "haven't", "hasn't", "hadn't", "couldn't", "can't",
     "cannot", "won't", "isn't", "wasn't", "dont", "doesnt", "didnt", "havent", "hasnt", "couldnt",
     "cant", "isnt", "wasnt", "ain't", "aint", "without", "no")
)  # fmt: skip
_NOBODY = (("nobody",), ("nobody's",), ("no", "one"), ("no-one",), ("noone",), ("none", "of", "us"), ("neither", "of", "us"))  # fmt: skip
_LONG_PAST = (
    ("used", "to"), ("formerly",), ("previously",), ("originally",), ("initially",), ("at", "first"),
    ("back", "then"), ("in", "the", "past"), ("once", "stood"), ("years", "ago"), ("months", "ago"),
    ("weeks", "ago"), ("days", "ago"), ("in", "those", "days"), ("no", "longer", "but"),
)  # fmt: skip
_LAST = frozenset(
    ("week", "month", "year", "night", "summer", "winter", "spring", "autumn", "monday", "tuesday",
     "wednesday", "thursday", "friday", "saturday", "sunday", "weekend", "time")
)  # fmt: skip
_RECENT_PAST = (
    ("yesterday",), ("this", "morning"), ("earlier",), ("was",), ("were",), ("had", "been"),
    ("until",), ("till",), ("before",), ("ago",), ("had", "it"), ("parked", "it"), ("wasn't",),
    ("at", "noon"), ("this", "afternoon"), ("last", "seen"), ("kept",), ("all", "day"), ("been",),
)  # fmt: skip
_NOW = (
    ("now",), ("today",), ("currently",), ("nowadays",), ("these", "days"), ("at", "the", "moment"),
    ("since", "then"), ("at", "present"), ("this", "time"), ("moved", "to"), ("moved", "it"),
    ("by", "now"), ("presently",), ("since", "moved"), ("tonight",), ("has", "moved"), ("has", "since"),
)  # fmt: skip
_CORRECTIONS = (
    ("no", "wait"), ("wait", "no"), ("wait", ",", "no"), ("no", ",", "wait"), ("scratch", "that"),
    ("strike", "that"), ("i", "mean"), ("i", "meant"), ("correction",), ("make", "that"),
    ("hang", "on"), ("hold", "on"), ("my", "mistake"), ("my", "bad"), ("or", "rather"),
    ("no", ",", "sorry"), ("sorry", ","), ("sorry", "no"), ("actually", "no"), ("no", "actually"),
    ("no", ",", "actually"), ("er",), ("erm",), ("oops",), ("not", "that", ","), ("i", "misspoke"),
    ("let", "me", "correct"), ("disregard", "that"), ("forget", "that"), ("ignore", "that"),
    ("nope",), ("wait", ","), ("wait",), ("sorry",), ("rather",), ("well", "actually"),
)  # fmt: skip
_CORRECTION_TAILS = frozenset((",", "no", "wait", "sorry", "i", "mean", "meant", "actually", "that", ".", "er", "uh", "um", "on", "it's", "make", "-", "—", "–", ":"))  # fmt: skip


def assertions(
    words: Sequence[Word], norms: Sequence[str], chunks: Sequence[Chunk]
) -> list[Assertion]:
    """Return of each word whether what it says is asserted, denied, asked, or held before.

    Parameters
    ----------
    words, norms
        The text, as it stands and with its spelling mended.
    chunks
        Its items; sentences end at those of kind ``stop``.
    """
    found: list[Assertion] = ["asserted"] * len(words)
    lows = [w.low for w in words]
    ends = sorted({c.first for c in chunks if c.kind == "stop"} | {len(words)})
    spans = [(a, b) for a, b in zip((0, *ends), ends, strict=False) if b > a]
    for first, last in spans:
        mark = words[last].text if last < len(words) else ""
        start, end = _asked(words, lows, first, last, mark)
        found[start:end] = ["asked"] * (end - start)
        for start, end in _searched(words, lows, first, last):
            found[start:end] = ["other" if f == "asserted" else f for f in found[start:end]]
        for start, end in _denied(words, lows, first, last):
            found[start:end] = ["denied" if f in ("asserted", "other") else f for f in found[start:end]]
    for start, end in _past(words, lows, spans):
        found[start:end] = ["past" if f in ("asserted", "denied") else f for f in found[start:end]]
    return found


def correction_at(lows: Sequence[str], at: int) -> int:
    """Return where a self-correction that begins at a word ends, `at` itself when none does."""
    longest = max((len(c) for c in _CORRECTIONS if _is(lows, at, c)), default=0)
    if not longest:
        return at
    end = at + longest
    while end < len(lows) and end - at < 8 and lows[end] in _CORRECTION_TAILS:
        end += 1
    return end


def _is(lows: Sequence[str], at: int, form: Sequence[str]) -> bool:
    return tuple(lows[at : at + len(form)]) == tuple(form)


def _any(lows: Sequence[str], first: int, last: int, forms: Sequence[Sequence[str]]) -> int:
    """Return where the first of the forms stands in a range, -1 when none does."""
    for at in range(first, last):
        if any(_is(lows, at, form) and at + len(form) <= last for form in forms):
            return at
    return -1


def _asked(
    words: Sequence[Word], lows: Sequence[str], first: int, last: int, mark: str
) -> tuple[int, int]:
    """Return which part of a sentence is a question."""
    start = first
    while start < last and (lows[start] in _GREETINGS or words[start].kind == "mark"):
        start += 1
    if start >= last:
        return first, first
    leads = lows[start] in _ASKING
    requests = any(w in _REQUESTS for w in lows[start + 1 : start + 5]) and (
        lows[start] in ("can", "could", "would", "will")
    )
    if mark == "?":
        if requests:
            return first, first
        if leads:
            return first, last
        tagged = any(tuple(lows[last - len(t) : last]) == t for t in _TAGS)
        tagged = tagged or (last - first > 3 and lows[last - 2] in _ASKING | {"don't", "can't"})
        if any(w in _SUGGESTS for w in lows[first:last]):
            return first, first
        verbal = any(w in _VERBAL or w.endswith("'s") for w in lows[first : max(first, last - 2)])
        return (first, first) if tagged and verbal else (first, last)
    wondering = _any(lows, first, last, _WONDERING)
    if wondering >= 0:
        return wondering, _clause_end(words, lows, wondering, last)
    if lows[start] in _PLAIN_ASKING or (
        lows[start] in ("anyone", "anybody", "any", "have") and any(w in _SEEING for w in lows[start : start + 4])
    ):
        end = _any(lows, start + 2, last, (("it's",), ("it", "is"), ("i", "think"), ("i'm",), ("im",)))
        return first, end if end >= 0 else last
    return first, first


_VERBAL = frozenset(("is", "are", "was", "were", "it's", "he's", "she's", "they're", "i'm"))


def _clause_end(words: Sequence[Word], lows: Sequence[str], at: int, last: int) -> int:
    """Return where the clause that holds a word ends: at "but", or at a comma and a new subject."""
    for k in range(at + 1, last):
        if lows[k] in ("but", "though", "however", "yet", "instead", "rather"):
            return k
        if words[k].kind == "mark" and words[k].low in ",:-–—" and words[k].spaced is False or lows[k] == ";":
            following = lows[k + 1 : k + 3]
            if following[:1] and following[0] in _SUBJECTS:
                return k
        if lows[k] == "and" and lows[k + 1 : k + 2] and lows[k + 1] in _SUBJECTS:
            return k
    return last


_SUBJECTS = frozenset(
    ("it", "it's", "she", "she's", "he", "he's", "they", "they're", "i", "i'm", "we", "we're", "try",
     "look", "check", "there's", "now", "only")
)  # fmt: skip


def _denied(
    words: Sequence[Word], lows: Sequence[str], first: int, last: int
) -> list[tuple[int, int]]:
    """Return which parts of a sentence say where something is not."""
    found: list[tuple[int, int]] = []
    for k in range(first, last):
        window = lows[k + 1 : min(k + 6, last)]
        if any(_is(lows, k, form) for form in _NOBODY) and any(w in _SEEING for w in window):
            found.append((k, _clause_end(words, lows, k, last)))
        elif lows[k] in _NEGATIONS:
            traces = lows[k + 1 : k + 4]
            sign = any(w in ("sign", "signs", "trace", "sight") for w in traces)
            exists = lows[k] == "no" and k > first and lows[k - 1] in _EXISTING
            sees = any(w in _SEEING for w in lows[k + 1 : min(k + 5, last)]) and lows[k] != "no"
            if lows[k] in ("can't", "cant", "cannot") and lows[k + 1 : k + 2] == ["miss"]:
                continue
            searches = lows[k + 1 : k + 2] and lows[k + 1] in _SEARCHING
            searches = searches or _is(lows, k, ("no", "need", "to")) or _is(lows, k, ("no", "use"))
            if sign or exists or sees or searches:
                found.append((k, _clause_end(words, lows, k, last)))
        elif lows[k] in _SEARCHED:
            vain = _any(lows, k + 1, last, _VAIN)
            if vain >= 0:
                found.append((k, vain))
    return found


def _searched(
    words: Sequence[Word], lows: Sequence[str], first: int, last: int
) -> list[tuple[int, int]]:
    """Return which parts say where someone has looked: "we've only looked on Grant Street"."""
    found = []
    for k in range(first + 1, last):
        lead = lows[max(first, k - 3) : k]
        ours = any(w in ("i", "we", "we've", "i've", "they", "they've", "police") for w in lead)
        if ours and lows[k] in ("looked", "searched", "checked", "scoured", "combed"):
            found.append((k, _clause_end(words, lows, k, last)))
    return found


_EXISTING = frozenset(
    ("there's", "there", "is", "are", "see", "saw", "with", "theres", "found", "got", "was", "were")
)


def _past(
    words: Sequence[Word], lows: Sequence[str], spans: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Return which parts tell where something was before.

    "Used to be" and "last week" do so by themselves; "was", "yesterday" and "earlier" only where
    the text goes on to say where it is now.
    """
    segments: list[tuple[int, int, int]] = []  # first, last, sentence
    for number, (first, last) in enumerate(spans):
        begin = first
        for k in range(first, last):
            cut = (words[k].kind == "mark" and words[k].low in ",:-–—") or lows[k] in ("but", "then")
            cut = cut or (lows[k] == "and" and lows[k + 1 : k + 2] and lows[k + 1] in _SUBJECTS)
            cut = cut or _is(lows, k, ("and", "now")) or (lows[k] in ("now", "today") and k > begin)
            if cut and k > begin:
                segments.append((begin, k, number))
                begin = k
        segments.append((begin, last, number))
    is_now = [_any(lows, a, b, _NOW) >= 0 for a, b, _ in segments]
    if not any(is_now) and not any(_long_past(lows, a, b) for a, b, _ in segments):
        return []
    found: list[tuple[int, int]] = []
    before, past = -1, False
    for i, (a, b, sentence) in enumerate(segments):
        if sentence != before:
            before, past = sentence, False
        later = any(is_now[i + 1 :]) or any(is_now[:i])
        recent = later and _any(lows, a, b, _RECENT_PAST) >= 0
        if is_now[i]:
            past = False
        elif _long_past(lows, a, b) or recent:
            past = True
        elif any(w in _VERBAL - {"was", "were"} for w in lows[a:b]):
            past = False
        if past:
            found.append((a, b))
    return found


def _long_past(lows: Sequence[str], first: int, last: int) -> bool:
    if _any(lows, first, last, _LONG_PAST) >= 0:
        return True
    return any(lows[k] == "last" and lows[k + 1] in _LAST for k in range(first, last - 1))
