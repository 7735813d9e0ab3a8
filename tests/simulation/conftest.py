from importlib.util import find_spec

import numpy as np
import pytest


@pytest.fixture(scope="session", autouse=True)
def simulator():
    """Skip where mujoco is not installed; not imported here, for the room says how to."""
    if find_spec("mujoco") is None:
        pytest.skip("the simulator needs mujoco")


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.fixture(scope="session")
def yard(simulator):
    """Return a small map: an L-shaped house, a low shed, a street and a park."""
    import shapely

    from sloop_ppl.maps import CityMap, Grid, Landmark

    corner = shapely.box(-20, -20, 20, 20) - shapely.box(0, 0, 20, 20)
    low = {"height": "4"}
    return CityMap(
        "yard",
        Grid.square(50.0),
        (
            Landmark("House", "building", corner, name="Long House"),
            Landmark("Shed", "building", shapely.box(30, 30, 38, 40), properties=low),
            Landmark("Lane", "street", shapely.LineString([(-50, -35), (50, -35)]), name="Lane"),
            Landmark("Green", "park", shapely.box(-48, 28, -25, 48)),
        ),
    )


@pytest.fixture(scope="session")
def rendering(simulator):
    """Skip where no picture can be made."""
    from sloop_ppl.simulation import Camera, Drone, World

    world = World.from_map(_nothing(), {"RedCar": (0.0, 0.0)}, parked=0)
    drone = Drone(world, (-10.0, 0.0), altitude_m=14.0, rng=np.random.default_rng(0))
    from sloop_ppl.errors import InputError

    try:
        with Camera(world, drone, width=16, height=16) as camera:
            camera.picture()
    except InputError as error:
        pytest.skip(str(error))


def _nothing():
    from sloop_ppl.maps import CityMap, Grid

    return CityMap("nothing", Grid.square(50.0), ())
