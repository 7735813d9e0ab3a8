"""Say in a few lines what is on a map."""

from __future__ import annotations

from sloop_ppl.maps.city import CityMap
from sloop_ppl.maps.summary import summary

__all__ = ["map_lines"]

_LISTED = 60


def map_lines(city: CityMap) -> list[str]:
    """Return a few lines about what is on a map."""
    stats = summary(city)
    west, south, east, north = stats["extent_m"]
    counts = ", ".join(f"{n} {kind}" for kind, n in stats["counts"].items())
    rows, cols = stats["shape"]
    named = list(dict.fromkeys(m.label for m in city.landmarks if m.name))
    more = f", and {len(named) - _LISTED} more" if len(named) > _LISTED else ""
    return [
        (
            f"{city.name}: {east - west:g} m x {north - south:g} m, {rows} x {cols} cells of "
            f"{city.grid.cell_m:g} m"
        ),
        f"{len(city.landmarks)} landmarks, {stats['named']} named: {counts}",
        ", ".join(named[:_LISTED]) + more,
        *([city.attribution] if city.attribution else []),
    ]
