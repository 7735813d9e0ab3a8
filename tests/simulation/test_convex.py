"""Footprints and their convex pieces: the same points, no overlap, each convex."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sloop_ppl.maps import bundled_maps, load_map
from sloop_ppl.simulation._convex import convex_pieces


def check(footprint):
    rings = convex_pieces(footprint)
    pieces = [shapely.Polygon(r) for r in rings]
    for piece in pieces:
        assert piece.exterior.is_ccw
        assert piece.convex_hull.area == pytest.approx(piece.area, rel=1e-6, abs=1e-6)
    together = shapely.union_all(pieces)
    assert sum(p.area for p in pieces) == pytest.approx(together.area, abs=1e-2)
    assert shapely.area(together.symmetric_difference(footprint)) < 1e-2
    return rings


@pytest.mark.parametrize("name", bundled_maps())
def test_houses_are_the_union_of_their_pieces(name):
    for building in load_map(name).of_kind("building"):
        check(building.geometry)


def test_a_square_is_one_piece_and_an_l_two():
    assert len(check(shapely.box(0, 0, 3, 2))) == 1
    assert len(check(shapely.box(0, 0, 4, 4) - shapely.box(2, 2, 4, 4))) == 2


def test_courtyards_stay_open():
    ring = shapely.box(0, 0, 9, 9) - shapely.box(3, 3, 6, 6)
    rings = check(ring)
    assert 4 <= len(rings) <= 8
    yard = shapely.Point(4.5, 4.5)
    assert not any(shapely.Polygon(r).contains(yard) for r in rings)


def test_several_parts_and_lines():
    both = shapely.union_all([shapely.box(0, 0, 1, 1), shapely.box(5, 5, 7, 6)])
    assert len(check(both)) == 2
    assert convex_pieces(shapely.LineString([(0, 0), (1, 1)])) == []


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.floats(1, 10), st.floats(0, 1)), min_size=3, max_size=9),
)
def test_any_star_is_the_union_of_its_pieces(spokes):
    turns = np.sort([a for _, a in spokes]) * 2 * np.pi
    radii = [r for r, _ in spokes]
    star = shapely.Polygon(np.column_stack([radii * np.cos(turns), radii * np.sin(turns)]))
    if star.is_valid and star.area > 0.1:
        check(star)
