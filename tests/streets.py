"""Little maps of streets that several tests share."""

from __future__ import annotations

import shapely

from sloop_ppl.maps import CityMap, Grid, Landmark
from tests.scenes import symmetric_grid

GRID = symmetric_grid(41)  # cells of 5 m from -102.5 to 102.5, their centres at multiples of 5


def street(
    name: str,
    *points: tuple[float, float],
    id: str | None = None,  # noqa: A002
    kind: str = "street",
    width_m: float = 8.0,
    **properties: object,
) -> Landmark:
    """Return a street; its id is its name without spaces unless given."""
    line = shapely.LineString(points)
    named = id or name.replace(" ", "")
    return Landmark(named, kind, line, name=name, width_m=width_m, properties=properties)


def city(*landmarks: Landmark, grid: Grid = GRID) -> CityMap:
    """Return a map with these landmarks."""
    return CityMap("toy", grid, landmarks)


def two_by_two(*more: Landmark) -> CityMap:
    """Return two streets east and west at y = -40 and 40, crossed by two at x = -40 and 40.

    West Ave is drawn as two lines with two spellings of its name.
    """
    return city(
        street("South St", (-105, -40), (105, -40)),
        street("North St", (-105, 40), (105, 40)),
        street("West Ave", (-40, -105), (-40, 0)),
        street("West Avenue", (-40, 0), (-40, 105)),
        street("East Ave", (40, -105), (40, 105)),
        *more,
    )


def house(name: str, x: float, y: float, half: float = 4.0, **properties: object) -> Landmark:
    """Return a square building about a point."""
    box = shapely.box(x - half, y - half, x + half, y + half)
    return Landmark(name, "building", box, name=name, properties=properties)
