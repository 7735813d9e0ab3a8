"""Know ordinary English words: a text that holds one may mean just that, no place."""

from __future__ import annotations

import gzip
import re
from functools import lru_cache
from importlib.resources import files

__all__ = ["is_common", "is_ordinary"]


_CONTRACTED = re.compile(
    r"(?:do|does|did|is|are|was|were|could|should|would|have|has|had|ai|must|need)n'?t|can'?t|won'?t"
    r"|(?:i|you|he|she|it|we|they|there|that|what|who|where|here|let)(?:'m|m|'s|s|'re|re|'ve|ve|'ll|'d)"
)
"""Contractions, with the apostrophe or without ("dont")."""


def is_common(low: str) -> bool:
    """Whether a folded word is one of the 12,000 commonest of English, or a contraction.

    Examples
    --------
    >>> is_common("friend"), is_common("velvet"), is_common("logan"), is_common("dont")
    (True, False, False, True)
    """
    return low in _words()[0] or _CONTRACTED.fullmatch(low) is not None


def is_ordinary(low: str) -> bool:
    """Whether a folded word stands in a small dictionary: it is no slip of another.

    Examples
    --------
    >>> is_ordinary("velvet"), is_ordinary("velvett")
    (True, False)
    """
    common, rarer = _words()
    return low in common or low in rarer or _CONTRACTED.fullmatch(low) is not None


@lru_cache(maxsize=1)
def _words() -> tuple[frozenset[str], frozenset[str]]:
    packed = (files("sloop_ppl") / "data" / "ordinary_words.txt.gz").read_bytes()
    common, _, rarer = gzip.decompress(packed).decode("ascii").partition("\n\n")
    return frozenset(common.split()), frozenset(rarer.split())
