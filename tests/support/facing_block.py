"""Rows of houses whose addresses say that they face the wider street, for frame networks."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely import affinity

from sloop_ppl.maps import CityMap, Grid, Landmark


def facing_town(name: str = "town", blocks: int = 4, turn_rad: float = 0.0, seed: int = 0):
    """Return a town of rows of houses between a street at their front and a lane at their back.

    Half of the houses stand nearer to the nameless lane than to the street that they face, so
    the nearest way is wrong for these.
    """
    rng = np.random.default_rng(seed)
    landmarks = []
    for b in range(blocks):
        y = -150.0 + 80.0 * b
        side = 1 if b % 2 else -1
        street, lane = y + 22.0 * side, y - 22.0 * side
        name_of = f"{'ABCDEFGH'[b]} Street"
        landmarks += [
            _way(f"Street{b}", "street", name_of, street, 10.0),
            _way(f"Lane{b}", "service", None, lane, 3.0),
        ]
        for i in range(12):
            x = -165.0 + 30.0 * i
            at = y + float(rng.uniform(-8, 8))
            house = shapely.box(x - 7, at - 9, x + 7, at + 9)
            tags = {"addr:street": name_of}
            landmarks.append(Landmark(f"House{b}n{i}", "building", house, properties=tags))
    turned = tuple(
        Landmark(
            m.id, m.kind, affinity.rotate(m.geometry, turn_rad, origin=(0, 0), use_radians=True),
            m.name, width_m=m.width_m, properties=m.properties,
        )
        for m in landmarks
    )  # fmt: skip
    return CityMap(name, Grid.square(500.0, centre=(10.0, 20.0)), turned)


def _way(way_id: str, kind: str, name: str | None, y: float, width_m: float) -> Landmark:
    line = shapely.LineString([(-200, y), (200, y)])
    return Landmark(way_id, kind, line, name=name, width_m=width_m)


def facing_rad(city: CityMap) -> dict[str, float]:
    """Return which way each house of an unturned town faces: up in odd rows, down in even ones."""
    return {
        house.id: math.pi / 2 if int(house.id[5]) % 2 else -math.pi / 2
        for house in city.of_kind("building")
    }
