"""Collect what people call a feature: its name, its other names, its addresses."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping

from sloop_ppl.maps._scripts import has_latin
from sloop_ppl.maps._symbols import folded
from sloop_ppl.maps.osm._romanise import romanised

__all__ = ["address", "aliases", "local_languages", "name_of"]

_ALIAS_TAGS = (
    "official_name", "short_name", "alt_name", "loc_name", "old_name", "int_name", "nat_name",
    "reg_name", "name_1", "name_2", "brand", "operator", "addr:housename",
)  # fmt: skip
# Names that are no name of the place itself.
_NOT_ITS_OWN = {"operator", "addr:housename"}
# "name:ja-Latn", "name:zh-Latn-pinyin", "name:ja_rm", "name:zh_pinyin".
_IN_LATIN = re.compile(
    r"name:[a-z]{2,3}[-_](?:latn(?:[-_]\w+)*|rm|pinyin|romaji|hepburn)", re.IGNORECASE
)
_LANGUAGE = re.compile(r"name:([a-z]{2,3})")
# Words of languages in which the house number stands before the street: English, French.
_NUMBER_FIRST = {
    "street", "st", "avenue", "ave", "road", "rd", "drive", "dr", "lane", "ln", "boulevard",
    "blvd", "place", "pl", "court", "ct", "way", "terrace", "square", "highway", "hwy", "parkway",
    "pkwy", "circle", "alley", "walk", "row", "broadway", "plaza", "pike", "trail", "rue", "cité",
    "villa", "passage", "impasse", "quai", "cours", "allée",
}  # fmt: skip
# Share of the named features that must have a name in a language for it to be one of the place:
# Swedish in Helsinki is, what an embassy is called in forty languages is not.
_SHARE_OF_LOCAL = 0.1


def name_of(tags: Mapping[str, str]) -> str | None:
    """Return the name of a feature: ``name``, a road's ``ref``, a shop's ``brand``, or None."""
    name = tags.get("name") or (tags.get("ref") if "highway" in tags else tags.get("brand"))
    cleaned = " ".join((name or "").split())
    return cleaned or None


def aliases(
    tags: Mapping[str, str], name: str | None, languages: Iterable[str] = ()
) -> tuple[str, ...]:
    """Return the other names of a feature, each once, none that reads like its name.

    A name in another script than Latin has its transliteration among them when the tags give it no
    other name in Latin letters.

    Parameters
    ----------
    tags
        Its tags. Several names in one tag are parted by ``;``.
    languages
        Languages whose ``name:xx`` counts, beside English.
    """
    keys = [*_ALIAS_TAGS, *(f"name:{language}" for language in ("en", *languages))]
    # Of a road the operator is an office, and the ref, such as "B 1", a name.
    if "highway" in tags:
        keys = [key for key in keys if key not in ("operator", "brand")] + ["ref"]
    keys += sorted(key for key in tags if key not in keys and _IN_LATIN.fullmatch(key))
    texts = [" ".join(part.split()) for key in keys for part in tags.get(key, "").split(";")]
    latin = any(has_latin(tags.get(key, "")) for key in keys if key not in _NOT_ITS_OWN)
    if not latin and name and (spelt := romanised(name)):
        texts.append(spelt)
    if own := address(tags):
        texts.append(own)
    seen = {folded(name or "")}
    kept = []
    for alias in texts:
        if alias and folded(alias) not in seen:
            seen.add(folded(alias))
            kept.append(alias)
    return tuple(kept)


def address(tags: Mapping[str, str]) -> str | None:
    """Return house number and street in the order of the place, or None when one is missing.

    Examples
    --------
    >>> address({"addr:street": "Main Street", "addr:housenumber": "12"})
    '12 Main Street'
    >>> address({"addr:street": "Yrjönkatu", "addr:housenumber": "3"})
    'Yrjönkatu 3'
    """
    street, number = tags.get("addr:street"), tags.get("addr:housenumber")
    if not street or not number:
        return None
    words = {word.casefold().rstrip(".") for word in street.split()}
    return f"{number} {street}" if words & _NUMBER_FIRST else f"{street} {number}"


def local_languages(named: Iterable[Mapping[str, str]]) -> tuple[str, ...]:
    """Return the languages in which at least a tenth of the named features have a name, sorted."""
    counted: Counter[str] = Counter()
    features = 0
    for tags in named:
        features += 1
        counted.update(found[1] for key in tags if (found := _LANGUAGE.fullmatch(key)))
    return tuple(
        sorted(language for language, n in counted.items() if n >= _SHARE_OF_LOCAL * features)
    )
