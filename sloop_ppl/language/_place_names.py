"""Call places what who speaks calls them: by the same alias, in the same script."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache

from rapidfuzz import fuzz

from sloop_ppl.language.name_index import canonical
from sloop_ppl.language.values import Description
from sloop_ppl.language.words import split_words
from sloop_ppl.maps import CityMap, Landmark
from sloop_ppl.maps._scripts import has_latin

__all__ = ["PlaceNames"]

# Below this a mention is no misspelling of a name.
_LEAST_ALIKE = 85.0


class PlaceNames:
    """What the places of a map are called to who said something.

    A landmark that was spoken of has the name, or alias, that was used for it. Any other has its
    own name; where that is in another script than all that was said, the alias in Latin letters.

    Parameters
    ----------
    city
        The map.
    descriptions
        What was said; without any the names are the map's.

    Examples
    --------
    >>> from sloop_ppl.language import parse
    >>> from sloop_ppl.maps import load_map
    >>> city = load_map("cleveland")
    >>> PlaceNames(city, [parse("the bike is near Hoyt Block", city)]).of("VelvetDog")
    'Velvet Dog'
    """

    def __init__(self, city: CityMap, descriptions: Iterable[Description] = ()) -> None:
        self.city = city
        given = tuple(descriptions)
        texts = "".join(description.text for description in given)
        self._latin = has_latin(texts)
        self._used: dict[str, str] = {}
        mentions = dict.fromkeys(pair for one in given for pair in _mentions(one))
        for mention, landmark_id in mentions:
            if landmark_id in city and landmark_id not in self._used:
                name = _used_name(mention, city.landmark(landmark_id))
                if name is not None:
                    self._used[landmark_id] = name

    def of(self, landmark_id: str) -> str:
        """Return what a landmark is called."""
        used = self._used.get(landmark_id)
        if used is not None:
            return used
        landmark = self.city.landmark(landmark_id)
        if self._latin and landmark.name and not has_latin(landmark.name):
            return next(filter(has_latin, landmark.aliases), landmark.label)
        return landmark.label


def _mentions(description: Description) -> Iterator[tuple[str, str]]:
    """Yield the words of each mention, with each landmark that they may mean."""
    for relation in description.relations:
        spans = relation.spans.grounds if relation.spans is not None else ()
        for index, ((start, end), ground) in enumerate(zip(spans, relation.grounds, strict=False)):
            words = description.text[start:end]
            yield words, ground
            if not relation.each:
                yield from ((words, c.ground) for c in relation.slot(index) if c.ground)


def _used_name(mention: str, landmark: Landmark) -> str | None:
    """Return the name that a mention is, but for case, endings and slips, or is a part of."""
    words = _key(mention)
    keys = {name: _key(name) for name in (landmark.name, *landmark.aliases) if name}
    if not words or not keys:
        return None
    likeness = {name: fuzz.ratio(" ".join(words), " ".join(key)) for name, key in keys.items()}
    nearest = max(likeness, key=likeness.__getitem__)  # the first of equals, its own name
    if likeness[nearest] >= _LEAST_ALIKE:
        return nearest
    return next((name for name, key in keys.items() if set(words) <= set(key)), None)


@lru_cache(maxsize=4096)
def _key(text: str) -> tuple[str, ...]:
    words = [canonical(word.low) for word in split_words(text[:200]) if word.kind != "mark"]
    return tuple(words[1:] if words[:1] == ["the"] else words)
