"""Find the landmarks that a name or a kind may mean."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from rapidfuzz import fuzz

from sloop_ppl.errors import InputError
from sloop_ppl.maps._symbols import folded
from sloop_ppl.maps.landmark import Landmark

__all__ = ["find", "kind_words"]

# Ratio of rapidfuzz, 0 to 100: one wrong letter in five still counts as the same name.
_FUZZY_FROM = 80.0
_ARTICLES = ("the ", "a ", "an ")
# From the tag that says what people call it to the one that says least.
_KIND_TAGS = (
    "amenity", "shop", "cuisine", "tourism", "leisure", "office", "craft", "historic",
    "healthcare", "religion", "building", "man_made", "railway", "public_transport", "natural",
    "water", "landuse", "place", "highway", "sport", "vending",
)  # fmt: skip
# What people say for a value of OpenStreetMap, beside the value itself.
_SAID_FOR = {
    "pub": ("tavern", "bar"),
    "bar": ("tavern", "pub"),
    "cafe": ("coffee shop", "coffee house"),
    "fast food": ("restaurant", "takeaway"),
    "place of worship": ("church",),
    "christian": ("church",),
    "muslim": ("mosque",),
    "jewish": ("synagogue",),
    "parking": ("parking lot", "car park", "parking garage"),
    "pharmacy": ("drugstore", "chemist"),
    "cinema": ("movie theater",),
    "fuel": ("gas station", "petrol station"),
    "supermarket": ("grocery store",),
    "convenience": ("convenience store", "corner shop"),
    "post box": ("mailbox",),
    "townhall": ("city hall", "town hall"),
    "apartments": ("apartment building",),
    "square": ("plaza",),
    "street": ("road",),
    "service": ("service road", "alley", "driveway"),
    "pedestrian": ("footpath", "path", "walkway"),
    "water": ("lake", "pond", "river"),
    "bus stop": ("bus station",),
    "clothes": ("clothing store", "clothes shop"),
    "books": ("bookstore", "bookshop"),
    "hairdresser": ("hair salon", "barber"),
    "alcohol": ("liquor store", "wine shop"),
    "doctors": ("doctor",),
}


def find(landmarks: Sequence[Landmark], name: str, limit: int = 5) -> tuple[Landmark, ...]:
    """Return the landmarks that a name may mean, the likeliest first.

    Parameters
    ----------
    name
        A name, an id, an alias or a kind ("the cafe", "bank"); case, accents, punctuation and a
        leading article do not matter.
    limit
        How many may come back, >= 1.

    Returns
    -------
    tuple of Landmark
        All that bear the id or the name; if none does, all with such an alias; else all of such a
        kind; else those with a name or alias that is spelt alike (80 of 100, digits alike) or
        holds the words asked for, best first. In the map's order where nothing else tells; empty
        when nothing fits.

    Raises
    ------
    InputError
        When `limit` is less than 1.
    """
    if limit < 1:
        raise InputError(f"limit is {limit}; expected 1 or more")
    asked = _without_article(folded(name))
    if not asked:
        return ()
    steps: tuple[Callable[[Landmark], Iterable[str]], ...] = (
        lambda m: (m.id, m.name or ""),
        lambda m: m.aliases,
        kind_words,
    )
    for words_of in steps:
        found = [
            m for m in landmarks if asked in {_without_article(folded(w)) for w in words_of(m)}
        ]
        if found:
            return tuple(found[:limit])
    return _spelt_alike(landmarks, asked, limit)


def kind_words(landmark: Landmark) -> tuple[str, ...]:
    """Return the words for what a landmark is: its kind, its tags, and what people say for them.

    Examples
    --------
    >>> import shapely
    >>> kind_words(Landmark("Ivy", "poi", shapely.Point(0, 0), properties={"amenity": "cafe"}))
    ('cafe', 'coffee shop', 'coffee house')
    """
    values = [] if landmark.kind == "poi" else [landmark.kind]
    for tag in _KIND_TAGS:
        value = landmark.properties.get(tag)
        # "yes" says that it is one, not which kind.
        if isinstance(value, str) and value not in ("yes", "no"):
            values += [part.strip().replace("_", " ") for part in value.split(";")]
    words = [w for value in values for w in (value, *_SAID_FOR.get(value, ())) if w]
    return tuple(dict.fromkeys(words))


def _spelt_alike(landmarks: Sequence[Landmark], asked: str, limit: int) -> tuple[Landmark, ...]:
    scored = []
    for i, landmark in enumerate(landmarks):
        names = [folded(n) for n in (landmark.name or "", *landmark.aliases) if n]
        # "3rd Street" is not "2nd Street", however alike they are spelt.
        same = [n for n in names if _digits(n) == _digits(asked)]
        best = max((_similarity(asked, _without_article(n)) for n in same), default=0.0)
        if best >= _FUZZY_FROM:
            scored.append((-best, i, landmark))
    return tuple(landmark for _, _, landmark in sorted(scored, key=lambda t: t[:2])[:limit])


def _similarity(asked: str, name: str) -> float:
    """Return how alike two names are, 0 to 100; 90 when one asks for some words of the other."""
    alike = float(fuzz.ratio(asked, name))
    return max(alike, 90.0) if set(asked.split()) <= set(name.split()) else alike


def _without_article(text: str) -> str:
    return next((text.removeprefix(a) for a in _ARTICLES if text.startswith(a)), text)


def _digits(text: str) -> str:
    return "".join(c for c in text if c.isdigit())
