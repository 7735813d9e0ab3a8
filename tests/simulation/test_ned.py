"""AirSim's frame and the map's: there and back, and what is known of compass and axes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sloop_ppl.simulation._ned import (
    NedFrame,
    map_yaw_rad,
    ned_yaw_deg,
    quaternion,
    rotation,
    yaw_pitch,
)

METRES = st.floats(-1e4, 1e4)
YAW = st.floats(-20.0, 20.0)
PITCH = st.floats(-1.5, 1.5)


@pytest.mark.parametrize(
    ("compass", "yaw_deg"), [(0, 90), (90, 0), (-90, 180), (180, 270), (45, 45), (-135, 225)]
)
def test_the_points_of_the_compass(compass, yaw_deg):
    assert math.degrees(map_yaw_rad(compass)) == pytest.approx(yaw_deg)
    turned = math.remainder(ned_yaw_deg(math.radians(yaw_deg)) - compass, 360)
    assert turned == pytest.approx(0, abs=1e-9)


def test_north_is_north_and_up_is_up():
    frame = NedFrame(10.0, 20.0, 1.0)
    assert frame.to_ned(10.0, 20.0, 1.0) == (0.0, 0.0, 0.0)
    assert frame.to_ned(10.0, 25.0, 1.0) == (5.0, 0.0, 0.0)
    assert frame.to_ned(13.0, 20.0, 1.0) == (0.0, 3.0, 0.0)
    assert frame.to_ned(10.0, 20.0, 8.0) == (0.0, 0.0, -7.0)


@given(METRES, METRES, METRES, METRES, METRES, METRES)
def test_places_come_back(x, y, z, east, north, up):
    frame = NedFrame(east, north, up)
    assert frame.to_map(*frame.to_ned(x, y, z)) == pytest.approx((x, y, z), abs=1e-8)


@given(METRES, METRES, METRES, METRES)
def test_distances_and_the_sense_of_angles_stay(x1, y1, x2, y2):
    # East x north is up, north x east is down: both frames are right-handed.
    frame = NedFrame(3.0, -4.0, 2.0)
    a, b = frame.to_ned(x1, y1, 0.0), frame.to_ned(x2, y2, 0.0)
    assert math.dist(a, b) == pytest.approx(math.dist((x1, y1), (x2, y2)), abs=1e-6)
    if math.dist(a, b) > 1e-3:
        bearing = math.degrees(math.atan2(b[1] - a[1], b[0] - a[0]))
        on_map = math.atan2(y2 - y1, x2 - x1)
        assert math.cos(map_yaw_rad(bearing) - on_map) == pytest.approx(1, abs=1e-6)


@given(YAW)
def test_headings_come_back(yaw):
    degrees, back = ned_yaw_deg(yaw), map_yaw_rad(ned_yaw_deg(yaw))
    assert -180 <= degrees <= 180
    assert 0 <= back < 2 * math.pi
    assert math.cos(back - yaw) == pytest.approx(1)


@given(YAW, PITCH)
def test_quaternions_tell_heading_and_pitch(yaw, pitch):
    found_yaw, found_pitch = yaw_pitch(quaternion(yaw, pitch))
    assert 0 <= found_yaw < 2 * math.pi
    assert math.cos(found_yaw - yaw) == pytest.approx(1, abs=1e-9)
    assert found_pitch == pytest.approx(pitch, abs=1e-6)


@given(st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: math.hypot(*q) > 0.1))
def test_axes_are_at_right_angles(q):
    axes = rotation(q)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-9)
    # forward, right, down are right-handed, and so are east, north, up.
    assert np.linalg.det(axes) == pytest.approx(1)


def test_a_camera_that_looks_north_and_down():
    forward, right, down = rotation(quaternion(math.pi / 2, -math.pi / 4)).T
    half = math.sqrt(0.5)
    np.testing.assert_allclose(forward, [0, half, -half], atol=1e-12)
    np.testing.assert_allclose(right, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(down, [0, -half, -half], atol=1e-12)
