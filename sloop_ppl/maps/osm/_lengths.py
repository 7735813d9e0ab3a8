"""Read lengths and counts of storeys as people write them."""

from __future__ import annotations

import re
import unicodedata

__all__ = ["length_m", "levels"]

_UNIT_M = {
    "m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0, "mtr": 1.0, "km": 1000.0,
    "cm": 0.01, "mm": 0.001, "ft": 0.3048, "foot": 0.3048, "feet": 0.3048, "'": 0.3048,
    "yd": 0.9144, "yds": 0.9144, "yard": 0.9144, "yards": 0.9144, "in": 0.0254, "inch": 0.0254,
    "inches": 0.0254, '"': 0.0254,
}  # fmt: skip
_NUMBER = r"(?:\d+(?:[.,]\d*)?|[.,]\d+)"
_LENGTH = re.compile(rf"({_NUMBER})\s*([a-z]+|'|\")?\.?")
_FEET = re.compile(rf"({_NUMBER})\s*(?:'|ft|feet)\s*({_NUMBER})\s*(?:\"|''|in|inch|inches)?")
_ABOUT = re.compile(r"(?:~|≈|±|(?:ca|c|circa|about|approx|approximately|etwa|env|environ)\b\.?)\s*")
_RANGE = re.compile(r"(?<=\S)\s*(?:-|–|—|\bto\b|\bbis\b)\s*(?=\S)")
# A comma and three digits may part thousands or decimals: nobody can tell.
_THOUSANDS = re.compile(r"\d,\d{3}(?!\d)")
# "G+3" of India and Africa: the ground floor and three above.
_GROUND_PLUS = re.compile(r"g(?:f|round)?\s*\+\s*(\d+)")
_QUOTES = str.maketrans(
    {"’": "'", "‘": "'", "′": "'", "`": "'", "´": "'", "″": '"', "”": '"', "“": '"',
     "¼": ".25", "½": ".5", "¾": ".75"}
)  # fmt: skip


def length_m(text: str | None) -> float | None:
    """Read a length such as ``"12"``, ``"3,5 m"``, ``"~40 ft"``, ``5'6"`` or ``"12;15"``.

    Returns
    -------
    float or None
        Metres, of several values or a range the greatest; None when it cannot be read.

    Examples
    --------
    >>> length_m("10 ft"), length_m("3,5 m"), length_m("12 - 15"), length_m("wide")
    (3.048, 3.5, 15.0, None)
    """
    parts = _parts(text)
    unit = next((f[2] for p in reversed(parts[-1:]) if (f := _LENGTH.fullmatch(p)) and f[2]), "m")
    values = [_one_length(part, unit) for part in parts]
    known = [value for value in values if value is not None]
    return max(known) if known and len(known) == len(values) else None


def levels(text: str | None) -> float | None:
    """Read a number of storeys such as ``"3"``, ``"3,5"``, ``"3-4"`` or ``"G+3"``; None if unread.

    Examples
    --------
    >>> levels("3;4"), levels("G+3"), levels("three")
    (4.0, 4.0, None)
    """
    found = []
    for part in _parts(text):
        if plus := _GROUND_PLUS.fullmatch(part):
            found.append(1.0 + float(plus[1]))
        elif re.fullmatch(_NUMBER, part):
            found.append(float(part.replace(",", ".")))
        else:
            return None
    return max(found, default=None)


def _parts(text: str | None) -> list[str]:
    """Return the values of a tag, in lower case without accents, digits and quotes plain."""
    plain = unicodedata.normalize("NFKD", (text or "").translate(_QUOTES)).casefold()
    plain = "".join(c for c in plain if not unicodedata.combining(c)).strip()
    if not plain or len(plain) > 60:
        return []
    ends = [end for value in plain.split(";") for end in _RANGE.split(value.strip())]
    return [_ABOUT.sub("", end, count=1) if _ABOUT.match(end) else end for end in ends]


def _one_length(part: str, unit: str) -> float | None:
    if feet := _FEET.fullmatch(part):
        whole, inches = (float(number.replace(",", ".")) for number in feet.groups())
        return round((whole + inches / 12) * 0.3048, 3)
    found = _LENGTH.fullmatch(part)
    if not found or (found[2] or unit) not in _UNIT_M or _THOUSANDS.fullmatch(found[1][-5:]):
        return None
    return round(float(found[1].replace(",", ".")) * _UNIT_M[found[2] or unit], 3)
