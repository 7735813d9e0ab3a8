"""The area in which targets are searched for."""

import json

import numpy as np
import pytest
import shapely

from sloop_ppl.errors import InputError
from sloop_ppl.maps import Grid, load_map, search_area

GRID = Grid.square(10, cell_m=5.0)  # 5 x 5 cells, columns from -10 on, centres from -7.5
WANTED = (
    "expected W,S,E,N in metres, @W,S,E,N in degrees, a polygon, or GeoJSON of one (a dict, or the "
    "path of a .geojson file)"
)


def cells(area, grid=GRID):
    return search_area(area, grid).cells.astype(int).tolist()


def test_a_cell_is_in_when_its_centre_is():
    # Columns have their centres at -7.5, -2.5, 2.5, 7.5, 12.5; rows, from the south, at -12.5 to
    # 7.5. A border that runs through a centre takes it.
    one_row = [0, 1, 1, 0, 0]
    found = cells((-2.5, -5, 4, 5))
    assert found == [[0] * 5, [0] * 5, one_row, one_row, [0] * 5]


def test_rectangle_text_polygon_and_geojson_are_one():
    box = shapely.box(-50, -40, 30.5, 60)
    city = load_map("cleveland")
    lon, lat = city.grid.to_lonlat(*np.array(box.exterior.coords).T)
    degrees = {"type": "Polygon", "coordinates": [np.column_stack([lon, lat]).tolist()]}
    metres = shapely.geometry.mapping(box)
    feature = {"type": "Feature", "properties": {}, "geometry": degrees}
    expected = cells((-50, -40, 30.5, 60), city.grid)
    for same in (
        "-50,-40,30.5,60",
        box,
        metres,
        degrees,
        feature,
        {"type": "FeatureCollection", "features": [feature]},
        search_area(box, city.grid),
    ):
        assert cells(same, city.grid) == expected


def test_a_file_and_parts_with_a_hole(tmp_path):
    ring = shapely.box(-10, -15, 15, 10).difference(shapely.box(-1, -4, 4, 1))
    path = tmp_path / "ring.geojson"
    path.write_text(json.dumps(shapely.geometry.mapping(ring)))
    found = search_area(str(path), GRID)
    assert found.n_cells == 24
    assert not found.cells[2, 2]
    assert search_area(path, GRID).n_cells == 24


def test_what_reaches_beyond_the_map_is_cut_off():
    assert search_area((-1e6, 0, 1e6, 1e6), GRID).n_cells == 10


def test_the_prior_is_normalised_in_the_area():
    area = search_area((-10, -5, -5, 5), GRID)  # two cells
    log_prior = np.log(np.arange(1, 26) / 325.0)
    inside = np.exp(area.log_restricted(log_prior)).reshape(GRID.shape)
    weights = np.array([11, 16])  # cells 10 and 15
    np.testing.assert_allclose(inside[area.cells], weights / weights.sum())
    assert inside.sum() == pytest.approx(1)
    nothing = np.where(area.cells.reshape(-1), -np.inf, 0.0)
    with pytest.raises(InputError) as error:
        area.log_restricted(nothing)
    assert str(error.value) == (
        "The prior is zero in all 2 cells of the area; expected a positive weight in one of them: "
        "give another prior or a larger area"
    )


@pytest.mark.parametrize(
    ("area", "message"),
    [
        (
            (50, 0, 60, 9),
            (
                "The area (50, 0, 60, 9) is outside the map; expected part of it within "
                "-10, -10, 10, 10 metres"
            ),
        ),
        (
            (5, 0, -5, 9),
            (
                "The area (5, 0, -5, 9) is empty or in another order; expected west, south, east, "
                "north with west < east and south < north"
            ),
        ),
        ((0, 0, 0, 9), "is empty or in another order"),
        ("0,0,inf,9", f"The area (0, 0, inf, 9) is not finite; {WANTED}"),
        ((0, 0, 1), f"The area has 3 numbers (0, 0, 1); {WANTED}"),
        (("a", "b"), f"The area is ('a', 'b'); {WANTED}"),
        (7, f"The area is a int; {WANTED}"),
        (
            (0, 0, 1, 1),
            (
                "The area (0, 0, 1, 1) holds no cell's centre; expected one larger than a cell of "
                "5 m"
            ),
        ),
        (shapely.Point(0, 0), "The area is a Point; expected a polygon with an area"),
        (shapely.Polygon(), "The area is empty; expected a polygon with an area"),
        (
            shapely.Polygon([(0, 0), (5, 5), (5, 0), (0, 5)]),
            (
                "The area is no sound polygon (Self-intersection[2.5 2.5]); expected an outline "
                "that does not cross itself"
            ),
        ),
        ({"type": "Feature"}, "The area is no GeoJSON of a polygon"),
        (
            {"type": "FeatureCollection", "features": []},
            "The area holds no geometry; expected GeoJSON of a polygon",
        ),
        ({"type": "Polygon", "coordinates": [[["a", 0], [1, 1], [2, 0]]]}, "no GeoJSON"),
        (
            "none.geojson",
            f"Area 'none.geojson' cannot be read: No such file or directory; {WANTED}",
        ),
    ],
)
def test_bad_areas_are_refused_in_one_line(area, message):
    with pytest.raises(InputError) as error:
        search_area(area, GRID)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_no_geojson(tmp_path):
    path = tmp_path / "area.geojson"
    path.write_text("{")
    with pytest.raises(InputError, match="is not JSON"):
        search_area(path, GRID)
    path.write_text("[1]")
    with pytest.raises(InputError, match="holds a list; expected a GeoJSON object"):
        search_area(path, GRID)
