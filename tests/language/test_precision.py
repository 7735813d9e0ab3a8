"""Ordinary words name no place, on a map of forty landmarks as on one of two thousand."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import pytest

from sloop_ppl.language.linking import link_landmarks
from sloop_ppl.language.name_index import name_index
from sloop_ppl.language.words import split_words
from sloop_ppl.maps import CityMap, bundled_maps, load_map
from sloop_ppl.maps.osm import import_osm

DATA = Path(__file__).parent / "data"
EXTRACTS = Path(__file__).parents[3] / "shared" / "data" / "osm"
# Windows of a kilometre where names are densest; smaller extracts whole.
FILES = {
    "helsinki": ("helsinki.osm.pbf", (60.168738, 24.943846)),
    "baltimore": ("baltimore.osm.pbf", (39.283855, -76.589796)),
    "harrisburg": ("harrisburg.osm.pbf", (40.270939, -76.839200)),
    "austin_campus": ("austin_campus.osm", None),
    "paris": ("paris.osm", None),
    "nyc": ("new_york_block.osm.pbf", None),
}
NO_PLACE = (DATA / "no_place.txt").read_text("utf-8").splitlines()
PLACES = [line.split("\t") for line in (DATA / "city_places.txt").read_text("utf-8").splitlines()]
needs_extracts = pytest.mark.skipif(
    not EXTRACTS.is_dir(), reason="the extracts of ../shared are absent"
)


@lru_cache
def imported(name: str) -> CityMap:
    file, centre = FILES[name]
    if centre is None:
        return import_osm(EXTRACTS / file, everything=True)[0]
    return import_osm(EXTRACTS / file, centre=centre, side_m=1000)[0]


def names_in(text: str, city: CityMap) -> list[set[str]]:
    """Return for each mention of a text the names of the landmarks that it may be."""
    mentions = link_landmarks(split_words(text), name_index(city))
    return [
        {n for i in m.candidates for n in (city.landmarks[i].name, *city.landmarks[i].aliases) if n}
        for m in mentions
    ]


@pytest.mark.parametrize("name", sorted(bundled_maps()))
def test_no_ordinary_sentence_names_a_place_of_a_bundled_map(name):
    city = load_map(name)
    assert [text for text in NO_PLACE if names_in(text, city)] == []


@needs_extracts
@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FILES))
def test_no_ordinary_sentence_names_a_place_of_an_imported_city(name):
    city = imported(name)
    assert [text for text in NO_PLACE if names_in(text, city)] == []


@needs_extracts
@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FILES))
def test_places_of_imported_cities_are_found_and_nothing_else(name):
    city = imported(name)
    for _, text, names in (line for line in PLACES if line[0] == name):
        found = names_in(text, city)
        whole = {m.name for m in city.landmarks}
        wanted = [{n} if n in whole else set(n.split("/")) for n in names.split("|")]
        assert len(found) == len(wanted), text
        assert all(any(w & f for f in found) for w in wanted), text
