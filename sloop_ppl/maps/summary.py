"""Sum a map up: in a few numbers, and in a few lines."""

from __future__ import annotations

from typing import Any

from sloop_ppl.maps.city import CityMap

__all__ = ["map_lines", "summary"]


def summary(city: CityMap) -> dict[str, Any]:
    """Return what `sloop map show --json` prints.

    Returns
    -------
    dict
        ``name``; ``extent_m``, west, south, east and north in metres; ``cell_m``; ``shape``, rows
        and columns; ``counts``, landmarks by kind; ``named``, how many landmarks have a name.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> summary(load_map("cleveland"))["named"]
    37
    """
    return {
        "name": city.name,
        "extent_m": list(city.grid.extent_m),
        "cell_m": city.grid.cell_m,
        "shape": list(city.grid.shape),
        "counts": city.counts(),
        "named": sum(m.name is not None for m in city.landmarks),
    }


# Names that fit on a screen.
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
