from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sloop_ppl.planning import fan_offsets


def test_the_default_fan_facing_east_is_the_one_drawn_by_hand():
    assert fan_offsets(0, 3) == (
        (-2, 2),
        (-1, 1),
        (-1, 2),
        (0, 1),
        (0, 2),
        (0, 3),
        (1, 1),
        (1, 2),
        (2, 2),
    )


def test_the_robots_own_cell_is_seen_only_without_a_least_range():
    assert (0, 0) not in fan_offsets(0, 3)
    assert (0, 0) in fan_offsets(0, 3, min_range_cells=0)


@given(st.integers(0, 7), st.floats(1, 6), st.sampled_from([20.0, 45.0, 90.0, 180.0, 360.0]))
def test_a_quarter_turn_turns_the_fan(heading, reach, fov):
    turned = {(col, -row) for row, col in fan_offsets(heading, reach, fov_deg=fov)}
    assert turned == set(fan_offsets((heading + 2) % 8, reach, fov_deg=fov))


@given(st.integers(0, 7), st.floats(1, 6))
def test_the_fan_mirrors_left_and_right(heading, reach):
    mirrored = {(-row, col) for row, col in fan_offsets(heading, reach)}
    assert mirrored == set(fan_offsets(-heading % 8, reach))


@pytest.mark.parametrize("heading", range(8))
def test_a_full_circle_sees_the_disc(heading):
    disc = {(r, c) for r in range(-4, 5) for c in range(-4, 5) if 1 <= math.hypot(r, c) <= 4}
    assert set(fan_offsets(heading, 4, fov_deg=360)) == disc
