"""Fields are computed once for the same content, and memory stays within its budget."""

import gc
import pickle
import tracemalloc

import numpy as np
import shapely

from sloop_ppl.maps import CityMap, Grid, Landmark, load_map
from sloop_ppl.maps._cache import BoundedCache
from sloop_ppl.maps.city import FIELDS


def test_what_was_used_longest_ago_is_forgotten():
    made = []
    cache = BoundedCache(100)

    def get(name):
        return cache.get(name, lambda: made.append(name) or name, 40)

    for name in "abacab":
        assert get(name) == name
    assert made == ["a", "b", "c", "b"]  # "a" was used again before "c" came
    assert (len(cache), cache.used_bytes) == (2, 80)


def test_one_entry_may_be_larger_than_the_budget():
    cache = BoundedCache(10)
    assert cache.get("a", lambda: 1, 50) == 1
    assert len(cache) == 1
    cache.clear()
    assert (len(cache), cache.used_bytes) == (0, 0)


def test_fields_are_shared_by_maps_of_the_same_content():
    first, second = load_map("cleveland"), load_map("cleveland")
    assert first.fields("VelvetDog") is second.fields("VelvetDog")
    assert first.fields("VelvetDog") is not first.with_grid(Grid.square(100.0, 4.0)).fields(
        "VelvetDog"
    )


def test_maps_of_other_content_share_nothing():
    def city(box):
        return CityMap("m", Grid.square(20.0), (Landmark("A", "building", shapely.box(*box)),))

    one, other = city((0, 0, 5, 5)), city((0, 0, 5, 6))
    assert one.fields("A") is not other.fields("A")
    assert one.fields("A") is city((0, 0, 5, 5)).fields("A")


def test_a_large_map_takes_memory_only_for_what_is_asked():
    FIELDS.clear()
    grid = Grid.square(2500.0)
    assert grid.shape == (1001, 1001)
    lots = [
        Landmark(f"B{i}", "building", shapely.box(i, i, i + 20, i + 20)) for i in range(0, 2000, 2)
    ]
    gc.collect()
    tracemalloc.start()
    city = CityMap("large", grid, tuple(lots))
    city.nearest(3.0, 4.0, city.landmarks)
    assert tracemalloc.get_traced_memory()[0] < 10e6
    for landmark in lots[:60]:
        city.cells(landmark.id)
    city.fields("B0").distance_m.sum()
    assert tracemalloc.get_traced_memory()[0] < 10e6 + 60 * grid.size + 18 * grid.size
    tracemalloc.stop()
    FIELDS.clear()


def test_the_budget_holds_on_a_large_map():
    FIELDS.clear()
    grid = Grid.square(2500.0)
    boxes = [Landmark(f"B{i}", "building", shapely.box(i, 0, i + 1, 1)) for i in range(30)]
    city = CityMap("large", grid, tuple(boxes))
    for landmark in boxes:
        city.fields(landmark.id)
    assert FIELDS.used_bytes <= FIELDS.budget_bytes
    assert len(FIELDS) < 30
    FIELDS.clear()


def test_a_map_survives_a_trip_to_another_process():
    city = load_map("austin")
    again = pickle.loads(pickle.dumps(city))
    assert again.digest == city.digest
    assert dict(again.properties) == dict(city.properties)
    assert np.array_equal(again.cells("LavacaSt"), city.cells("LavacaSt"))
    assert again.landmarks[0].properties == city.landmarks[0].properties
