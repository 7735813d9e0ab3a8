"""Name the landmarks that come nearest to words that name none."""

from __future__ import annotations

from functools import lru_cache

from rapidfuzz import fuzz, process

from sloop_ppl.language.name_index import NameIndex, canonical
from sloop_ppl.language.words import split_words

__all__ = ["nearest_landmarks"]


@lru_cache(maxsize=4096)
def nearest_landmarks(text: str, index: NameIndex, count: int = 3) -> tuple[str, ...]:
    """Return ids of the `count` landmarks whose names look most like `said`, best first.

    Examples
    --------
    >>> from sloop_ppl.language.name_index import name_index
    >>> from sloop_ppl.maps import load_map
    >>> nearest_landmarks("velvet cat", name_index(load_map("cleveland")), count=1)
    ('VelvetDog',)
    """
    words = " ".join(canonical(w.low) for w in split_words(text[:80]) if w.kind != "mark")
    if not words:
        return ()
    found = process.extract(
        words, index.spelt, scorer=fuzz.token_sort_ratio, score_cutoff=45, limit=4 * count
    )
    ids = dict.fromkeys(index.landmarks[index.names[n].landmark].id for _, _, n in found)
    return tuple(ids)[:count]
