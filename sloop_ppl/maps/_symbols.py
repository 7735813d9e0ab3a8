"""Turn names into symbols, and into the plain words by which they are compared."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Container
from functools import lru_cache

__all__ = ["camel_case", "folded", "unique"]

_WORD = re.compile(r"[^\W_]+")
# Combining marks of the block U+0300, the accents, but not those that make another letter in
# Cyrillic: й, ў, ї.
_ACCENTS = re.compile("(?<![ИиУу])\u0306|(?<![Іі])\u0308|[\u0300-\u0305\u0307\u0309-\u036f]")
# Letters that Unicode does not decompose into a base and an accent.
_UNFOLDED = str.maketrans(
    {"ß": "ss", "æ": "ae", "Æ": "Ae", "ø": "o", "Ø": "O", "œ": "oe", "Œ": "Oe", "đ": "d", "ł": "l",
     "Ł": "L", "þ": "th", "ð": "d", "ı": "i"}
)  # fmt: skip


def camel_case(name: str) -> str:
    """Return the CamelCase symbol of a name, without accents or punctuation; empty if none is left.

    Examples
    --------
    >>> camel_case("Root-McBride Building"), camel_case("Kolmen sepän aukio"), camel_case("Joe's")
    ('RootMcBrideBuilding', 'KolmenSepanAukio', 'Joes')
    >>> camel_case("Чайка кафе")
    'ЧайкаКафе'
    """
    # An apostrophe or point inside a word parts nothing: "Joe's", "U.S.".
    joined = re.sub(r"(?<=\w)['’.](?=\w)", "", _plain(name).replace("&", " and "))
    return "".join(word[0].upper() + word[1:] for word in _WORD.findall(joined))


@lru_cache(maxsize=1 << 16)
def folded(name: str) -> str:
    """Return a name in lower case, without accents and punctuation, its words parted by a space.

    Examples
    --------
    >>> folded("  The CAFÉ-Bar, No. 3 ")
    'the cafe bar no 3'
    """
    joined = re.sub(r"(?<=\w)['’](?=\w)", "", _plain(name).replace("&", " and "))
    return " ".join(_WORD.findall(joined)).casefold()


def unique(symbol: str, taken: Container[str]) -> str:
    """Return the symbol, numbered from 2 when it is taken.

    Examples
    --------
    >>> unique("Kiosk", {"Kiosk", "Kiosk2"})
    'Kiosk3'
    """
    number, found = 1, symbol
    while found in taken:
        number += 1
        found = f"{symbol}{number}" if not symbol[-1].isdigit() else f"{symbol}_{number}"
    return found


def _plain(name: str) -> str:
    """Strip the accents from Latin, Greek and Cyrillic letters; leave other scripts alone."""
    decomposed = unicodedata.normalize("NFKD", name.translate(_UNFOLDED))
    return unicodedata.normalize("NFC", _ACCENTS.sub("", decomposed))
