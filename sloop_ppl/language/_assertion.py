"""Which stretches of a text are asserted: not what is asked, denied, or held before.

Statuses are found word by word, before phrases are attached: a phrase has the status of its cue.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Literal, TypeAlias

from sloop_ppl.language.items import Chunk
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.words import Word

__all__ = ["Assertion", "assertions", "correction_at"]

Assertion: TypeAlias = Literal["asserted", "denied", "asked", "past", "other"]


def _forms(name: str) -> tuple[tuple[str, ...], ...]:
    return lexicon().assertion[name]


def _words(name: str) -> frozenset[str]:
    return lexicon().words_of(name)


def assertions(words: Sequence[Word], chunks: Sequence[Chunk]) -> list[Assertion]:
    """Return of each word whether what it says is asserted, denied, asked, or held before.

    Parameters
    ----------
    words
        The text.
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
            found[start:end] = [
                "denied" if f in ("asserted", "other") else f for f in found[start:end]
            ]
    for start, end in _past(words, lows, spans):
        found[start:end] = ["past" if f in ("asserted", "denied") else f for f in found[start:end]]
    return found


def correction_at(lows: Sequence[str], at: int) -> int:
    """Return where a self-correction that begins at a word ends, `at` itself when none does."""
    begun = _by_first(_forms("corrections")).get(lows[at], ())
    longest = max((len(c) for c in begun if _is(lows, at, c)), default=0)
    if not longest:
        return at
    end = at + longest
    while end < len(lows) and end - at < 8 and lows[end] in _words("correction_tails"):
        end += 1
    return end


def _is(lows: Sequence[str], at: int, form: Sequence[str]) -> bool:
    return tuple(lows[at : at + len(form)]) == tuple(form)


def _any(lows: Sequence[str], first: int, last: int, forms: Sequence[tuple[str, ...]]) -> int:
    """Return where the first of the forms stands in a range, -1 when none does."""
    begins = _by_first(tuple(forms))
    for at in range(first, min(last, len(lows))):
        for form in begins.get(lows[at], ()):
            if _is(lows, at, form) and at + len(form) <= last:
                return at
    return -1


@lru_cache(maxsize=64)
def _by_first(forms: tuple[tuple[str, ...], ...]) -> dict[str, list[tuple[str, ...]]]:
    """Return forms by their first word: most words of a text begin none."""
    found: dict[str, list[tuple[str, ...]]] = {}
    for form in forms:
        found.setdefault(form[0], []).append(form)
    return found


def _asked(
    words: Sequence[Word], lows: Sequence[str], first: int, last: int, mark: str
) -> tuple[int, int]:
    """Return which part of a sentence is a question."""
    start = first
    while start < last and (lows[start] in _words("greetings") or words[start].kind == "mark"):
        start += 1
    if start >= last:
        return first, first
    leads = lows[start] in _words("asking")
    requests = any(w in _words("requests") for w in lows[start + 1 : start + 5]) and (
        lows[start] in ("can", "could", "would", "will")
    )
    if mark == "?":
        if requests:
            return first, first
        if leads:
            return first, last
        for k in range(last - 2, start, -1):  # "I left it at Ivy, can you get it?"
            if lows[k] == "," and lows[k + 1] in _words("asking") and last - k > 3:
                return k + 1, last
        tagged = any(tuple(lows[last - len(t) : last]) == t for t in _forms("tags"))
        tagged = tagged or (
            last - first > 3 and lows[last - 2] in _words("asking") | {"don't", "can't"}
        )
        if any(w in _words("suggests") for w in lows[first:last]):
            return first, first
        verbal = any(
            w in _words("verbal") or w.endswith("'s") for w in lows[first : max(first, last - 2)]
        )
        return (first, first) if tagged and verbal else (first, last)
    wondering = _any(lows, first, last, _forms("wondering"))
    if wondering >= 0:
        return wondering, _clause_end(words, lows, wondering, last)
    if lows[start] in _words("plain_asking") or (
        lows[start] in ("anyone", "anybody", "any", "have")
        and any(w in _words("seeing") for w in lows[start : start + 4])
    ):
        end = _any(
            lows, start + 2, last, (("it's",), ("it", "is"), ("i", "think"), ("i'm",), ("im",))
        )
        return first, end if end >= 0 else last
    return first, first


def _clause_end(words: Sequence[Word], lows: Sequence[str], at: int, last: int) -> int:
    """Return where the clause that holds a word ends: at "but", or at a comma and a new subject."""
    for k in range(at + 1, last):
        if lows[k] in ("but", "though", "however", "yet", "instead", "rather"):
            return k
        if (
            words[k].kind == "mark" and words[k].low in ",:-–—" and words[k].spaced is False
        ) or lows[k] == ";":
            following = lows[k + 1 : k + 3]
            if following[:1] and following[0] in _words("subjects"):
                return k
        if lows[k] == "and" and lows[k + 1 : k + 2] and lows[k + 1] in _words("subjects"):
            return k
    return last


def _denied(
    words: Sequence[Word], lows: Sequence[str], first: int, last: int
) -> list[tuple[int, int]]:
    """Return which parts of a sentence say where something is not."""
    found: list[tuple[int, int]] = []
    for k in range(first, last):
        window = lows[k + 1 : min(k + 6, last)]
        if _any(lows, k, min(k + 3, last), _forms("nobody")) == k and any(
            w in _words("seeing") for w in window
        ):
            found.append((k, _clause_end(words, lows, k, last)))
        elif lows[k] in _words("negations"):
            traces = lows[k + 1 : k + 4]
            sign = any(w in ("sign", "signs", "trace", "sight") for w in traces)
            bounds = lows[k + 1 : k + 2] and lows[k + 1] in _words("bounding")
            exists = lows[k] == "no" and k > first and lows[k - 1] in _words("existing")
            exists = exists and not bounds  # "no more than 20 m from"
            sees = (
                any(w in _words("seeing") for w in lows[k + 1 : min(k + 5, last)])
                and lows[k] != "no"
            )
            if lows[k] in ("can't", "cant", "cannot") and lows[k + 1 : k + 2] == ["miss"]:
                continue
            searches = lows[k + 1 : k + 2] and lows[k + 1] in _words("searching")
            searches = searches or _is(lows, k, ("no", "need", "to")) or _is(lows, k, ("no", "use"))
            if sign or exists or sees or searches:
                found.append((k, _clause_end(words, lows, k, last)))
        elif lows[k] in _words("searched"):
            vain = _any(lows, k + 1, last, _forms("vain"))
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
            cut = (words[k].kind == "mark" and words[k].low in ",:-–—") or lows[k] == "but"
            cut = cut or (
                lows[k] == "and" and k + 1 < len(lows) and lows[k + 1] in _words("subjects")
            )
            cut = cut or _is(lows, k, ("and", "now")) or (lows[k] in ("now", "today") and k > begin)
            if cut and k > begin:
                segments.append((begin, k, number))
                begin = k
        segments.append((begin, last, number))
    is_now = [_any(lows, a, b, _forms("now")) >= 0 for a, b, _ in segments]
    if not any(is_now) and not any(_long_past(lows, a, b) for a, b, _ in segments):
        return []
    found: list[tuple[int, int]] = []
    before, past = -1, False
    for i, (a, b, sentence) in enumerate(segments):
        if sentence != before:
            before, past = sentence, False
        later = any(is_now[i + 1 :]) or any(is_now[:i])
        recent = later and _any(lows, a, b, _forms("recent_past")) >= 0
        if is_now[i]:
            past = False
        elif _long_past(lows, a, b) or recent:
            past = True
        elif any(w in _words("verbal") - {"was", "were"} for w in lows[a:b]):
            past = False
        if past:
            found.append((a, b))
    return found


def _long_past(lows: Sequence[str], first: int, last: int) -> bool:
    if _any(lows, first, last, _forms("long_past")) >= 0:
        return True
    return any(lows[k] == "last" and lows[k + 1] in _words("last") for k in range(first, last - 1))
