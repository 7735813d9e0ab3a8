"""Testing blocks before cells finds the cells that testing every cell finds."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.maps import Grid, touched_cells


def by_every_cell(grid, geometry):
    half = grid.cell_m / 2
    x, y = np.meshgrid(grid.x_m, grid.y_m)
    boxes = shapely.box(x - half, y - half, x + half, y + half)
    cells = shapely.intersects(geometry, boxes)
    if not cells.any():
        nearest = np.argmin(shapely.distance(geometry, shapely.points(x, y)))
        cells[np.unravel_index(nearest, grid.shape)] = True
    return cells


coordinate = st.floats(-150, 150) | st.integers(-30, 30).map(lambda n: 5.0 * n)
places = st.tuples(coordinate, coordinate)


@settings(max_examples=150, deadline=None)
@given(
    st.lists(places, min_size=3, max_size=8),
    st.sampled_from(["hull", "line", "ring"]),
    st.sampled_from([5.0, 2.0, 1.0]),
)
def test_blocks_find_what_cells_find(corners, shape, cell_m):
    grid = Grid(-100.0, -90.0, 101.0, 97.0, cell_m)
    geometry = {
        "hull": lambda: shapely.MultiPoint(corners).convex_hull,
        "line": lambda: shapely.LineString(corners),
        "ring": lambda: shapely.Point(corners[0]).buffer(70).difference(
            shapely.Point(corners[0]).buffer(50)
        ),
    }[shape]()  # fmt: skip
    if geometry.geom_type == "Point":
        return
    assert np.array_equal(touched_cells(grid, geometry), by_every_cell(grid, geometry))


def test_a_hole_larger_than_a_block_stays_empty():
    grid = Grid(0.0, 0.0, 999.0, 999.0, 1.0)
    ring = shapely.box(10, 10, 990, 990).difference(shapely.box(100, 100, 900, 900))
    cells = touched_cells(grid, ring)
    assert cells[50, 50]
    assert not cells[500, 500]
    assert cells.sum() == 982 * 982 - 798 * 798  # closed squares: one more ring of cells outside


@pytest.mark.parametrize(
    ("place", "cell"),
    [((500, 0), (20, 40)), ((1, -500), (0, 20)), ((-500, 500), (40, 0)), ((-500, -500), (0, 0))],
)
def test_what_is_outside_takes_the_nearest_cell(place, cell):
    grid = Grid.square(100.0)
    cells = touched_cells(grid, shapely.Point(place).buffer(3))
    assert np.argwhere(cells).tolist() == [list(cell)]
