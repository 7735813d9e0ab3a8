"""The drone of the MuJoCo world behind AirSim's calls: it flies, hits and sees as they say."""

from __future__ import annotations

import importlib.util
import threading
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("msgpack", reason="the server needs msgpack, of sloop-ppl[sim]")

from bare_client import BareClient
from serving import connected, served

from sloop_ppl.maps import load_map
from sloop_ppl.planning import Pose, SearchConfig, SearchSpace
from sloop_ppl.simulation import AirSimEnvironment, ServedDrone, Vehicle, VehiclePose

CAR = (-17.5, 52.5)


def test_it_is_a_vehicle():
    world = SimpleNamespace(
        object_names=lambda: ("RedCar", "Parked1", "CornerStore"), places={"RedCar": CAR},
        parked={"Parked1": (1.0, 2.0)}, headings_rad={"RedCar": 0.5, "Parked1": 1.0},
        city=load_map("suburb"),
    )  # fmt: skip
    drone = SimpleNamespace(
        pose=(1.0, 2.0, 3.0, 0.5), estimated_pose=(1.5, 2.0, 3.0, 0.5), collision="Tree"
    )
    served_drone = ServedDrone(SimpleNamespace(world=world, drone=drone))
    assert isinstance(served_drone, Vehicle)
    assert served_drone.pose == VehiclePose(1.0, 2.0, 3.0, 0.5)
    assert served_drone.estimated_pose.x_m == 1.5
    assert served_drone.collision == "Tree"
    assert served_drone.object_pose("RedCar") == (*CAR, 0.0, 0.5)
    assert served_drone.object_pose("Parked1") == (1.0, 2.0, 0.0, 1.0)
    assert served_drone.object_pose("CornerStore") == pytest.approx((18.0, -17.0, 0.0, 0.0))


@pytest.fixture
def flown():
    """Give what makes a drone on the suburb; it is made in the thread that flies it."""
    if importlib.util.find_spec("sloop_ppl.simulation.world") is None:
        pytest.skip("there is no MuJoCo world here")
    from sloop_ppl.simulation.camera import Camera
    from sloop_ppl.simulation.drone import Drone
    from sloop_ppl.simulation.world import World

    world = World.from_map(load_map("suburb"), {"RedCar": CAR}, parked=0)

    def make(*start):
        drone = Drone(world, start, altitude_m=0, rng=np.random.default_rng(0))
        return ServedDrone(Camera(world, drone))

    return make


def test_it_flies_and_hits_what_stands_in_the_way(flown):
    drone = flown(0.0, 45.0)
    with served(drone) as server, connected(server) as client:
        assert client.call("takeoff") is True
        assert client.call("moveToPosition", 45, 0, -5, 5.0) is True
        assert drone.pose[:3] == pytest.approx((0, 45, 5), abs=1.0)
        before = client.call("simGetCollisionInfo")
        # Ben's House, 11.5 m high, stands between here and Main Street.
        assert client.call("moveToPosition", 0, 0, -5, 5.0) is False
        hit = client.call("simGetCollisionInfo")
        assert hit["time_stamp"] != before["time_stamp"]
        assert drone.pose.y_m > 20
        assert client.call("simGetObjectPose", "BensHouseBuilding")["position"]["x_val"] > 10


def test_its_camera_sees_the_car(flown):
    from sloop_ppl.simulation._mujoco import rendering_fault

    if fault := rendering_fault():
        pytest.skip(f"no pictures here: {fault}")
    drone = flown(-25.0, 47.5)
    space = SearchSpace(load_map("suburb").grid, ("RedCar",), SearchConfig())
    with served(drone) as server:
        client = BareClient(server.port)
        environment = AirSimEnvironment(client, space, start=Pose(-27.5, 52.5, 0.0))
        environment.execute(space.actions[1])
        outcome = environment.execute(space.actions[2])
        client.raw.close()
        # The renderer belongs to the thread that flies.
        closed = threading.Event()
        server._later(lambda: (drone._camera.close(), closed.set()))
        assert closed.wait(10)
    assert outcome.report.seen["RedCar"] == pytest.approx(CAR, abs=1.0)
