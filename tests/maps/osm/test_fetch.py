"""What osmnx brings becomes a map; what it raises becomes one line. No network is asked."""

import sys
import types

import pytest
import shapely
from support.osm_block import CENTRE, FRAME

from sloop_ppl.errors import InputError, MapError
from sloop_ppl.maps.osm import fetch_place


class Table:
    """What a GeoDataFrame of osmnx shows: rows by (element, id), one column a tag."""

    def __init__(self, rows):
        self.rows = rows

    def __len__(self):
        return len(self.rows)

    def iterrows(self):
        return iter(self.rows)


class Row(dict):
    @property
    def geometry(self):
        return self["geometry"]


def at(geometry):
    return shapely.transform(geometry, lambda p: [FRAME.to_lonlat(x, y) for x, y in p])


@pytest.fixture
def osmnx(monkeypatch):
    rows = [
        (("way", 10), Row(highway="residential", name="Main Street", building=float("nan"),
                          geometry=at(shapely.LineString([(-90, -20), (90, -20)])))),
        (("way", 20), Row(building="yes", name=float("nan"), highway=None,
                          geometry=at(shapely.box(-10, -10, 10, 10)))),
        (("node", 30), Row(amenity="cafe", name="Joe's", geometry=at(shapely.Point(0, 0)))),
    ]  # fmt: skip
    fake = types.ModuleType("osmnx")
    fake.settings = types.SimpleNamespace(use_cache=True)
    fake.geocode = lambda place: CENTRE
    fake.features_from_bbox = lambda bounds, tags: Table(rows)
    monkeypatch.setitem(sys.modules, "osmnx", fake)
    return fake


def test_a_place_becomes_a_map(osmnx):
    told = []
    town, report = fetch_place("Union Square, Anywhere", side_m=100.0, progress=told.append)
    assert town.name == "union_square"
    assert [m.id for m in town.landmarks] == ["Building1", "MainSt", "Joes"]
    assert town.landmark("Joes").within == "Building1"
    assert town.grid.shape == (21, 21)
    assert report.kept == {"building": 1, "street": 1, "poi": 1}
    assert told[:2] == ["searching for Union Square, Anywhere", "fetching what is there"]
    assert osmnx.settings.use_cache is False


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (
            ConnectionError("HTTPSConnectionPool:\nMax retries exceeded"),
            (
                "Place 'A' cannot be fetched: there is no network; where there is none, bring an "
                ".osm or .osm.pbf file and use `sloop map import`"
            ),
        ),
        (
            type("InsufficientResponseError", (ValueError,), {})("nothing"),
            "OpenStreetMap knows no place 'A', or nothing there; spell it another way",
        ),
        (
            RuntimeError("server is\nbusy"),
            (
                "Place 'A' cannot be fetched: RuntimeError: server is busy; where there is none, "
                "bring an .osm or .osm.pbf file and use `sloop map import`"
            ),
        ),
    ],
)
def test_what_goes_wrong_is_one_line(osmnx, error, message):
    def fails(_):
        raise error

    osmnx.geocode = fails
    with pytest.raises(MapError) as caught:
        fetch_place("A")
    assert str(caught.value) == message


def test_nothing_there(osmnx):
    osmnx.features_from_bbox = lambda bounds, tags: Table([])
    with pytest.raises(MapError, match="There is nothing to map round 'A'; choose another place"):
        fetch_place("A")


def test_osmnx_is_an_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "osmnx", None)
    with pytest.raises(InputError, match=r"run pip install 'sloop-ppl\[fetch\]'"):
        fetch_place("A")


def test_what_is_asked_is_checked_before_the_network(osmnx):
    with pytest.raises(InputError, match="The place is empty"):
        fetch_place("  ")
    with pytest.raises(InputError, match="side_m is -1"):
        fetch_place("A", side_m=-1)
