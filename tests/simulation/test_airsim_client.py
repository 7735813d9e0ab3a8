"""The environment on AirSim's client: flown against our server, by the official client too."""

from __future__ import annotations

import asyncio
import math
import socket
import sys
import threading

import numpy as np
import pytest

pytest.importorskip("msgpack", reason="the server needs msgpack, of sloop-ppl[sim]")

from bare_client import BareClient
from kinematic_vehicle import Box, KinematicVehicle
from serving import served

from sloop_ppl.errors import InputError, OutsideMap
from sloop_ppl.maps import CityMap, Grid
from sloop_ppl.planning import Environment, Pose, SearchConfig, SearchSpace, run_search
from sloop_ppl.simulation import AirSimEnvironment, connect

GRID = Grid(-52.5, -52.4, 52.4, 52.5)  # 21 x 21 cells, one of them around the origin
CAR = Box(8.5, -0.9, 12.5, 0.9, 1.5)
HOUSE = Box(-30, -10, -20, 10, 20)
CONFIG = SearchConfig(true_positive_rate=0.9, position_noise_cells=0.5)
SPACE = SearchSpace(GRID, ("RedCar",), CONFIG)
FORWARD, LEFT, RIGHT, FIND = SPACE.actions


def vehicle_at(x, y, yaw=0.0, **options):
    boxes = {"House": HOUSE, "RedCar": CAR}
    return KinematicVehicle(boxes, start=(x, y, 0.0, yaw), **options)


@pytest.fixture(params=["bare", "official"])
def client_of(request):
    """Make clients, of our own few lines or of the official package, and hang up afterwards."""
    made = []

    def make(server):
        if request.param == "bare":
            made.append(BareClient(server.port))
        else:
            made.append(connect(port=server.port))
        return made[-1]

    yield make
    for client in made:
        client.raw.close() if request.param == "bare" else client.client.close()


def test_it_is_an_environment_that_takes_off_and_lands(client_of):
    vehicle = vehicle_at(1.0, 2.0, yaw=math.pi / 2)
    with served(vehicle) as server:
        environment = AirSimEnvironment(client_of(server), SPACE, altitude_m=14)
        assert isinstance(environment, Environment)
        assert vehicle.pose == pytest.approx((1.0, 2.0, 14.0, math.pi / 2))
        assert environment.pose == pytest.approx((1.0, 2.0, math.pi / 2))
        environment.land()
        assert vehicle.pose.z_m == pytest.approx(0)


def test_moves_go_from_the_middle_of_the_cell_to_the_middle_of_the_next(client_of):
    with served(vehicle := vehicle_at(1.0, 2.0)) as server:
        environment = AirSimEnvironment(client_of(server), SPACE, start=Pose(-1.0, 1.0, 0.0))
        outcome = environment.execute(FORWARD)
        assert outcome.pose == pytest.approx((15.0, 0.0, 0.0))
        assert not outcome.collision
        assert environment.execute(LEFT).pose == pytest.approx((15.0, 0.0, math.pi / 4))
        # On a diagonal two cells each way, as the planner has it.
        assert environment.execute(FORWARD).pose == pytest.approx((25.0, 10.0, math.pi / 4))
        assert environment.execute(RIGHT).pose == pytest.approx((25.0, 10.0, 0.0))
        assert environment.execute(FORWARD).pose == pytest.approx((40.0, 10.0, 0.0))
        flown = len(vehicle.flown)
        # Fifteen metres on is off the map: not flown.
        assert environment.execute(FORWARD).pose == pytest.approx((40.0, 10.0, 0.0))
        assert len(vehicle.flown) == flown


def test_what_is_seen_lies_on_the_map_where_it_is(client_of):
    with served(vehicle_at(0.0, 0.0, size=(320, 240))) as server:
        environment = AirSimEnvironment(client_of(server), SPACE)
        # Nothing is found before the first look.
        assert environment.execute(FIND).report.found == ()
        environment.execute(LEFT)
        outcome = environment.execute(RIGHT)
        assert outcome.report.seen["RedCar"] == pytest.approx((10.5, 0.0), abs=0.7)
        assert environment.execute(FIND).report.found == ("RedCar",)
        # It is searched for no longer.
        assert environment.execute(LEFT).report.seen == {}
        assert environment.execute(FIND).report.found == ()


def test_a_degree_off_does_not_lose_what_stands_on_the_border_of_the_fan(client_of):
    # The car's cell is 10 m ahead and 10 m to the left: on the border of 90 degrees.
    bias = (0.3, 0.2, math.radians(1))
    with served(vehicle_at(0.0, -10.0, bias=bias, size=(320, 240))) as server:
        environment = AirSimEnvironment(client_of(server), SPACE, start=Pose(0.0, -10.0, 0.0))
        environment.execute(LEFT)
        environment.execute(RIGHT)
        assert environment.execute(FIND).report.found == ("RedCar",)


def test_what_is_seen_is_laid_out_from_where_the_drone_believes_to_be(client_of):
    # It believes to be 2 m east of the truth, steers by that, and sees the car as far off.
    vehicle = vehicle_at(0.0, 0.0, bias=(2.0, 0.0, 0.0), size=(320, 240))
    with served(vehicle) as server:
        environment = AirSimEnvironment(client_of(server), SPACE, start=Pose(0.0, 0.0, 0.0))
        environment.execute(LEFT)
        outcome = environment.execute(RIGHT)
        assert outcome.pose[:2] == pytest.approx((0.0, 0.0), abs=1e-6)
        assert vehicle.pose.x_m == pytest.approx(-2.0)
        assert outcome.report.seen["RedCar"] == pytest.approx((12.5, 0.0), abs=0.8)


def test_what_the_planner_holds_out_of_view_is_not_reported(client_of):
    near = SearchSpace(GRID, ("RedCar",), SearchConfig(sensor_range_cells=1))
    with served(vehicle_at(0.0, 0.0)) as server:
        environment = AirSimEnvironment(client_of(server), near)
        environment.execute(LEFT)
        assert environment.execute(RIGHT).report.seen == {"RedCar": None}


def test_what_stands_behind_a_house_is_not_seen(client_of):
    boxes = {"House": Box(4, -8, 6, 8, 12), "RedCar": CAR}
    vehicle = KinematicVehicle(boxes, start=(0.0, 0.0, 0.0, 0.0))
    with served(vehicle) as server:
        environment = AirSimEnvironment(client_of(server), SPACE)
        environment.execute(LEFT)
        assert environment.execute(RIGHT).report.seen == {"RedCar": None}


def test_a_house_in_the_way_is_a_collision_and_the_drone_stays_before_it(client_of):
    with served(vehicle_at(-10.0, 0.0, yaw=math.pi)) as server:
        environment = AirSimEnvironment(client_of(server), SPACE)
        outcome = environment.execute(FORWARD)
        assert outcome.collision
        assert outcome.pose.x_m == pytest.approx(-20.0, abs=0.2)
        # It turns away without another one.
        assert not environment.execute(LEFT).collision


def test_a_drone_that_believes_to_be_off_the_map_is_on_its_border(client_of):
    with served(vehicle_at(50.0, 0.0, bias=(9.0, 0.0, 0.0))) as server:
        environment = AirSimEnvironment(client_of(server), SPACE)
        assert environment.pose.x_m == pytest.approx(52.5, abs=0.01)
        SPACE.snap(environment.pose)


def test_coordinates_of_the_simulator_may_begin_elsewhere(client_of):
    origin = (7.0, -3.0, 0.5)
    with served(vehicle := vehicle_at(0.0, 0.0, size=(320, 240)), origin_m=origin) as server:
        environment = AirSimEnvironment(client_of(server), SPACE, origin_m=origin)
        environment.execute(LEFT)
        outcome = environment.execute(RIGHT)
        assert vehicle.pose.z_m == pytest.approx(14.0)
        assert outcome.report.seen["RedCar"] == pytest.approx((10.5, 0.0), abs=0.7)


@pytest.mark.parametrize("bias", [(0.0, 0.0, 0.0), (1.0, -0.5, 0.05)])
def test_a_whole_search_finds_its_car(client_of, bias):
    city = CityMap("yard", GRID, ())
    x, y = np.meshgrid(GRID.x_m, GRID.y_m)
    beliefs = {"RedCar": np.exp(-np.hypot(x - 5, y - 5) / 15)}
    with served(vehicle_at(-30.0, -30.0, bias=bias)) as server:
        environment = AirSimEnvironment(
            client_of(server), SPACE, start=Pose(-30.0, -30.0, 0.0), speed_m_s=10.0
        )
        episode = run_search(
            beliefs,
            city,
            {"RedCar": (10.5, 0.0)},
            environment=environment,
            config=CONFIG,
            planner="greedy",
            rng=np.random.default_rng(0),
        )
    assert episode.found
    assert episode.steps < 40


# Mistakes: each is one line.


def refused(call, kind=InputError):
    with pytest.raises(kind) as told:
        call()
    assert "\n" not in str(told.value)
    return str(told.value)


def test_a_target_that_the_simulator_does_not_have(client_of):
    space = SearchSpace(GRID, ("RedCar", "RedBike"), SearchConfig())
    with served(vehicle_at(0.0, 0.0)) as server:
        client = client_of(server)
        said = refused(lambda: AirSimEnvironment(client, space))
        assert said == (
            "Object of target RedBike in AirSim 'RedBike' is unknown; expected one of House, RedCar"
        )
        AirSimEnvironment(client, space, {"RedBike": "House"})


def test_a_start_off_the_map_and_a_height_that_is_none(client_of):
    with served(vehicle_at(0.0, 0.0)) as server:
        client = client_of(server)
        refused(lambda: AirSimEnvironment(client, SPACE, start=Pose(99.0, 0.0)), OutsideMap)
        said = refused(lambda: AirSimEnvironment(client, SPACE, altitude_m=-3))
        assert said == "altitude_m is -3; expected a positive number"


def test_a_drone_that_does_not_take_off(client_of):
    vehicle = vehicle_at(0.0, 0.0)
    vehicle.take_off = lambda stop=None: False
    with served(vehicle) as server:
        client = client_of(server)
        assert "did not take off" in refused(lambda: AirSimEnvironment(client, SPACE))


def test_a_running_event_loop_is_told(client_of):
    with served(vehicle_at(0.0, 0.0)) as server:
        environment = AirSimEnvironment(client_of(server), SPACE)

        async def cell():
            return refused(lambda: environment.execute(LEFT))

        # A loop of its own, since the official client keeps the thread's.
        loop = asyncio.new_event_loop()
        try:
            said = []
            worker = threading.Thread(target=lambda: said.append(loop.run_until_complete(cell())))
            worker.start()
            worker.join()
        finally:
            loop.close()
        assert "an event loop is running in this thread" in said[0]


def test_a_simulator_that_goes_away_is_told():
    with served(vehicle_at(0.0, 0.0)) as server:
        client = BareClient(server.port)
        environment = AirSimEnvironment(client, SPACE)
        client.simGetCollisionInfo = lambda: (_ for _ in ()).throw(gone())
        said = refused(lambda: environment.execute(LEFT))
        assert said.startswith("AirSim did not carry out a call: Retry connection over the limit")
        client.raw.close()


def gone():
    from bare_client import RPCError

    return RPCError("Retry connection over the limit")


def test_a_missing_client_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "cosysairsim", None)
    assert refused(connect) == (
        "AirSim's client is not installed; expected pip install 'sloop-ppl[airsim]'"
    )


def test_no_server_at_the_address_is_told():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    said = refused(lambda: connect(port=port))
    assert said.startswith(f"No AirSim at 127.0.0.1:{port} (")
    assert said.endswith("expected an AirSim that runs, or sloop fly --serve PORT")


@pytest.mark.parametrize("answer", [b"HTTP/1.1 400 Bad Request\r\n\r\n", b""])
def test_a_server_of_something_else_is_told(answer):
    with socket.create_server(("127.0.0.1", 0)) as other:

        def talk():
            connection, _ = other.accept()
            with connection:
                connection.recv(100)
                connection.sendall(answer)

        thread = threading.Thread(target=talk)
        thread.start()
        port = other.getsockname()[1]
        said = refused(lambda: connect(port=port))
        thread.join()
    assert said.startswith(f"What listens at 127.0.0.1:{port} is no AirSim")


def test_connecting_inside_an_event_loop_is_told():
    async def cell():
        return refused(connect)

    assert "an event loop is running in this thread" in asyncio.run(cell())


def test_our_colours_are_the_head_of_the_clients():
    import cosysairsim

    from sloop_ppl.simulation._airsim_colours import object_colours

    colours = object_colours()
    np.testing.assert_array_equal(cosysairsim.load_colormap()[: len(colours)], colours)


def test_the_official_client_confirms_the_connection(capsys):
    with served(vehicle_at(0.0, 0.0)) as server:
        client = connect(port=server.port)
        client.confirmConnection()
        client.client.close()
    assert "Connected!" in capsys.readouterr().out
