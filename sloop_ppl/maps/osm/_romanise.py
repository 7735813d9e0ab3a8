"""Spell names of other scripts in Latin letters, where their tags do not."""

from __future__ import annotations

import unicodedata
from functools import lru_cache

__all__ = ["has_latin", "romanised"]


def has_latin(text: str) -> bool:
    """Tell whether a text has letters of the Latin script and of no other."""
    scripts = {_is_latin(c) for c in text if c.isalpha()}
    return scripts == {True}


def romanised(name: str) -> str | None:
    """Return a name in Latin letters; None when it has none of another script.

    Notes
    -----
    anyascii (ISC licence, 2.6 MB installed, no dependencies) spells every script letter by letter
    from tables that it reads as they are needed. uroman heeds the letters around, at the price of
    larger tables, all read at the start; Unidecode is under the GPL. No such table knows the
    language: Chinese characters are read as Mandarin in Japanese names too, and vowels that Arabic
    and Hebrew do not write are missing. Names that people gave in Latin letters go before it.

    Examples
    --------
    >>> romanised("\u0421\u0438\u043d\u0438\u0439 \u0434\u043e\u043c"), romanised("Root")
    ('Siniy dom', None)
    """
    if all(_is_latin(c) for c in name if c.isalpha()):
        return None
    from anyascii import anyascii

    spelt = " ".join(anyascii(name).split())
    return spelt if any(c.isalpha() for c in spelt) else None


@lru_cache(maxsize=1 << 12)
def _is_latin(letter: str) -> bool:
    # Fullwidth letters and the ordinal signs are Latin, too.
    letter_name = unicodedata.name(letter, "")
    return "LATIN" in letter_name or letter in "\u00aa\u00ba\u00b5"
