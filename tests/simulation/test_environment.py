"""Searches that are flown: whole episodes, collisions, lost drones, batteries, seeds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.maps import load_map
from sloop_ppl.planning import SearchConfig, SearchSpace, run_search
from sloop_ppl.planning.environment import start_pose
from sloop_ppl.planning.values import SearchAction
from sloop_ppl.simulation import (
    Camera,
    Drone,
    FlightSensor,
    MujocoEnvironment,
    SensorRates,
    World,
    flight_plan,
    open_share,
)

FORWARD, LEFT = SearchAction("forward", 0), SearchAction("left", 1)
FIND = SearchAction("find", 3, 1)


def flown(world, start, altitude=14.0, detector="rays", seed=0, free=False, **options):
    config, sensor = flight_plan(
        world.city, SearchConfig(sims=200, max_steps=60), altitude, detector
    )
    if free:
        config = replace(config, no_fly=False, clearance_m=0.0)
    drone = Drone(world, start, altitude_m=altitude, rng=np.random.default_rng(seed), **options)
    camera = Camera(world, drone)
    return MujocoEnvironment(
        world, drone, camera, detector=detector, config=config, sensor=sensor
    )  # fmt: skip


def searched(world, environment, seed=0):
    beliefs = {t: open_share(world.city) + 0.01 for t in world.places}
    return run_search(
        beliefs, world.city, world.places, environment=environment,
        config=environment.space.config, sensor=environment.space.sensor,
        rng=np.random.default_rng(seed),
    )  # fmt: skip


def test_a_move_is_flown_and_what_is_seen_comes_back(yard):
    world = World.from_map(yard, {"RedCar": (37.5, -22.5)}, parked=0)
    environment = flown(world, (12.5, -27.5))
    pose, report, collision = environment.execute(FORWARD)
    assert pose[:2] == pytest.approx((27.5, -27.5), abs=0.6)
    assert not collision
    assert report.seen["RedCar"] == pytest.approx((37.5, -22.5), abs=1.0)
    pose, _, _ = environment.execute(LEFT)
    assert pose.heading_rad == pytest.approx(math.pi / 4, abs=0.1)
    assert environment.execute(FIND).report.found in ((), ("RedCar",))


def test_a_find_before_a_look_marks_nothing(yard):
    world = World.from_map(yard, {"RedCar": (37.5, -22.5)}, parked=0)
    environment = flown(world, (27.5, -27.5))
    assert environment.execute(FIND).report.found == ()
    environment.execute(LEFT)
    environment.execute(SearchAction("right", 2))
    assert environment.execute(FIND).report.found == ("RedCar",)
    assert environment.execute(FIND).report.found == ()


@pytest.mark.parametrize(("beyond_m", "marked"), [(0.5, ("RedCar",)), (2.4, ())])
def test_a_find_marks_a_car_that_reaches_into_the_view(yard, beyond_m, marked):
    def looked(place):
        environment = flown(World.from_map(yard, {"RedCar": place}, parked=0), (27.5, -27.5))
        for turn in (LEFT, SearchAction("right", 2)):
            environment.execute(turn)
        return environment

    before = looked((37.5, -22.5))
    view, grid = before.space.view_mask(before._true_pose()), yard.grid
    row, col = next((r, c) for r, c in np.argwhere(view[:, :-1]) if not view[r, c + 1])
    x, y = grid.centre_of(row, col)
    # Its middle is beyond the view's border; a car is 4.3 m by 1.8 m, whichever way it faces.
    environment = looked((x + grid.cell_m / 2 + beyond_m, y))
    assert environment.log.in_view[-1] == ()
    assert environment.execute(FIND).report.found == marked


def test_a_wall_that_is_flown_into_costs_a_thousand_and_is_survived(yard):
    world = World.from_map(yard, {"RedCar": (37.5, -22.5)}, parked=0)
    environment = flown(world, (12.5, 7.5, math.pi), altitude=8.0, free=True)
    outcome = environment.execute(FORWARD)
    assert outcome.collision
    assert environment.log.collisions == [(0, "House")]
    assert outcome.pose[:2] == pytest.approx((12.5, 7.5), abs=0.8)
    assert environment.drone.is_upright


def test_the_edge_of_the_map_is_not_flown_over(yard):
    world = World.from_map(yard, {"RedCar": (37.5, -22.5)}, parked=0)
    environment = flown(world, (47.5, 2.5))
    outcome = environment.execute(FORWARD)
    assert outcome.pose[:2] == pytest.approx((47.5, 2.5), abs=0.6)
    assert not outcome.collision


def test_an_empty_battery_ends_the_search_with_what_was_learnt(yard):
    world = World.from_map(yard, {"RedCar": (-45.0, -45.0)}, parked=0)
    environment = flown(world, (42.5, 42.5, math.pi), battery_steps=3)
    episode = searched(world, environment)
    assert episode.steps == 3
    assert episode.notes[-1] == "The battery is empty: the drone has landed"
    assert environment.drone.pose.z_m < 0.2 or environment.drone.pose.z_m > 3.9


def test_a_drone_that_is_turned_over_ends_the_search(yard):
    world = World.from_map(yard, {"RedCar": (-45.0, -45.0)}, parked=0)
    environment = flown(world, (42.5, -2.5, math.pi))
    environment.drone._flying = False
    environment.drone.data.act[:] = 0
    real = environment.drone.yaw_to

    def fall(yaw_rad, stop=None):
        environment.drone._qpos[3:] = 0.0, 1.0, 0.0, 0.0
        return real(yaw_rad, lambda: True)

    environment.drone.yaw_to = environment.drone.move_to = lambda *a, **k: fall(0.0)
    episode = searched(world, environment)
    assert episode.steps == 0
    assert "The drone is lost" in episode.notes[-1]


def test_the_same_seed_is_the_same_episode(yard):
    world = World.from_map(yard, {"RedCar": (-30.0, 5.0)}, parked=0)
    runs = []
    for seed in (1, 1, 2):
        environment = flown(world, (42.5, -42.5, math.pi), wind_m_s=2.0, seed=seed)
        episode = searched(world, environment)
        runs.append((episode.to_json(), environment.log.detections, environment.drone.time_s))
    assert runs[0] == runs[1]
    assert runs[0][2] != runs[2][2]


@pytest.mark.parametrize("altitude", [14.0, 10.0])
def test_a_whole_search_with_the_camera_finds_its_car(rendering, altitude):
    city = load_map("cleveland")
    world = World.from_map(city, {"GreenToyota": (-2.5, -47.5)})
    rng = np.random.default_rng(4)
    config, sensor = flight_plan(
        world.city, SearchConfig(sims=300, max_steps=60), altitude, "camera"
    )
    space = SearchSpace.of_city(world.city, ("GreenToyota",), config, sensor=sensor)
    start = start_pose((27.5, -57.5, 180.0), space, rng)
    drone = Drone(world, tuple(start), altitude_m=altitude, wind_m_s=2.0, rng=rng)
    x, y = np.meshgrid(city.grid.x_m, city.grid.y_m)
    belief = np.exp(-((x + 2.5) ** 2 + (y + 47.5) ** 2) / (2 * 20.0**2)) + 1e-6
    with Camera(world, drone) as camera:
        environment = MujocoEnvironment(world, drone, camera, config=config, sensor=sensor)
        episode = run_search(
            {"GreenToyota": belief}, world.city, world.places, environment=environment,
            config=config, sensor=sensor, rng=rng,
        )  # fmt: skip
    assert episode.found
    assert environment.log.collisions == []
    assert any(environment.log.detections)


def test_planned_flights_keep_clear_of_walls():
    """Every move that the planner may make keeps its distance, whatever the cells say."""
    import shapely

    world = World.from_map(load_map("cleveland"))
    config, sensor = flight_plan(world.city, SearchConfig(), 10.0, "camera")
    space = SearchSpace.of_city(world.city, ("T",), config, sensor=sensor)
    walls = shapely.union_all([b.geometry for b in world.city.of_kind("building")])
    rng, open_moves = np.random.default_rng(0), 0
    for pose in rng.integers(space.n_cells * 8, size=1500):
        start = space.pose_at(int(pose))
        if int(pose) // 8 in space.no_fly:
            continue
        after, collided = space.moved(0, int(pose))
        if after != int(pose) and not collided:
            line = shapely.LineString([start[:2], space.pose_at(after)[:2]])
            assert line.distance(walls) >= config.clearance_m - 1e-9
            open_moves += 1
    assert open_moves > 50


def test_the_sensor_sees_over_what_is_low_and_not_behind_what_is_tall(yard):
    world, rates = World.from_map(yard, parked=0), SensorRates(0.9, 0.0, 0.3)
    low, high = (FlightSensor(world.city, z, rates) for z in (8.0, 30.0))
    pose = SearchSpace(world.city.grid, ("T",), SearchConfig()).pose_at
    grid = world.city.grid
    row, col = grid.cell_at(-22.5, 7.5)
    west_of_house = pose((row * grid.n_cols + col) * 8)
    behind = grid.cell_at(-12.5, 7.5)
    assert not low.view(west_of_house)[behind]  # a wall 12 m tall
    assert high.view(west_of_house)[behind]  # its roof
    assert low.view(west_of_house).sum() < high.view(west_of_house).sum()


def test_the_sensor_sees_the_fan_of_the_grid_where_nothing_stands():
    from sloop_ppl.maps import CityMap, Grid
    from sloop_ppl.planning import FanSensor

    city = CityMap("field", Grid.square(50.0), ())
    sensor, fan = FlightSensor(city, 14.0, SensorRates(1.0, 0.0, 0.0)), FanSensor(city.grid)
    space = SearchSpace(city.grid, ("T",), SearchConfig())
    for number in range(0, space.n_cells * 8, 7):
        assert np.array_equal(sensor.view(space.pose_at(number)), fan.view(space.pose_at(number)))
    # A little beside the middle of a cell it sees the same cells.
    at = space.pose_at(space.encode(10, 10, 1))
    beside = at._replace(x_m=at.x_m + 0.3, y_m=at.y_m - 0.2, heading_rad=at.heading_rad + 0.03)
    assert np.array_equal(sensor.view(beside), sensor.view(at))


@pytest.mark.parametrize("altitude", [2.0, 100.0, math.nan])
def test_altitudes_below_and_above_all(yard, altitude):
    with pytest.raises(InputError, match="The altitude is"):
        flight_plan(yard, SearchConfig(), altitude, "camera")


def test_what_no_environment_can_be_made_of(yard):
    nothing = World.from_map(yard)
    with pytest.raises(InputError, match="The world has no target"):
        flown(nothing, (2.5, -27.5))
    world = World.from_map(yard, {"RedCar": (37.5, -22.5)}, parked=0)
    with pytest.raises(InputError, match="off the middle of a cell"):
        flown(world, (0.0, -26.0))
    with pytest.raises(InputError, match="true_positive_rate is"):
        flight_plan(yard, SearchConfig(true_positive_rate=0.5), 14.0, "camera")
