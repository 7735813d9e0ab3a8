"""Mend spelling: words of the closed classes with a slip, and words run together."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import lru_cache

from rapidfuzz import process
from rapidfuzz.distance import OSA

from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.words import Word

__all__ = ["mend", "split_run_ons"]

_LONG = 9


@lru_cache(maxsize=20000)
def mend(low: str, extra: frozenset[str] = frozenset()) -> str:
    """Return the word of the closed classes (or of `extra`) that `low` is a slip of, else `low`.

    One letter may be wrong in words of five letters and more, two in words of nine and more;
    the word stays as it is when several words are equally near.

    Examples
    --------
    >>> mend("betwen"), mend("behnid"), mend("light")
    ('between', 'behind', 'light')
    """
    known = lexicon()
    if len(low) < 4 or not low.isalpha() or low in known.closed or low in extra:
        return low
    if low in known.plain:
        return low
    allowed = 2 if len(low) >= _LONG else 1
    near = process.extract(
        low, _long_words(extra), scorer=OSA.distance, score_cutoff=allowed, limit=3
    )
    if not near or (len(near) > 1 and near[1][1] == near[0][1]):
        return low
    return str(near[0][0])


@lru_cache(maxsize=64)
def _long_words(extra: frozenset[str]) -> tuple[str, ...]:
    return tuple(sorted(w for w in lexicon().closed | extra if len(w) > 4 and w.isalpha()))


def split_run_ons(words: Sequence[Word], vocabulary: Collection[str]) -> list[Word]:
    """Return `words` with those cut in two or more that are known words written together.

    Parameters
    ----------
    words : the text.
    vocabulary : the words of the map and of the targets.
    """
    known = lexicon()
    mended: list[Word] = []
    for word in words:
        if (
            word.kind != "word"
            or len(word.low) < 6
            or word.low in known.closed
            or word.low in known.plain
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
    n = len(low)
    best: list[tuple[int, int] | None] = [(0, 0)] + [None] * n
    for end in range(2, n + 1):
        for start in range(end - 1):
            before = best[start]
            piece = low[start:end]
            if before is None or not (piece in vocabulary or piece in known):
                continue
            if len(piece) < 2 or (len(piece) == 2 and piece not in _SHORT):
                continue
            if best[end] is None or before[0] + 1 < best[end][0]:  # type: ignore[index]
                best[end] = before[0] + 1, start
    if best[n] is None or best[n][0] < 2:  # type: ignore[index]
        return None
    cuts, at = [], n
    while at > 0:
        at = best[at][1]  # type: ignore[index]
        cuts.append(at)
    pieces = sorted(zip((*cuts[::-1],), (*cuts[::-1][1:], n), strict=True))
    if max(b - a for a, b in pieces) < 4:
        return None
    return tuple(sorted(cuts))[1:]


_SHORT = frozenset(("is", "at", "in", "on", "by", "of", "to", "it"))
