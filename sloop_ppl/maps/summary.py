"""Sum a map up in a few numbers."""

from __future__ import annotations

from typing import Any

from sloop_ppl.maps.city import CityMap

__all__ = ["summary"]


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
