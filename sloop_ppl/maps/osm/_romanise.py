"""Spell names of other scripts in Latin letters, where their tags do not."""

from __future__ import annotations

from sloop_ppl.maps._scripts import is_latin

__all__ = ["romanised"]


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
    if all(is_latin(c) for c in name if c.isalpha()):
        return None
    from anyascii import anyascii

    spelt = " ".join(anyascii(name).split())
    return spelt if any(c.isalpha() for c in spelt) else None
