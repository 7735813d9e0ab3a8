from __future__ import annotations

import math

import pytest
from plots_fakes import FakePosterior, Frame, Told, blob

from sloop_ppl.maps import CityMap, load_map


@pytest.fixture(scope="session")
def cleveland() -> CityMap:
    return load_map("cleveland")


@pytest.fixture(scope="session")
def posterior(cleveland: CityMap) -> FakePosterior:
    return FakePosterior(
        city=cleveland,
        beliefs={
            "GreenToyota": blob(cleveland, -42.5, -77.5, 9.0),
            "RedHonda": blob(cleveland, 62.5, 12.5, 14.0),
        },
        told={"GreenToyota": (Told("behind", ("VelvetDog",)),)},
        faces={"GreenToyota": (Frame("VelvetDog", "behind", math.radians(60), 6.0),)},
    )
