"""Small hand-made maps and descriptions that several tests share."""

from __future__ import annotations

import shapely

from sloop_ppl.language import Description, SpatialRelation, TargetObject
from sloop_ppl.maps import CityMap, Grid, Landmark

TARGET = "RedCar"


def symmetric_grid(n_cells: int = 5, cell_m: float = 5.0) -> Grid:
    """Return an n x n grid whose cells lie symmetrically about the origin."""
    half = n_cells * cell_m / 2
    slack = cell_m / 100
    return Grid(-half, -half + slack, half - slack, half, cell_m)


def point_city(grid: Grid, **points: tuple[float, float]) -> CityMap:
    """Return a map whose landmarks are points (kind poi), by name."""
    return CityMap(
        "toy",
        grid,
        tuple(Landmark(name, "poi", shapely.Point(xy)) for name, xy in points.items()),
    )


def house_and_street(
    grid: Grid, *, house: tuple[float, float] = (0.0, 0.0), street_y: float = 40.0
) -> CityMap:
    """Return a square house and a street north (or south) of it, running west to east."""
    x, y = house
    return CityMap(
        "block",
        grid,
        (
            Landmark("House", "building", shapely.box(x - 4, y - 4, x + 4, y + 4), name="House"),
            Landmark(
                "MainSt",
                "street",
                shapely.LineString([(grid.west_m, street_y), (grid.east_m, street_y)]),
                name="Main Street",
                width_m=4.0,
            ),
        ),
    )


def said(*relations: SpatialRelation, targets: tuple[str, ...] = (TARGET,)) -> Description:
    """Return a description that says just these relations."""
    return Description("", "", tuple(TargetObject(t) for t in targets), relations)


def relation(
    word: str, *grounds: str, negated: bool = False, figure: str = TARGET
) -> SpatialRelation:
    """Return a relation of the one target."""
    return SpatialRelation(figure, word, grounds, negated=negated)
