"""The world of a map: collision geometry, targets, heights, and what it refuses."""

import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import shapely

from sloop_ppl.errors import InputError, OutputError, OutsideMap, UnknownName
from sloop_ppl.maps import CityMap, Grid, bundled_maps, load_map
from sloop_ppl.simulation import Look, World, look_of, nearest_free
from sloop_ppl.simulation._mujoco import mujoco


def first_hit(world, x, y):
    """Return what a ray straight down meets, and how high that is."""
    mj = mujoco()
    data = mj.MjData(world.model)
    mj.mj_forward(world.model, data)
    geom = np.full(1, -1, dtype=np.int32)
    groups = np.array([1, 0, 1, 1, 1, 1], dtype=np.uint8)
    down = np.array([0.0, 0.0, -1.0])
    at = np.array([x, y, 40.0])
    reach = mj.mj_ray(world.model, data, at, down, groups, True, -1, geom)
    return world.geom_owners[geom[0]], 40.0 - reach


@pytest.mark.parametrize("name", ["cleveland", "washington_dc"])
def test_a_point_is_over_a_hull_if_and_only_if_it_is_in_the_footprint(name):
    world = World.from_map(load_map(name), parked=0)
    rng = np.random.default_rng(1)
    borders = shapely.union_all([b.geometry.boundary for b in world.city.of_kind("building")])
    tested = 0
    for x, y in rng.uniform(-99, 99, (250, 2)):
        point = shapely.Point(x, y)
        if borders.distance(point) < 0.02:
            continue
        over = {b.id for b in world.city.of_kind("building") if b.geometry.contains(point)}
        owner, height = first_hit(world, x, y)
        if over:
            assert owner in over
            assert height == pytest.approx(max(world.heights_m[b] for b in over), abs=1e-3)
        else:
            assert owner == "Ground"
        tested += 1
    assert tested > 200


def test_heights_are_told_or_of_the_kind(yard):
    heights = World.from_map(yard).heights_m
    assert heights["Shed"] == 4
    assert 10.5 <= heights["House"] <= 13.5
    assert heights == World.from_map(yard).heights_m
    assert heights["House"] != World.from_map(yard, seed=1).heights_m["House"]


def test_the_map_of_a_world_is_the_same_map_to_whoever_compares(yard):
    assert World.from_map(yard).city.digest == yard.digest


def test_targets_are_where_they_were_put_and_look_as_told(yard):
    looks = {"MyDog": Look("van", "blue")}
    world = World.from_map(yard, {"RedBike": (10.0, 10.0), "MyDog": (-40.0, 0.0)}, looks=looks)
    assert world.looks["RedBike"] == Look("bike", "red")
    assert first_hit(world, -40.0, 0.0) == ("MyDog", pytest.approx(2.4, abs=0.05))
    assert first_hit(world, 10.0, 10.0)[0] == "RedBike"
    assert first_hit(world, 15.0, 15.0)[0] == "Ground"


def test_parked_cars_stand_in_the_open_in_colours_of_no_target():
    city = load_map("cleveland")
    world = World.from_map(city, {"BlueCar": (-45.0, -62.0)}, parked=12, seed=3)
    assert len(world.parked) == 12
    assert "blue" not in world.parked_colours.values()
    for place in world.parked.values():
        assert world.building_at(place) is None


@pytest.mark.parametrize(
    ("place", "error", "words"),
    [
        ((-5.0, -5.0), InputError, "inside Long House.*the nearest is"),
        ((500.0, 0.0), OutsideMap, "'RedCar'"),
        ((math.nan, 0.0), InputError, "x and y in metres"),
        ("here", InputError, "x and y in metres"),
    ],
)
def test_places_where_nothing_can_stand(yard, place, error, words):
    with pytest.raises(error, match=words):
        World.from_map(yard, {"RedCar": place})


def test_the_place_that_is_named_instead_is_free(yard):
    free = nearest_free(yard, (-5.0, -5.0), 1.0)
    World.from_map(yard, {"RedCar": free})
    gap = yard.landmark("House").geometry.distance(shapely.Point(free))
    assert gap == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("map_name", bundled_maps())
def test_a_place_in_the_open_is_on_the_map_though_a_building_reaches_beyond_it(map_name):
    city = load_map(map_name)
    west, south, east, north = city.grid.extent_m
    rng = np.random.default_rng(0)
    along = [(float(x), float(y)) for x, y in rng.uniform((west, south), (east, north), (60, 2))]
    for x, y in along:
        for place in ((west, y), (x, south), (east - 0.5, y), (x, north - 0.5)):
            assert city.grid.contains(*nearest_free(city, place))


@pytest.mark.parametrize(("name", "value"), [("seed", -1), ("parked", -2), ("parked", 1.5)])
def test_numbers_out_of_range(yard, name, value):
    with pytest.raises(InputError, match=f"{name} is"):
        World.from_map(yard, **{name: value})


def test_kinds_and_colours_that_there_are_not():
    with pytest.raises(UnknownName, match="Kind of target 'boat'"):
        Look("boat")
    with pytest.raises(UnknownName, match="did you mean 'red'"):
        Look("car", "redd")
    assert look_of("MyThing", "dog", "mauve") == Look("car", "red")


def test_a_map_without_buildings_is_a_world():
    world = World.from_map(CityMap("field", Grid.square(30.0), ()), {"RedCar": (0.0, 0.0)})
    assert first_hit(world, 0.0, 0.0)[0] == "RedCar"
    assert world.sight_is_free((-20.0, 0.0, 14.0), (0.0, 0.0), 0.8)


def test_sight_agrees_with_rays():
    mj = mujoco()
    world = World.from_map(load_map("cleveland"), parked=0)
    data = mj.MjData(world.model)
    mj.mj_forward(world.model, data)
    rng, groups = np.random.default_rng(2), np.array([1, 0, 1, 1, 1, 1], dtype=np.uint8)
    for start, end in rng.uniform(-90, 90, (150, 2, 2)):
        near, far = np.array([*start, 14.0]), np.array([*end, 0.8])
        way = far - near
        geom = np.full(1, -1, dtype=np.int32)
        reach = mj.mj_ray(world.model, data, near, way, groups, True, -1, geom)
        blocked = 0 <= reach < 1
        assert world.sight_is_free(tuple(near), tuple(end), 0.8) is not blocked


def test_mjcf_is_read_back_as_the_same_city(yard, tmp_path):
    world = World.from_map(yard, {"RedCar": (10.0, 10.0)}, parked=0)
    path = world.to_mjcf(tmp_path / "yard.xml")
    ElementTree.parse(path)
    assert (tmp_path / "yard_ground.png").exists()
    again = mujoco().MjModel.from_xml_path(str(path))
    assert (again.ngeom, again.nmesh) == (world.model.ngeom, world.model.nmesh)
    with pytest.raises(OutputError, match=r"expected one of \.xml"):
        world.to_mjcf(tmp_path / "yard.txt")


def test_a_world_is_a_value(yard):
    world = World.from_map(yard)
    with pytest.raises(AttributeError):
        world.city = None
    assert replace(world).city is world.city
