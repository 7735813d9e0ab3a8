from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from plots_fakes import blob, short_search

from sloop_ppl.errors import InputError
from sloop_ppl.maps import CityMap
from sloop_ppl.plots import plot_search
from sloop_ppl.plots._palette import ACCENTS
from sloop_ppl.plots._robot import robot_path, seen_image, sparse_steps
from sloop_ppl.plots.search import along, outcome, together


def told(ax) -> list[str]:
    legend = ax.get_legend()
    return [t.get_text() for t in legend.get_texts()]


def test_the_legend_names_what_is_drawn_and_no_more(cleveland: CityMap) -> None:
    ax = plot_search(short_search(cleveland), cleveland, ax=Figure().add_subplot())
    assert told(ax) == [
        "start",
        "path",
        "end",
        "target, found",
        "target, not found",
        "find: right",
        "find: wrong",
        "seen",
    ]


def test_imagined_places_and_beliefs_are_told_apart(cleveland: CityMap) -> None:
    ax = plot_search(
        short_search(cleveland),
        cleveland,
        ax=Figure().add_subplot(),
        imagined=("Hat",),
        beliefs={"Cup": blob(cleveland, 0, 0, 10)},
    )
    assert "target, not found (imagined)" in told(ax)
    assert told(ax)[-1] == "believed"


def test_each_find_is_marked_right_or_wrong_at_its_pose(cleveland: CityMap) -> None:
    ax = plot_search(short_search(cleveland), cleveland, ax=Figure().add_subplot())
    marks = {
        a.get_gid(): a.get_xydata()[0].tolist()
        for a in ax.lines
        if str(a.get_gid()).startswith("find")
    }
    assert marks == {"find-wrong": [-25.0, 2.5], "find-right": [-10.0, 2.5]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({}, "Found Cup but not Hat in 5 steps, discounted return −12"),
        ({"found_targets": ()}, "Found nothing in 5 steps, discounted return −12"),
        (
            {"found_targets": ("Cup", "Hat"), "discounted_return": 312.2},
            "Found Cup and Hat in 5 steps, discounted return 312",
        ),
    ],
)
def test_the_title_says_how_it_ended(cleveland: CityMap, changes: dict, message: str) -> None:
    assert outcome(short_search(cleveland, **changes)) == message


def test_a_search_of_no_steps_can_be_drawn(cleveland: CityMap) -> None:
    still = short_search(
        cleveland,
        poses=((0.0, 0.0, math.pi / 2),),
        actions=(),
        observations=(),
        rewards=(),
        found_targets=(),
        views=np.zeros((1, *cleveland.grid.shape), dtype=bool),
    )
    ax = plot_search(still, cleveland, ax=Figure().add_subplot())
    assert ax.get_title().startswith("Found nothing in 0 steps")
    assert ax.get_xlim() == (-100, 105)


def test_seen_cells_are_denser_where_they_were_seen_more_often() -> None:
    views = np.zeros((3, 2, 2), dtype=bool)
    views[0, 0, 0] = views[1, 0, 0] = views[1, 1, 1] = True
    image = seen_image(views, (2, 2), alpha=0.2)
    assert image[..., 3].tolist() == [
        [pytest.approx(1 - 0.8**2), 0.0],
        [0.0, pytest.approx(0.2)],
    ]
    assert image[0, 0, :3] == pytest.approx(to_rgb(ACCENTS["view"]))


def test_the_robot_points_where_it_faces() -> None:
    for degrees in (0, 45, 90, 225):
        tip = np.asarray(robot_path(math.radians(degrees)).vertices)[0]
        assert math.degrees(math.atan2(tip[1], tip[0])) % 360 == pytest.approx(degrees)


def test_numbered_steps_are_few_and_apart() -> None:
    poses = [(float(3 * i), 0.0, 0.0) for i in range(201)]
    steps = sparse_steps(poses, 200.0)
    assert 5 <= len(steps) <= 14
    assert all(b - a == 20 for a, b in itertools.pairwise(steps))
    assert sparse_steps([(0.0, 0.0, 0.0)] * 50, 200.0) == [5]
    assert sparse_steps([(0.0, 0.0, 0.0)], 200.0) == []


def test_points_along_a_path_leave_no_gap() -> None:
    points = along([(0.0, 0.0, 0), (0.0, 0.0, 45), (12.0, 0.0, 45), (12.0, 7.0, 90)], 5.0)
    assert points[0] == (0.0, 0.0)
    assert points[-1] == (12.0, 7.0)
    assert max(math.dist(a, b) for a, b in itertools.pairwise(points)) <= 5.0


def test_beliefs_together_are_each_scaled_to_their_peak(cleveland: CityMap) -> None:
    one, other = blob(cleveland, -50, -50, 5), blob(cleveland, 50, 50, 20)
    both = together({"Cup": one, "Hat": other}, cleveland)
    assert both[cleveland.grid.cell_at(-47.5, -47.5)] == pytest.approx(1.0, abs=0.2)
    assert both.max() == 1.0
    assert both[np.unravel_index(other.argmax(), other.shape)] == pytest.approx(1.0)


def test_a_belief_of_another_shape_is_refused(cleveland: CityMap) -> None:
    with pytest.raises(InputError, match=r"The belief of 'Cup' has shape \(2, 2\)"):
        plot_search(
            short_search(cleveland),
            cleveland,
            ax=Figure().add_subplot(),
            beliefs={"Cup": np.ones((2, 2)) / 4},
        )
