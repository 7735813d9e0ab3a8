"""The server, asked in bare msgpack-rpc: frames, threads, order, and what it refuses."""

from __future__ import annotations

import io
import math
import socket
import threading
import time

import numpy as np
import pytest

pytest.importorskip("msgpack", reason="the server needs msgpack, of sloop-ppl[sim]")

from kinematic_vehicle import Box, KinematicVehicle
from PIL import Image
from serving import RawClient, connected, served

from sloop_ppl.errors import InputError
from sloop_ppl.simulation import AirSimServer, Vehicle, serve
from sloop_ppl.simulation._airsim_colours import object_colours

HOUSE, CAR = Box(-5, 20, 5, 30, 8), Box(8, -1, 10, 1, 1.5)


@pytest.fixture
def vehicle():
    return KinematicVehicle({"House": HOUSE, "RedCar": CAR}, start=(3.0, -4.0, 0.0, 0.0))


def vector(answer):
    return [answer[k] for k in ("x_val", "y_val", "z_val")]


def test_the_stand_in_is_a_vehicle(vehicle):
    assert isinstance(vehicle, Vehicle)


def test_poses_are_north_east_and_down(vehicle):
    with served(vehicle, origin_m=(1.0, 1.0, 0.0)) as server, connected(server) as client:
        assert client.call("ping") is True
        assert client.call("takeoff", 20, "") is True
        pose = client.call("simGetVehiclePose", "")
        assert vector(pose["position"]) == pytest.approx([-5, 2, -3])
        # It faces east: 90 degrees clockwise from north.
        assert pose["orientation"]["w_val"] == pytest.approx(math.cos(math.pi / 4))
        assert pose["orientation"]["z_val"] == pytest.approx(math.sin(math.pi / 4))
        assert client.call("moveToPosition", 10, 20, -14, 50.0) is True
        assert vehicle.pose[:3] == pytest.approx((21, 11, 14))
        assert client.call("rotateToYaw", -90.0) is True
        assert vehicle.pose.yaw_rad == pytest.approx(math.pi)
        house = client.call("simGetObjectPose", "House", True)
        assert vector(house["position"]) == pytest.approx([24, -1, -4])
        nowhere = client.call("simGetObjectPose", "Hose", True)
        assert all(math.isnan(v) for v in vector(nowhere["position"]))
        assert client.call("land") is True
        assert vehicle.pose.z_m == pytest.approx(0)


def test_the_estimate_is_what_the_state_tells(vehicle):
    vehicle.bias = (2.0, 0.5, 0.0)
    with served(vehicle) as server, connected(server) as client:
        state = client.call("getMultirotorState", "")
        believed = vector(state["kinematics_estimated"]["position"])
        assert believed == pytest.approx([-3.5, 5, 0])
        assert vector(client.call("simGetVehiclePose", "")["position"]) == pytest.approx([-4, 3, 0])


def test_poses_are_answered_while_it_flies_and_in_another_thread(vehicle):
    vehicle.wait = lambda: time.sleep(0.001)
    with served(vehicle) as server, connected(server) as client:
        flight = client.send("moveToPosition", 0, 100, -14, 5.0)
        north = []
        while len(set(north)) < 3:
            north.append(client.call("simGetVehiclePose", "")["position"]["y_val"])
        assert north == sorted(north)
        client.call("cancelLastTask", "")
        assert client.receive(flight) == (None, False)
        assert vehicle.pose.x_m < 100
        client.call("simGetImages", [{"image_type": 0}])
    assert len(vehicle.threads) == 1
    assert threading.get_ident() not in vehicle.threads


def test_a_new_command_ends_the_one_before_and_the_last_one_wins(vehicle):
    vehicle.wait = lambda: time.sleep(0.001)
    with served(vehicle) as server, connected(server) as client:
        numbers = [client.send("moveToPosition", 0, x, -14, 5.0) for x in (500, 400)]
        last = client.send("moveToPosition", -4, 3.5, -1, 5.0)
        assert [client.receive(n) for n in numbers] == [(None, False)] * 2
        assert client.receive(last) == (None, True)
        assert vehicle.pose[:3] == pytest.approx((3.5, -4, 1))


def test_a_command_ends_when_its_time_is_up(vehicle):
    vehicle.wait = lambda: time.sleep(0.001)
    with served(vehicle) as server, connected(server) as client:
        assert client.call("moveToPosition", 0, 1e6, -14, 5.0, 0.1) is False


def test_each_collision_has_a_time_of_its_own(vehicle):
    with served(vehicle) as server, connected(server) as client:
        before = client.call("simGetCollisionInfo", "")
        assert (before["has_collided"], before["time_stamp"]) == (False, 0)
        stamps = []
        for _ in range(2):
            # The house is 8 m high and stands in the way north; the time is up before it is not.
            assert client.call("moveToPosition", 50, 3, -5, 20.0, 0.2) is False
            hit = client.call("simGetCollisionInfo", "")
            assert (hit["has_collided"], hit["object_name"]) == (True, "House")
            assert client.call("simGetCollisionInfo", "")["time_stamp"] == hit["time_stamp"]
            stamps.append(hit["time_stamp"])
        assert 0 < stamps[0] < stamps[1]
        assert client.call("moveToPosition", 0, 3, -5, 20.0) is True
        after = client.call("simGetCollisionInfo", "")
        assert (after["has_collided"], after["time_stamp"]) == (False, stamps[1])


@pytest.mark.parametrize("compress", [True, False])
def test_a_segmentation_has_the_colours_of_the_numbers(vehicle, compress):
    with served(vehicle) as server, connected(server) as client:
        client.call("moveToPosition", 0, -3, -10, 100.0)
        request = {"camera_name": "0", "image_type": 5, "compress": compress}
        (taken,) = client.call("simGetImages", [request], "")
        data, size = taken["image_data_uint8"], (taken["height"], taken["width"], 3)
        if compress:
            pixels = np.asarray(Image.open(io.BytesIO(data)))
        else:
            pixels = np.frombuffer(data, np.uint8).reshape(size)
        assert pixels.shape == size == (120, 160, 3)
        number = client.call("simGetSegmentationObjectID", "RedCar")
        assert client.call("simGetSegmentationObjectID", "NoCar") == -1
        seen = vehicle.camera_image("segmentation").pixels
        assert (seen == number + 1).sum() > 10
        colour = object_colours()[number]
        np.testing.assert_array_equal((pixels == colour).all(axis=2), seen == number + 1)
        assert client.call("simGetCameraInfo", "0", "")["fov"] == 90.0
        # The scene is not the segmentation.
        (scene,) = client.call("simGetImages", [{**request, "image_type": 0}], "")
        assert scene["image_data_uint8"] != data


def test_objects_are_listed_by_pattern(vehicle):
    with served(vehicle) as server, connected(server) as client:
        assert client.call("simListSceneObjects") == ["House", "RedCar"]
        assert client.call("simListSceneObjects", "Red.*") == ["RedCar"]


def test_no_two_objects_share_a_colour():
    colours = object_colours()
    assert len({tuple(c) for c in colours.tolist()} | {(0, 0, 0)}) == len(colours) + 1


@pytest.mark.parametrize(
    ("name", "arguments", "says"),
    [
        ("simSpawnObject", [], "'simSpawnObject' is not served; expected one of: ping, "),
        ("ping", [1, 2, 3], "ping was called with [1, 2, 3]"),
        ("moveToPosition", [0, math.nan, 0, 1], "no number to fly by"),
        ("moveToPosition", ["north", 0, 0, 1], "moveToPosition was called with"),
        ("simListSceneObjects", ["("], "simListSceneObjects was called with"),
        ("simGetImages", [[{"image_type": 7}], ""], "Pictures of type 7 are not served"),
    ],
)
def test_a_wrong_call_is_answered_in_one_line_and_the_next_one_is_served(
    vehicle, name, arguments, says
):
    with served(vehicle) as server, connected(server) as client:
        with pytest.raises(RuntimeError) as told:
            client.call(name, *arguments)
        assert says in str(told.value)
        assert "\n" not in str(told.value)
        assert client.call("ping") is True


def test_what_fails_in_the_vehicle_is_told_and_the_next_command_flies(vehicle, caplog):
    def fail(*_, **__):
        raise ZeroDivisionError("no battery")

    vehicle.take_off = fail
    with served(vehicle) as server, connected(server) as client:
        with pytest.raises(RuntimeError, match=r"takeoff failed: ZeroDivisionError: no battery"):
            client.call("takeoff")
        assert client.call("moveToPosition", 0, 3, -5, 20.0) is True


@pytest.mark.parametrize("junk", [b"\xc1", b"GET / HTTP/1.1\r\n\r\n", b"\x93\x00\x01\x02",
                                  b"\xc6\x7f\xff\xff\xff" + b"x" * 10])  # fmt: skip
def test_who_speaks_another_language_is_hung_up_on_alone(vehicle, junk):
    with served(vehicle) as server, connected(server) as other:
        stranger = RawClient(server.port)
        stranger.send_bytes(junk)
        if not junk.startswith(b"\xc6"):  # that one is only begun
            with pytest.raises(ConnectionError):
                stranger.receive(1)
        stranger.close()
        assert other.call("ping") is True


def test_closing_ends_a_flight_and_frees_the_port(vehicle):
    vehicle.wait = lambda: time.sleep(0.001)
    with served(vehicle) as server, connected(server) as client:
        client.send("moveToPosition", 0, 1e6, -14, 5.0)
        while vehicle.pose.z_m == 0:
            time.sleep(0.001)
        port = server.port
    with socket.socket() as again:
        again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        again.bind(("127.0.0.1", port))


def test_a_port_in_use_is_told_in_one_line(vehicle):
    with (
        served(vehicle) as server,
        pytest.raises(InputError, match="cannot be listened on") as told,
    ):
        serve(vehicle, server.port)
    assert str(told.value).startswith(f"Address 127.0.0.1:{server.port} ")


def test_what_is_no_vehicle_is_refused():
    with pytest.raises(InputError, match="The vehicle is a int; expected an object with"):
        AirSimServer(3)
