"""Flight: physics that must hold whatever the gains, commands, collisions and seeds."""

import math

import numpy as np
import pytest

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.simulation import Drone, Vehicle, World
from sloop_ppl.simulation._airframe import GRAVITY_M_S2, MASS_KG
from sloop_ppl.simulation._paths import Ramp, line_time, turn_time

CALM = {"drift_m": 0.0, "noise_m": 0.0, "yaw_drift_rad": 0.0}


@pytest.fixture(scope="module")
def field():
    return World.from_map(CityMap("field", Grid.square(60.0), ()))


def drone(world, start=(0.0, 0.0), seed=0, **options):
    return Drone(world, start, rng=np.random.default_rng(seed), **options)


def test_a_hover_holds_its_place_and_its_thrust_its_weight(field):
    flying = drone(field, **CALM)
    assert flying.hover(seconds=5.0)
    assert math.dist(flying.pose[:3], (0, 0, 14)) < 0.02
    assert flying.data.act.sum() == pytest.approx(MASS_KG * GRAVITY_M_S2, rel=0.02)
    assert math.dist(flying.velocity_m_s, (0, 0, 0)) < 0.02


def test_a_drone_without_thrust_falls_as_things_fall(field):
    falling = drone(field, altitude_m=40.0, **CALM)
    falling._flying = False
    falling.data.act[:] = 0.0
    for _ in range(100):
        falling._tick()
    drop = 40.0 - falling.pose.z_m
    # g t^2 / 2 less a little drag: 0.3 N for each m/s on 1.5 kg.
    assert 0.93 * 4.905 < drop < 4.905
    energy = MASS_KG * (GRAVITY_M_S2 * falling.pose.z_m + falling.velocity_m_s[2] ** 2 / 2)
    assert energy < MASS_KG * GRAVITY_M_S2 * 40.0


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_flight_is_the_same_whichever_way_it_goes(field, turns):
    """Turn place and goal by quarter turns: the path turns with them."""
    quarter = turns * math.pi / 2
    c, s = round(math.cos(quarter)), round(math.sin(quarter))
    one, other = drone(field, **CALM), drone(field, (0.0, 0.0, quarter), **CALM)
    for flying, (x, y) in ((one, (9.0, 4.0)), (other, (9.0 * c - 4.0 * s, 9.0 * s + 4.0 * c))):
        assert flying.move_to(x, y, 16.0)
    x, y, z, yaw = one.pose
    turned = (x * c - y * s, x * s + y * c, z)
    assert other.pose[:3] == pytest.approx(turned, abs=1e-3)
    assert math.remainder(other.pose.yaw_rad - yaw - quarter, 2 * math.pi) == pytest.approx(
        0.0, abs=1e-3
    )


def test_wind_pushes_and_is_held(field):
    windy = drone(field, wind_m_s=6.0, gust_m_s=0.0, **CALM)
    # At first it drifts with the wind, then the integral term holds it.
    for _ in range(40):
        windy._tick()
    pushed = math.dist(windy.pose[:2], (0, 0))
    assert windy.hover(seconds=8.0)
    before = windy.pose
    windy.hover(seconds=2.0)
    assert math.dist(windy.pose[:2], before[:2]) < 0.1 < 10 * pushed


@pytest.mark.parametrize("wind", [0.0, 4.0])
def test_moves_and_turns_end_where_they_should(field, wind):
    flying = drone(field, wind_m_s=wind, seed=3)
    for x, y, yaw in ((15.0, 0.0, 1.0), (15.0, 15.0, 3.0), (0.0, 0.0, -2.0)):
        assert flying.move_to(x, y, 12.0)
        assert flying.yaw_to(yaw)
        assert math.dist(flying.estimated_pose[:2], (x, y)) < 0.5
        assert math.dist(flying.pose[:2], (x, y)) < 1.0
        assert abs(math.remainder(flying.pose.yaw_rad - yaw, 2 * math.pi)) < math.radians(4)


def test_it_takes_off_and_lands(field):
    flying = drone(field, altitude_m=0.0, seed=2)
    assert isinstance(flying.take_off, object)
    assert flying.take_off()
    assert flying.pose.z_m == pytest.approx(3.0, abs=0.5)
    assert flying.collision is None
    assert flying.land()
    assert flying.pose.z_m < 0.1
    assert flying.collision is None
    assert flying.take_off()
    assert flying.is_upright


def test_flying_into_a_house_is_noticed_and_can_be_flown_away_from(yard):
    flying = drone(World.from_map(yard, parked=0), (10.0, 10.0), altitude_m=6.0)
    assert not flying.move_to(-10.0, 10.0, 6.0)
    assert flying.collision == "House"
    assert flying.pose.x_m > -1.0  # the wall is at x = 0
    assert flying.move_to(10.0, 10.0, 6.0, 2.0)
    assert flying.collision is None


def test_the_shed_is_flown_over(yard):
    flying = drone(World.from_map(yard, parked=0), (25.0, 35.0), altitude_m=6.0)
    assert flying.move_to(45.0, 35.0, 6.0)
    assert flying.collision is None


def test_a_command_can_be_stopped(field):
    flying = drone(field)
    left = [50]

    def stop():
        left[0] -= 1
        return left[0] < 0

    assert not flying.move_to(40.0, 0.0, 14.0, stop=stop)
    assert flying.pose.x_m < 20.0
    assert flying.time_s < 2.0
    assert not flying.yaw_to(2.0, stop=lambda: True)
    assert not flying.hover(stop=lambda: True, seconds=1.0)


def test_the_estimate_strays_as_far_as_it_was_told(field):
    off = []
    for seed in range(60):
        flying = drone(field, drift_m=0.3, noise_m=0.0, seed=seed)
        off.append(np.subtract(flying.estimated_pose[:3], flying.pose[:3]))
    # 180 draws: their deviation is within a fifth of 0.3 but once in 10^4.
    assert np.std(off) == pytest.approx(0.3, rel=0.2)


def test_the_same_seed_flies_the_same_way(field):
    paths = []
    for seed in (7, 7, 8):
        flying = drone(field, wind_m_s=3.0, seed=seed)
        flying.move_to(10.0, 5.0, 12.0)
        flying.yaw_to(1.0)
        paths.append((flying.pose, flying.estimated_pose, flying.time_s))
    assert paths[0] == paths[1] != paths[2]


def test_watchers_are_called_as_often_as_they_asked(field):
    flying, times = drone(field), []
    flying.watch(lambda d: times.append(d.time_s), 0.25)
    flying.hover(seconds=2.0)
    assert np.diff(times) == pytest.approx(0.25)
    assert len(times) == int(flying.time_s / 0.25 + 1e-9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"altitude_m": -1.0}, "altitude_m is -1.0"),
        ({"wind_m_s": math.nan}, "wind_m_s is nan"),
        ({"speed_m_s": 0.0}, "speed_m_s is 0.0"),
        ({"start": (1.0,)}, "The start is"),
        ({"start": (-5.0, -5.0), "altitude_m": 6.0}, "inside Long House.*start elsewhere"),
    ],
)
def test_what_no_drone_can_be_made_with(yard, options, words):
    with pytest.raises(InputError, match=words):
        drone(World.from_map(yard), **options)


def test_what_no_drone_can_do(field):
    flying = drone(field)
    for command in (
        lambda: flying.move_to(math.inf, 0, 0), lambda: flying.yaw_to(math.nan),
        lambda: flying.move_to(0, 0, 5, 0.0),
    ):  # fmt: skip
        with pytest.raises(InputError):
            command()


def test_over_a_house_is_no_collision_and_no_bad_start(yard):
    flying = drone(World.from_map(yard), (-5.0, -5.0), altitude_m=20.0)
    assert flying.hover(seconds=0.5)


def test_it_speaks_as_the_vehicles_do(field):
    flying = drone(field)
    wanted = {n for n in dir(Vehicle) if not n.startswith("_")}
    assert wanted - set(dir(flying)) <= {"camera_image", "objects", "object_pose"}


def test_ramps_begin_and_end_at_rest():
    ramp = Ramp(2.0)
    assert ramp.at(0.0) == (0.0, 0.0, 0.0)
    assert ramp.at(2.0) == pytest.approx((1.0, 0.0, 0.0))
    assert ramp.at(3.0) == pytest.approx((1.0, 0.0, 0.0))
    times = np.linspace(0, 2, 2001)
    values, rates, _ = np.array([ramp.at(t) for t in times]).T
    assert np.gradient(values, times)[1:-1] == pytest.approx(rates[1:-1], abs=1e-4)
    assert line_time(15.0, 6.0) == pytest.approx(1.875 * 15 / 6, rel=0.3)
    assert turn_time(math.pi) > turn_time(1.0) > 0
