"""Write the suburban map from its plan in metres: python tests/tools/build_suburb.py OUT.geojson.

The plan is by hand: a neighbourhood that nobody lives in, after the one in which the paper flew.
x is east and y north of the map's centre. A house is two landmarks: the plot, which people name,
and in it the building, which stands in the way.
"""

from __future__ import annotations

import sys
from pathlib import Path

import shapely

from sloop_ppl.maps import CityMap, Grid, Landmark, write_map

# In the Atlantic, so that no real place is meant.
CENTRE = (41.0, -30.0)

STREETS = (
    # id, name, kind, width, points
    ("MainSt", "Main Street", "street", 8, [(-100, 0), (100, 0)]),
    ("EastSt", "East Street", "street", 7, [(40, -100), (40, 100)]),
    ("OakLane", "Oak Lane", "street", 6, [(-50, 0), (-50, 100)]),
    ("ParkRoad", "Park Road", "street", 6, [(-100, -70), (40, -70)]),
    ("Alley", None, "service", 4, [(-47, 40), (36.5, 40)]),
    ("SchoolPath", "School Path", "pedestrian", 3, [(5, -73), (5, -100)]),
)

# Owner, plot (west, south, east, north), height of the house, its outline as boxes.
HOUSES = (
    # North of Main Street, fronts to the south.
    ("Annie", (-46, 5, -19, 37), 6.5, [(-39, 11, -26, 20)]),
    ("Ben", (-17, 5, 9, 37), 11.5, [(-11, 12, 3, 21), (-11, 21, -4, 26)]),
    ("Carla", (11, 5, 36, 37), 7.0, [(17, 11, 30, 20)]),
    # Between the alley and the park, fronts to Oak Lane and to East Street.
    ("David", (-46, 43, -6, 69), 12.0, [(-40, 49, -30, 63)]),
    ("Emma", (-4, 43, 36, 69), 6.0, [(20, 49, 30, 62)]),
    # West of Oak Lane, fronts to the east, the corner house to Main Street.
    ("Frank", (-98, 5, -54, 36), 9.0, [(-84, 11, -68, 21)]),
    ("Grace", (-98, 39, -54, 68), 13.5, [(-70, 46, -60, 61), (-78, 46, -70, 53)]),
    ("Hugo", (-98, 71, -54, 98), 6.5, [(-71, 78, -60, 91)]),
    # East of East Street, fronts to the west.
    ("Ida", (44, 5, 98, 36), 11.0, [(50, 12, 61, 28)]),
    ("James", (44, 39, 98, 68), 7.0, [(50, 46, 60, 60)]),
    ("Kate", (44, 71, 98, 98), 12.5, [(51, 77, 62, 92)]),
    # South of Main Street, fronts to the north.
    ("Leo", (-98, -36, -66, -5), 7.5, [(-89, -21, -75, -11)]),
    ("Mary", (-64, -36, -34, -5), 12.0, [(-57, -20, -42, -11), (-49, -26, -42, -20)]),
    ("Nina", (-32, -36, -4, -5), 6.5, [(-25, -20, -12, -11)]),
    # North of Park Road, fronts to the south.
    ("Oscar", (-98, -66, -60, -38), 8.0, [(-86, -60, -72, -50)]),
    ("Paula", (-58, -66, -22, -38), 11.5, [(-47, -60, -33, -50)]),
    ("Quinn", (-20, -66, 12, -38), 6.0, [(-11, -60, 3, -51)]),
    # East of East Street again.
    ("Rosa", (44, -36, 98, -5), 8.5, [(50, -29, 61, -13)]),
)

OTHERS = (
    # id, name, kind, geometry, properties
    ("CornerStore", "Corner Store", "building", (8, -25, 28, -9),
     {"height_m": 5.0, "shop": "convenience"}),
    ("StoreCarPark", "Store Car Park", "parking", (0, -36, 36, -27), {"amenity": "parking"}),
    ("SunsetApartments", "Sunset Apartments", "building", (52, -82, 74, -46),
     {"height_m": 18.0, "building": "apartments"}),
    ("ApartmentCarPark", None, "parking", (78, -84, 98, -44), {"amenity": "parking"}),
    ("LincolnSchool", "Lincoln School", "building", (-60, -92, -20, -78),
     {"height_m": 9.0, "amenity": "school"}),
    ("Playground", None, "park", (-98, -98, -66, -75), {"leisure": "playground"}),
    ("MaplePark", "Maple Park", "park", (-46, 72, 36, 98), {"leisure": "park"}),
    ("DuckPond", "Duck Pond", "water", None, {"natural": "water"}),
)  # fmt: skip


def landmarks():
    for symbol, name, kind, width, points in STREETS:
        yield Landmark(symbol, kind, shapely.LineString(points), name, width_m=float(width))
    for owner, plot, height, boxes in HOUSES:
        symbol = f"{owner}sHouse"
        yield Landmark(
            symbol, "poi", shapely.box(*plot), f"{owner}'s House", aliases=(f"{owner}'s Place",),
            properties={"landuse": "residential"},
        )  # fmt: skip
        outline = shapely.union_all([shapely.box(*box) for box in boxes])
        yield Landmark(
            f"{symbol}Building", "building", outline,
            properties={"height_m": height, "building": "house"},
        )  # fmt: skip
    for symbol, name, kind, box, properties in OTHERS:
        pond = shapely.Point(-15, 86).buffer(8, quad_segs=4) if box is None else shapely.box(*box)
        yield Landmark(symbol, kind, pond, name, properties=properties)


def build():
    grid = Grid(-100.0, -100.0, 100.0, 100.0, centre=CENTRE)
    return CityMap("suburb", grid, tuple(landmarks()), "An invented place, drawn for sloop_ppl")


if __name__ == "__main__":
    write_map(build(), Path(sys.argv[1]))
