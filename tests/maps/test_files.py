"""A map file is written whole or not at all."""

import math
import os

import pytest

from sloop_ppl.errors import InputError, MapError, OutputError
from sloop_ppl.maps import CityMap, Grid, check_map_path, load_map, read_map, write_map
from sloop_ppl.maps.files import replace_file


def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "city.geojson"
    write_map(load_map("austin"), path)
    before = path.read_bytes()

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"cannot be written: .*No space left on device"):
        write_map(load_map("denver"), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["city.geojson"]


def test_a_write_that_is_interrupted_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "city.geojson"
    path.write_text("old")

    def stop(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", stop)
    with pytest.raises(KeyboardInterrupt):
        write_map(load_map("denver"), path)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["city.geojson"]


def test_what_json_cannot_say_is_refused_before_the_file_is_touched(tmp_path):
    path = tmp_path / "city.geojson"
    path.write_text("old")
    for value in (math.nan, {1, 2}, "\ud800"):
        city = CityMap("m", Grid.square(10.0, centre=(1.0, 2.0)), (), properties={"x": value})
        with pytest.raises(MapError, match=r"^Map 'm' cannot be written as JSON: "):
            write_map(city, path)
    assert path.read_text() == "old"


def test_the_mode_of_a_file_stays(tmp_path):
    path = tmp_path / "city.geojson"
    replace_file(path, b"one")
    path.chmod(0o640)
    replace_file(path, b"two")
    assert path.stat().st_mode & 0o777 == 0o640
    assert path.read_bytes() == b"two"


def test_paths_are_checked_before_the_work(tmp_path):
    assert check_map_path(tmp_path / "a.geojson") == tmp_path / "a.geojson"
    with pytest.raises(InputError, match=r"'a.txt' is no path for a map; expected one that ends"):
        check_map_path("a.txt")
    with pytest.raises(OutputError, match=r"folder '.*none' does not exist; make it first$"):
        check_map_path(tmp_path / "none" / "a.json")
    (tmp_path / "b.json").mkdir()
    with pytest.raises(OutputError, match=r"is a folder; give the name of a file$"):
        check_map_path(tmp_path / "b.json")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe\x00", "no text in UTF-8 (byte 1)"),
        (b"", "is not JSON: Expecting value"),
        (b"[" * 100_000, "is not JSON: "),
        (b"[1, 2]", "field 'type' is None"),
        (b"1" * 5000, "is not JSON: "),
        (b'{"name": "\\ud800"}', "half a character"),
    ],
)
def test_files_that_are_no_maps(tmp_path, content, message):
    path = tmp_path / "a.geojson"
    path.write_bytes(content)
    with pytest.raises(MapError) as caught:
        read_map(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_path_that_is_no_path():
    with pytest.raises(MapError, match="cannot be read"):
        read_map("a\0b.geojson")
