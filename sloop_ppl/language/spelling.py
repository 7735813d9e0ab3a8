"""Mend spelling: words of the closed classes with a slip, and words run together."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import lru_cache

from rapidfuzz import process
from rapidfuzz.distance import OSA

from sloop_ppl.language.lexicon import Lexicon, lexicon
from sloop_ppl.language.ordinary import is_ordinary
from sloop_ppl.language.words import Word

__all__ = ["mend", "split_run_ons"]

_LONG = 9


def mend(low: str, extra: frozenset[str] = frozenset()) -> str:
    """Return the word of the closed classes (or of `extra`) that `low` is a slip of, else `low`.

    One letter may be wrong in words of five letters and more, two in words of nine and more;
    the word stays as it is when several words are equally near, or when it is an ordinary word.

    Examples
    --------
    >>> mend("betwen"), mend("behnid"), mend("moved")
    ('between', 'behind', 'moved')
    """
    return _mend(low, extra, lexicon())


@lru_cache(maxsize=20000)
def _mend(low: str, extra: frozenset[str], known: Lexicon) -> str:
    if len(low) < 4 or not low.isalpha() or low in known.closed or low in extra:
        return low
    if low in known.plain or is_ordinary(low):
        return low
    allowed = 2 if len(low) >= _LONG else 1
    near = process.extract(
        low, _long_words(extra, known), scorer=OSA.distance, score_cutoff=allowed, limit=3
    )
    if not near or (len(near) > 1 and near[1][1] == near[0][1]):
        return low
    return str(near[0][0])


@lru_cache(maxsize=64)
def _long_words(extra: frozenset[str], known: Lexicon) -> tuple[str, ...]:
    return tuple(sorted(w for w in known.closed | extra if len(w) > 4 and w.isalpha()))


def split_run_ons(words: Sequence[Word], vocabulary: Collection[str]) -> list[Word]:
    """Return `words` with those cut in two or more that are known words written together.

    Parameters
    ----------
    words
        The text.
    vocabulary
        The words of the map and of the targets.
    """
    known = lexicon()
    mended: list[Word] = []
    for word in words:
        if (
            word.kind != "word"
            or len(word.low) < 6
            or word.low in known.closed
            or word.low in known.plain
            or is_ordinary(word.low)
            or word.low in vocabulary
        ):
            mended.append(word)
            continue
        cuts = _cuts(word.low, vocabulary)
        if not cuts or len(word.text) != len(word.low):
            mended.append(word)
            continue
        for first, last in zip((0, *cuts), (*cuts, len(word.low)), strict=True):
            mended.append(
                replace(
                    word,
                    text=word.text[first:last],
                    low=word.low[first:last],
                    start=word.start + first,
                    end=word.start + last,
                    spaced=word.spaced and first == 0,
                    breaks=word.breaks and first == 0,
                )
            )
    return mended


def _cuts(low: str, vocabulary: Collection[str]) -> tuple[int, ...] | None:
    """Return where `low` falls into the fewest known words, one of them of four letters or more."""
    known = lexicon().closed
    best: dict[int, tuple[int, tuple[int, ...]]] = {0: (0, ())}  # end -> words, their beginnings
    for end in range(2, len(low) + 1):
        ways = [
            (best[start][0] + 1, (*best[start][1], start))
            for start in range(end - 1)
            if start in best and _is_word(low[start:end], known, vocabulary)
        ]
        if ways:
            best[end] = min(ways)
    words, begins = best.get(len(low), (0, ()))
    if words < 2:
        return None
    longest = max(b - a for a, b in zip(begins, (*begins[1:], len(low)), strict=True))
    return begins[1:] if longest >= 4 else None


def _is_word(piece: str, known: Collection[str], vocabulary: Collection[str]) -> bool:
    if len(piece) == 2:
        return piece in _SHORT
    return piece in known or piece in vocabulary


_SHORT = frozenset(("is", "at", "in", "on", "by", "of", "to", "it"))
