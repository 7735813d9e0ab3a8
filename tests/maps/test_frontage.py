"""Which way buildings face, on a block drawn by hand."""

import math

import pytest
import shapely

from sloop_ppl.errors import UnknownName
from sloop_ppl.maps import CityMap, Grid, Landmark

FRAME = Grid.square(100.0, centre=(10.0, 20.0))
SOUTH, EAST = -math.pi / 2, 0.0


def line(landmark_id, name, *places, kind="street", aliases=()):
    return Landmark(landmark_id, kind, shapely.LineString(places), name=name, aliases=aliases)


def house(landmark_id, *box, **properties):
    return Landmark(landmark_id, "building", shapely.box(*box), properties=properties)


def door(x, y, sort="main"):
    lon, lat = FRAME.to_lonlat(x, y)
    return {"entrance": sort, "lonlat": [float(lon), float(lat)]}


def city(*landmarks):
    return CityMap(
        "block",
        FRAME,
        (
            line("MainSt", "Main Street", (-90, -30), (90, -30)),
            line("OakAve", "Oak Avenue", (40, -90), (40, 90), aliases=("Old Oak Road",)),
            line("Alley", None, (-90, 12), (39, 12), kind="service"),
            *landmarks,
        ),
    )


def test_the_address_tells_the_street_whatever_is_nearer():
    block = city(house("H", 0, -10, 20, 10, **{"addr:street": "Main St."}))
    faces = block.frontage("H")
    assert faces.street.id == "MainSt"
    assert faces.best.source == "address"
    assert faces.bearing_rad == pytest.approx(SOUTH)
    assert faces.by_address.point_m == pytest.approx((10, -30))
    assert block.bearing_to_nearest_path("H") == pytest.approx(math.pi / 2)  # the alley
    assert faces.by_nearest.street.id in ("MainSt", "OakAve")  # nameless ways do not count


@pytest.mark.parametrize("name", ["old oak rd", "OAK AVE", "Oak Avenue"])
def test_streets_are_known_by_aliases_and_abbreviations(name):
    faces = city(house("H", 0, -10, 20, 10, **{"addr:street": name})).frontage("H")
    assert faces.by_address.street.id == "OakAve"
    assert faces.by_address.bearing_rad == pytest.approx(EAST)


def test_an_address_on_no_street_of_the_map_tells_nothing():
    faces = city(house("H", 0, -10, 20, 10, **{"addr:street": "Elm Street"})).frontage("H")
    assert faces.by_address is None
    assert faces.best.source == "nearest"


def test_the_main_entrance_faces_out_of_its_wall():
    block = city(house("H", 0, -10, 20, 10, entrances=[door(0, 0, "yes"), door(19, -10)]))
    faces = block.frontage("H").by_entrance
    assert faces.bearing_rad == pytest.approx(SOUTH)
    assert faces.point_m == pytest.approx((19, -10), abs=1e-6)
    assert faces.street.id == "Alley" or faces.street.id == "MainSt"


def test_a_door_in_a_courtyard_faces_the_courtyard():
    walls = shapely.box(0, -10, 20, 10).difference(shapely.box(5, -5, 15, 5))
    block = city(Landmark("H", "building", walls, properties={"entrances": [door(5, 0)]}))
    assert block.frontage("H").by_entrance.bearing_rad == pytest.approx(EAST)


@pytest.mark.parametrize(
    "entrances", [None, "x", [], [3], [{"entrance": "main"}], [door(0, 0, "yes")], [door(50, 50)],
                  [{"entrance": "main", "lonlat": ["a", 1]}], [{"entrance": "main", "lonlat": [1]}]]
)  # fmt: skip
def test_what_is_no_main_entrance_in_a_wall_tells_nothing(entrances):
    assert city(house("H", 0, -10, 20, 10, entrances=entrances)).frontage("H").by_entrance is None


def test_without_streets_nothing_tells_where_it_faces():
    alone = CityMap("field", FRAME, (house("H", 0, 0, 10, 10),))
    faces = alone.frontage("H")
    assert (faces.best, faces.street, faces.bearing_rad) == (None, None, None)
    assert alone.streets_of("H") == ()


def test_without_names_any_path_counts():
    path = line("Path", None, (-50, 30), (50, 30), kind="pedestrian")
    faces = CityMap("field", FRAME, (path, house("H", 0, 0, 10, 10))).frontage("H")
    assert faces.street.id == "Path"
    assert faces.bearing_rad == pytest.approx(math.pi / 2)


def test_streets_of_a_building_are_those_it_can_be_seen_from():
    block = city(house("H", 0, -10, 20, 10), house("Between", 25, -20, 35, 20))
    assert [m.id for m in block.streets_of("H")] == ["MainSt"]
    assert [m.id for m in block.streets_of("Between")] == ["OakAve", "MainSt"]


def test_a_street_has_a_frontage_too():
    assert city().frontage("MainSt").by_nearest.street.id == "OakAve"


def test_an_unknown_building_is_named():
    for ask in (city().frontage, city().streets_of):
        with pytest.raises(UnknownName, match="Landmark of map block 'Mainst' is unknown"):
            ask("Mainst")
