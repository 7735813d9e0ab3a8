"""What the workbench shows first: a sentence that was said of the map, with the true place."""

from __future__ import annotations

from typing import Any

from sloop_ppl.eval import bundled_examples
from sloop_ppl.maps import CityMap
from sloop_ppl.web._maps import MapShelf

__all__ = ["first_state"]

_FIRST = {
    "cleveland": ("The green Toyota is in front of Hoyt Block, on West 6th Street.", (27.5, -67.5)),
}


def first_state(shelf: MapShelf) -> dict[str, Any]:
    """Return the state of the page before anyone has touched it, and examples to choose from."""
    examples: list[dict[str, Any]] = [
        {"map": one.map, "text": one.text, "places": {
            name: [place.x_m, place.y_m] for name, place in one.targets.items()
        }}
        for one in bundled_examples()
    ]  # fmt: skip
    key = shelf.first
    text: str = ""
    places: dict[str, list[float]] = {}
    if key in _FIRST:
        text, place = _FIRST[key]
        places = {"GreenToyota": list(place)}
    else:
        fitting = [one for one in examples if one["map"] == key]
        if fitting:
            text, places = fitting[0]["text"], fitting[0]["places"]
        else:
            text = _made_up(shelf.get(key))
    return {"map": key, "text": text, "places": places, "examples": examples}


def _made_up(city: CityMap) -> str:
    """Return a sentence about the named building or place nearest to the middle of the map."""
    west, south, east, north = city.grid.extent_m
    named = [m for m in city.landmarks if m.name and m.kind in ("building", "poi", "park")]
    found = city.nearest((west + east) / 2, (south + north) / 2, named)
    return f"The green Toyota is near {found[0].name}." if found else ""
