"""Cells a geometry touches: hand-drawn cases, and a brute-force test of every cell."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, MultiPoint, Point, Polygon, box

from sloop_ppl.maps import Grid, touched_cells

# Cells of 1 m; 5 x 5 lie inside, the sixth column and the southernmost row overhang.
GRID = Grid(0, 0, 5, 5, 1)


def drawn(geometry, grid=GRID):
    """Return the cells as lines of text, north at the top."""
    return [
        "".join("#" if cell else "." for cell in row) for row in touched_cells(grid, geometry)[::-1]
    ]


def test_a_polygon_inside_one_cell_takes_it():
    assert drawn(box(1.2, 1.2, 1.8, 1.8)) == [
        "......",
        "......",
        "......",
        ".#....",
        "......",
        "......",
    ]


def test_borders_count_as_touching():
    assert drawn(box(1, 1, 2, 2)) == [
        "......",
        "......",
        "###...",
        "###...",
        "###...",
        "......",
    ]


def test_a_hole_is_left_out_where_it_holds_a_whole_cell():
    ring = box(0.5, 0.5, 4.5, 4.5) - box(1.5, 1.5, 3.5, 3.5)
    assert drawn(ring) == [
        "#####.",
        "#####.",
        "##.##.",
        "#####.",
        "#####.",
        "......",
    ]


def test_a_line_takes_the_cells_it_crosses():
    assert drawn(LineString([(0.5, 0.4), (3.5, 2.6)])) == [
        "......",
        "......",
        "..##..",
        ".##...",
        "##....",
        "......",
    ]


def test_a_point_takes_the_one_cell_that_holds_it_even_on_a_border():
    # East and south of a border, as Grid.cell_at has it.
    assert drawn(Point(2, 3)) == ["......", "......", "..#...", "......", "......", "......"]
    assert touched_cells(GRID, Point(2, 3))[GRID.cell_at(2, 3)]


def test_several_points_take_several_cells():
    assert touched_cells(GRID, MultiPoint([(0.5, 0.5), (4.5, 4.5)])).sum() == 2


def test_a_geometry_reaching_over_the_border_takes_what_is_on_the_map():
    assert drawn(box(3.5, 3.5, 99, 99)) == [
        "...###",
        "...###",
        "......",
        "......",
        "......",
        "......",
    ]


@pytest.mark.parametrize(
    ("geometry", "row", "col"),
    [
        (Point(9, 2.5), 3, 5),
        (Point(-3, 9), 5, 0),
        (box(2.2, 20, 2.8, 21), 5, 2),
        (LineString([(-4, 0.2), (-4, 0.8)]), 1, 0),
    ],
)
def test_what_touches_no_cell_takes_the_nearest(geometry, row, col):
    cells = touched_cells(GRID, geometry)
    assert cells.sum() == 1
    assert cells[row, col]


coordinates = st.tuples(st.floats(-12, 62), st.floats(-12, 62))


@st.composite
def shapes(draw):
    kind = draw(st.sampled_from(["line", "hull", "frame", "disc"]))
    points = draw(st.lists(coordinates, min_size=2, max_size=6, unique=True))
    if kind == "line":
        return LineString(points)
    if kind == "disc":
        return Point(points[0]).buffer(draw(st.floats(0.1, 30)))
    hull = MultiPoint(points).convex_hull.buffer(0.5)
    if kind == "frame":
        return hull - hull.buffer(-draw(st.floats(0.1, 8)))
    return hull


@settings(max_examples=60, deadline=None)
@given(shapes(), st.sampled_from([(40, 60), (50, 50), (13, 29)]), st.sampled_from([0.7, 1.0, 2.5]))
def test_agrees_with_testing_every_cell(geometry, side, cell_m):
    grid = Grid(0, 0, *side, cell_m)
    cells = touched_cells(grid, geometry)
    expected = np.zeros(grid.shape, dtype=bool)
    close = np.zeros(grid.shape, dtype=bool)
    half = cell_m / 2
    for row in range(grid.n_rows):
        for col in range(grid.n_cols):
            x, y = grid.centre_of(row, col)
            square = box(x - half, y - half, x + half, y + half)
            distance = square.distance(geometry)
            expected[row, col] = distance == 0
            close[row, col] = distance < 1e-9
    if expected.any():
        # Rounding may decide either way where only corners or borders meet.
        assert not (cells & ~close).any()
        assert not (expected & ~close_to(cells, expected, grid, geometry)).any()
    else:
        assert cells.sum() == 1


def close_to(cells, expected, grid, geometry):
    """Return the cells taken, and those expected that the geometry hardly enters."""
    forgiven = cells.copy()
    for row, col in np.argwhere(expected & ~cells):
        x, y = grid.centre_of(row, col)
        inner = grid.cell_m / 2 - 1e-9
        forgiven[row, col] = not shapely.intersects(
            geometry, box(x - inner, y - inner, x + inner, y + inner)
        )
    return forgiven


def test_a_large_polygon_is_filled():
    grid = Grid.square(200, 1)
    cells = touched_cells(grid, Polygon([(-150, -150), (150, -150), (150, 150), (-150, 150)]))
    # 300 cells a side, and one more where each border is touched.
    assert cells.sum() == 302**2
