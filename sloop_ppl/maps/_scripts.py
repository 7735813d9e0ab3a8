"""Tell the Latin script from others."""

from __future__ import annotations

import unicodedata
from functools import lru_cache

__all__ = ["has_latin", "is_latin"]


def has_latin(text: str) -> bool:
    """Tell whether a text has letters of the Latin script and of no other."""
    if text.isascii():
        return any(map(str.isalpha, text))
    scripts = {is_latin(c) for c in text if c.isalpha()}
    return scripts == {True}


@lru_cache(maxsize=1 << 12)
def is_latin(letter: str) -> bool:
    """Tell whether a letter is of the Latin script."""
    # Fullwidth letters and the ordinal signs are Latin, too.
    letter_name = unicodedata.name(letter, "")
    return "LATIN" in letter_name or letter in "\u00aa\u00ba\u00b5"
